"""verify: is the badge in a film real, and is it the claimed one?

1. Find the claimed badge: in a registry, in a bundle, or in a file alone.
2. Judge the film, in a sealed process that was made before.
3. Look up what the registry or bundle says about the badge that was read.  This process does it, after the film is
   judged; a process that only decodes the film learns nothing but the claimed badge.
4. Sign the report and write its pages, if asked for.
5. Print the verdict: the result, what to do, and the findings, failures first.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.attest.signing import planned_signing, signing_options
from moireid.cli.common import (
    VERDICT_EXIT,
    GroupedCommand,
    camera_options,
    echo,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    say,
    show_json,
    track_option,
)
from moireid.cli.sealed_reader import sealed_reader, unsealed_option
from moireid.cli.verify.verify_options import claim_options, level_option
from moireid.cli.witness_options import witness_check
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.api.asking import ClaimContext
    from moireid.attest.credentials import Form
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.report.headline import Headline

MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}
#: Colours of a terminal, by what a headline or a finding says.
COLOURS = {"accept": "green", "pass": "green", "reject": "red", "fail": "red"}
COLOURS |= {"inconclusive": "yellow", "undecided": "yellow"}
#: Findings name no options, as pages show them too; these are the options that help, by code.
OPTIONS = {
    "focal": "--focal-px",
    "gain": "--focal-px, or enroll --capture",
    "lens": "--camera, or --focal-px",
    "built": "enroll --capture --replace",
    "copyable": "enroll --capture",
    "cover": "--cover",
    "tracks": "--track",
    "level": "--level, enroll --capture, or watch --challenge",
    "corners": "--pipeline published",
}


def show_verdict(
    word: str, document: Mapping[str, Any], known: Circumstances, headline: Headline | None = None
) -> None:
    """Print the headline, what it means and what to do; then the findings, failures first and passes last.

    headline: None for that of a film.
    """
    from moireid.verifier.report.finding_words import sorted_findings
    from moireid.verifier.report.headline import headline_of
    from moireid.verifier.report.rival_table import odds_line
    from moireid.verifier.report.seconds import seconds_of

    headline, found = headline or headline_of(document, known), sorted_findings(document["reasons"])
    echo(f": {headline.title}", lead=word, colour=COLOURS[headline.colour])
    echo(headline.text)
    echo(f"What to do: {headline.advice}")
    if (seconds := seconds_of(document)) is not None:
        echo(f"Seconds: {seconds.text}")
    if odds := odds_line(document):
        echo(f"Odds: {odds}")
    for finding in found.first + found.hold:
        option = OPTIONS.get(finding["code"], "") if finding["level"] in ("undecided", "note") else ""
        mark, colour = MARKS[finding["level"]], COLOURS.get(finding["level"])
        echo(f" {finding['text']}{f' ({option})' if option else ''}", lead=f"  {mark}", colour=colour)


#: Headings of the help.
GROUPS = {
    "Whose badge": "claim registry badge bundle trust checkpoint witness-key",
    "The film": "focal-px camera track unsealed pipeline",
    "What an acceptance needs": "level cover strength overlap",
    "Output": "report overwrite json",
    "Signed verdict": "sign attest c2pa",
}


@click.command("verify", cls=GroupedCommand, groups=GROUPS)
@click.argument("video", type=click.Path(path_type=Path))
@friendly
@witness_check
@claim_options
@camera_options
@track_option
@unsealed_option
@click.option(
    "--pipeline",
    type=click.Choice(["moireid", "published"]),
    default="moireid",
    help="Our method, or the published one (Qing et al. 2026) for comparison: correlation only, and no identity.",
)
@level_option
@click.option(
    "--cover",
    "cover_share",
    type=click.FloatRange(0, 1),
    help="Least share of the film that must be judged, 0 to 1; below it the film is inconclusive.  [default: 0.5]",
)
@click.option(
    "--strength",
    type=click.IntRange(50, 500),
    metavar="N",
    help="Accept only if at most 1 in N forgeries that know nothing of the law would look as the film does; with more "
    "the film is inconclusive.  [default: 50]",
)
@click.option(
    "--overlap",
    is_flag=True,
    help="Also require that the badge passes in front of the face for a second; needs moireid[face].",
)
@click.option(
    "--report",
    "report_folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write a report here: report.html, with plots, and its figures.",
)
@overwrite_option
@json_option
@signing_options
def verify_command(
    video: Path,
    claimed: AbstractContextManager[ClaimContext],
    claim_files: list[Path | None],
    unsealed: bool,
    pipeline: str,
    report_folder: Path | None,
    overwrite: bool,
    as_json: bool,
    key_file: Path | None,
    attest_file: Path | None,
    form: Form | None,
    **wanted: Any,
) -> None:
    """Check a film: is the badge real, and is it the claimed one?

    The fringes must move as the optics of a real badge demand, and the badge must spell the claimed identity. Say whose
    badge it should be with --claim, or give its file with --badge.

    Exit code 0: accepted; 1: rejected; 2: bad input; 3: inconclusive.
    """
    from moireid.api.film_check import judge
    from moireid.files import planned
    from moireid.verifier.report.report_page import report_paths

    if key_file is not None and unsealed:
        raise SpecError("--sign reads the film apart from the key, and --unsealed does not; leave one of them out")
    published, kept = pipeline == "published", [*claim_files, video, key_file]
    sign = planned_signing(video, key_file, attest_file, form, overwrite=overwrite, kept=kept)
    films = sealed_reader([video], unsealed=unsealed)
    with claimed as (found, look_up), films as reader:
        # The options of the film have the names of a question's fields.
        question = replace(found, published=published, **wanted)
        if published:
            _check_published(wanted, signed=sign is not None)
        if report_folder is not None:
            planned(report_paths(report_folder), overwrite=overwrite, kept=kept)
        with progress_bar("reading the film") as progress:
            check = judge(video, question, look_up, reader, progress, pictures=report_folder is not None)
    if sign is not None:
        check = replace(check, document=sign(check.document))
    if report_folder is not None:
        page, *_ = check.write(report_folder, overwrite=overwrite)
        say(f"report: {page}")
    if as_json:
        show_json(check.document)
    else:
        show_verdict(check.verdict.upper(), check.document, check.known)
    sys.exit(VERDICT_EXIT[check.verdict])


def _check_published(wanted: Mapping[str, Any], *, signed: bool) -> None:
    """Raise SpecError for what the published method cannot do; only verdicts of our own are signed."""
    if signed:
        raise SpecError("--sign is for verdicts of moireid's own pipeline; leave --pipeline published out")
    for name, asked in wanted.items():
        # Of a camera it takes the focal length.
        if asked is not None and asked is not False and not (name == "camera" and not asked.calibrated):
            option = "--cover" if name == "cover_share" else f"--{name}"
            raise SpecError(f"--pipeline published cannot check {option}; leave one of them out")
