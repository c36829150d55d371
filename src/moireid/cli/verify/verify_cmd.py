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
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.attest.signing import Signing, planned_signing, signing_options
from moireid.cli.common import VERDICT_EXIT, camera_held, echo, friendly, progress_bar, report_standing, say, show_json
from moireid.cli.sealed_reader import sealed_reader
from moireid.cli.verify.verify_options import ClaimWish, VerifyOptions, check_wish, verify_options
from moireid.cli.witness_options import require, witness_check

if TYPE_CHECKING:
    from moireid.api.asking import ClaimContext
    from moireid.provenance import ClaimedBadge
    from moireid.reading.film_orders import JudgingOrder
    from moireid.reading.film_reader import Reader
    from moireid.verifier import Claim
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.report.headline import Headline
    from moireid.verifier.report.report_page import Pictures


def files_read(wish: ClaimWish) -> list[Path | None]:
    """The files that are read of a claim, which no output may replace."""
    found = [wish.bundle_path, wish.badge_json]
    if wish.registry_url is None and (wish.claim is None or wish.bundle_path is not None):
        return found
    from moireid.registry.engine import own_file

    return [*found, own_file(wish.registry_url)]


def asked_of(wish: ClaimWish) -> AbstractContextManager[ClaimContext]:
    """The claimed badge, from a bundle, a registry or a file alone; a bundle stays open for the look-up."""
    from moireid.api.asking import AskingTerms, claim_in_bundle, claim_of_badge, claim_of_name

    terms = AskingTerms(wish.trust, report_standing, partial(require, wish.witness_check))
    if wish.bundle_path is not None:
        return claim_in_bundle(wish.claim or "", wish.bundle_path, terms)
    if wish.badge_json is not None:
        return claim_of_badge(wish.badge_json, wish.registry_url, terms)
    return claim_of_name(wish.claim or "", wish.registry_url, terms)


Progress = Callable[[int, int | None], None]


@dataclass(frozen=True)
class Outcome:
    """A report as JSON; and the pictures and signals for its pages, made when they are asked for."""

    document: dict[str, Any]
    drawn: Callable[[], tuple[Pictures, str]]


def claim_held(wish: VerifyOptions, found: ClaimedBadge) -> Claim:
    """What the film is checked against."""
    from moireid.verifier import Claim
    from moireid.verifier.limits import LEAST_STRENGTH, MIN_COVER_SHARE

    return Claim.of(
        found,
        focal_px=wish.focal_px,
        camera=camera_held(wish.camera_file, wish.focal_px),
        require_original=wish.require_original,
        cover_share=MIN_COVER_SHARE if wish.cover_share is None else wish.cover_share,
        level=wish.level,
        strength=LEAST_STRENGTH if wish.strength is None else wish.strength,
    )


def judged(wish: VerifyOptions, asked: ClaimContext, reader: Reader, progress: Progress) -> Outcome:
    """The outcome of a film.

    Convention: claim, registry, and how the film was read are stated by this process; what reads the film only reports
    what it shows.
    """
    from moireid.attest.film_credentials import with_carried
    from moireid.reading.film_reports import judged_film

    made = judged_film(_order(wish, asked.found), reader, progress)
    document = made.report | asked.stated()
    if not wish.published:
        document = with_carried(document, wish.video)
    return Outcome(document, lambda: (made.pictures, made.signals))


def _order(wish: VerifyOptions, found: ClaimedBadge) -> JudgingOrder:
    from moireid.reading.film_orders import JudgingOrder, published_method

    if wish.published:
        # Where the lab is missing, this is said before the film is read.
        published_method()
    claim, pictures = claim_held(wish, found), wish.report_folder is not None
    return JudgingOrder(
        wish.video, claim, found.barred, wish.overlap, pictures=pictures, pipeline=wish.pipeline, track=wish.track
    )


def plan_pages(folder: Path | None, *, overwrite: bool, kept: Sequence[Path | None]) -> None:
    """Raise SpecError if a page would replace a file, or one of those that are read."""
    if folder is not None:
        from moireid.files import planned
        from moireid.verifier.report.report_page import report_paths

        planned(report_paths(folder), overwrite=overwrite, kept=kept)


def write_pages_of(
    outcome: Outcome, signing: Signing | None, known: Circumstances, wish: VerifyOptions
) -> dict[str, Any]:
    """Sign the report if asked for, then write its pages; returns the report as it was signed."""
    document = outcome.document
    if signing is not None:
        document = signing.write(document, wish.video)
    if wish.report_folder is not None:
        from moireid.verifier.report.report_page import write_pages

        page, *_ = write_pages(document, *outcome.drawn(), known, wish.report_folder, overwrite=wish.overwrite)
        say(f"report: {page}")
    return document


MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}
#: Colours of a terminal, by what a headline or a finding says.
COLOURS = {"accept": "green", "pass": "green", "reject": "red", "fail": "red"}
COLOURS |= {"inconclusive": "yellow", "undecided": "yellow"}
#: Findings name no options, as pages show them too; these are the options that help, by code.
OPTIONS = {
    "focal": "--focal-px",
    "gain": "--focal-px, or enroll --capture",
    "lens": "--camera, or --focal-px",
    "built": "--no-require-original, or enroll --capture",
    "copyable": "enroll --capture",
    "cover": "--cover",
    "tracks": "--track",
    "level": "--level, enroll --capture, or watch --challenge",
    "corners": "--pipeline published",
}


def show_verdict(
    word: str, document: Mapping[str, Any], known: Circumstances, headline: Headline | None = None
) -> None:
    """Print the headline, what it means and what to do; then the findings, failures first, with the passes in one line.

    headline: None for that of a film.
    """
    from moireid.verifier.report.finding_words import sorted_findings
    from moireid.verifier.report.headline import headline_of
    from moireid.verifier.report.live_receipt import receipt_of
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
    for finding in found.first:
        option = OPTIONS.get(finding["code"], "") if finding["level"] in ("undecided", "note") else ""
        mark, colour = MARKS[finding["level"]], COLOURS.get(finding["level"])
        echo(f" {finding['text']}{f' ({option})' if option else ''}", lead=f"  {mark}", colour=colour)
    if found.hold:
        codes = ", ".join(dict.fromkeys(finding["code"] for finding in found.hold))
        echo(f" holds: {codes}", lead=f"  {MARKS['pass']}", colour=COLOURS["pass"])
    for one in document.get("live_checks", []):
        echo(f"  · {receipt_of(one).words}")


@click.command("verify")
@click.argument("video", type=click.Path(path_type=Path))
@verify_options
@signing_options
@friendly
@witness_check
def verify_command(**given: Any) -> None:
    """Check a film: is the badge real, and is it the claimed one?

    The fringes must move as the optics of a real badge demand, and the badge must spell the claimed identity. Say whose
    badge it should be with --claim, or give its file with --badge.

    Exit code 0: accepted; 1: rejected; 2: bad input; 3: inconclusive.
    """
    from moireid.verifier.report.live_receipt import attached, check_belongs, load_receipt

    wish = VerifyOptions(**given)
    check_wish(wish)
    receipts = [load_receipt(path) for path in wish.receipt_files]
    kept = [*files_read(wish), wish.video, wish.key_file, *wish.receipt_files]
    signing = planned_signing(
        wish.video, wish.key_file, wish.attest_file, wish.timestamp_url, wish.form, overwrite=wish.overwrite, kept=kept
    )
    films = sealed_reader([wish.video], unsealed=wish.unsealed)
    with asked_of(wish) as asked, films as reader:
        for receipt in receipts:
            check_belongs(receipt, asked.found, wish.video)
        plan_pages(wish.report_folder, overwrite=wish.overwrite, kept=kept)
        with progress_bar("reading the film") as progress:
            outcome = judged(wish, asked, reader, progress)
        outcome = replace(outcome, document=attached(outcome.document, receipts))
        known = asked.known(outcome.document, wish.claim)
    document = write_pages_of(outcome, signing, known, wish)
    if wish.as_json:
        show_json(document)
    else:
        show_verdict(document["verdict"].upper(), document, known)
    sys.exit(VERDICT_EXIT[document["verdict"]])
