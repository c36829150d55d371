"""verify and identify: a film in, a verdict out."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.attest.signing import detectors_from, planned_signing, registry_asked, signing_options
from moireid.cli.common import (
    ACCEPT,
    INCONCLUSIVE,
    REJECT,
    VERDICT_EXIT,
    FiniteRange,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    registry_option,
    say,
    show_json,
)
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.attest.credentials import Form
    from moireid.registry import Claimed, Registry
    from moireid.verifier.report.circumstances import Circumstances

#: From a report's JSON to what a registry knows of it.
LookUp = Callable[[Mapping[str, Any]], "Circumstances"]
MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}
#: Findings tell no options, as pages show them too; here is where each is said.
OPTIONS = {
    "focal": "--focal-px",
    "gain": "--focal-px, or enroll --capture",
    "built": "--no-require-original, or enroll --capture",
    "copyable": "enroll --capture",
    "cover": "--cover",
    "photographs": "--photographs",
    "corners": "--pipeline published",
}

focal_option = click.option(
    "--focal-px",
    type=FiniteRange(50, 100000),
    metavar="PX",
    help="The camera's focal length in pixels, if known; else it is estimated from the film.",
)


def _show_schema(context: click.Context, parameter: click.Parameter, asked: bool) -> None:
    """Print the schema and leave, before a film is asked for."""
    if asked and not context.resilient_parsing:
        from moireid.verifier.session.result import report_schema

        click.echo(report_schema(), nl=False)
        context.exit()


@click.command("verify")
@click.argument("video", type=click.Path(path_type=Path))
@click.option("--claim", metavar="NAME|ID", help="Whose badge it is said to be; looked up in the registry.")
@registry_option
@click.option(
    "--badge",
    "badge_json",
    type=click.Path(path_type=Path),
    help="The badge.json of the claimed badge, instead of --claim. Nobody vouches for the name in it, unless "
    "--registry is given too and holds the badge.",
)
@focal_option
@click.option(
    "--report",
    "report_folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write a report here: report.html, with plots, and its figures.",
)
@click.option(
    "--require-original/--no-require-original",
    default=None,
    help="Accept only the badge that was enrolled, and no copy of it; or accept copies too. Default: no copy where it "
    "was enrolled with --capture.",
)
@click.option(
    "--overlap",
    is_flag=True,
    help="Demand too that the badge passes in front of the face for a second; needs moireid[face].",
)
@click.option(
    "--cover",
    "cover_share",
    type=click.FloatRange(0, 1),
    help="Share of the film that the verdict must be of, 0 to 1; with less it is inconclusive.  [default: 0.5]",
)
@click.option(
    "--photographs",
    type=click.IntRange(0),
    help="So many photographs of the badge a forger must need to make such a film; with fewer it is inconclusive. "
    "[default: 0]",
)
@click.option(
    "--pipeline",
    type=click.Choice(["moireid", "published"]),
    default="moireid",
    show_default=True,
    help="Our method, or the published one (Qing et al. 2026) for comparison: correlation only, and no identity.",
)
@click.option(
    "--corners",
    "corners_given",
    metavar="X,Y,... | FILE.csv",
    help="For films that lost their markers, scored with --pipeline published: the striped region's corners (top left, "
    "top right, bottom right, bottom left; px) in the first frame, to be followed; corrections at later frames as "
    "FRAME:X,Y,... after a blank. Our own pipeline follows markers alone; where they are seen in less than half of the "
    "frames, it leaves such a film open.",
)
@click.option(
    "--schema",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_show_schema,
    help="Print the JSON Schema of what --json prints, and exit.",
)
@signing_options
@overwrite_option
@json_option
@friendly
def verify_command(
    video: Path,
    claim: str | None,
    registry_url: str | None,
    badge_json: Path | None,
    focal_px: float | None,
    report_folder: Path | None,
    require_original: bool | None,
    overlap: bool,
    cover_share: float | None,
    photographs: int | None,
    pipeline: str,
    corners_given: str | None,
    key_file: Path | None,
    attest_file: Path | None,
    timestamp_url: str | None,
    form: Form | None,
    detectors: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
) -> None:
    """Check a film: is the badge real, and is it the claimed one?

    The fringes must move as the optics of a real badge demand, and the badge must spell the claimed identity. Say whose
    badge it should be with --claim, or give its file with --badge.

    Exit code 0: accepted; 1: rejected; 2: bad input; 3: inconclusive.
    """
    from moireid.files import planned

    if pipeline == "published" and require_original is not None:
        raise SpecError("--pipeline published cannot do what --require-original asks for; leave one of them out")
    if pipeline == "published" and overlap:
        raise SpecError("--pipeline published cannot check --overlap; leave one of them out")
    if pipeline == "published" and cover_share is not None:
        raise SpecError("--pipeline published cannot check --cover; leave one of them out")
    if pipeline == "published" and photographs is not None:
        raise SpecError("--pipeline published cannot check --photographs; leave one of them out")
    if key_file is not None and (pipeline == "published" or corners_given is not None):
        raise SpecError("--sign is for verdicts of moireid's own pipeline, without --corners; leave one of them out")
    if (claim is None) == (badge_json is None):
        raise SpecError("give either --claim NAME|ID (with --registry) or --badge badge.json")
    outside = detectors_from(detectors)
    signing = planned_signing(video, key_file, attest_file, timestamp_url, form, overwrite=overwrite)
    found, look_up = _claimed(claim, badge_json, registry_url)
    badge = found.badge
    if report_folder is not None:
        from moireid.verifier.report.page import report_paths

        planned(report_paths(report_folder), overwrite=overwrite)
    from moireid.evaluation.baseline.corners import corners_from, without_corners
    from moireid.evaluation.baseline.published import verify_published
    from moireid.verifier import Claim, verify
    from moireid.verifier.limits import MIN_COVER_SHARE

    corners = corners_from(corners_given) if corners_given is not None else None
    least = MIN_COVER_SHARE if cover_share is None else cover_share
    held = Claim(badge, badge.id, focal_px, found.as_built, require_original, found.provenance, least, photographs or 0)
    with progress_bar("reading the film") as progress:
        if signing is not None:
            from moireid.attest.apart import Order, judged_apart

            order = Order(video, held, found.revoked, overlap, outside, report_folder is not None)
            judged = judged_apart(order, progress)
            document = judged.report
        else:
            if pipeline == "published":
                report = verify_published(video, held, corners=corners, progress=progress)
            else:
                from moireid.attest.carried import with_carried

                report = verify(video, held, revoked=found.revoked, overlap=overlap, progress=progress)
                report = with_carried(without_corners(report) if corners else report, video)
            report = replace(report, detectors=outside)
            document = report.to_json()
    known = replace(look_up(document), claim=claim, revoked_at=found.revoked_at)
    if signing is not None:
        document |= {"registry": registry_asked(found.provenance.source, registry_url)}
        document = signing.write(document, video)
    if report_folder is not None:
        from moireid.verifier.report.page import write_pages, write_report

        if signing is not None:
            page, *_ = write_pages(document, judged.pictures, judged.signals, known, report_folder, overwrite=overwrite)
        else:
            page, *_ = write_report(report, report_folder, overwrite=overwrite, known=known)
        say(f"report: {page}")
    if as_json:
        show_json(document)
    else:
        _show_verdict(document["verdict"].upper(), document, known)
    sys.exit(VERDICT_EXIT[document["verdict"]])


def _claimed(claim: str | None, badge_json: Path | None, registry_url: str | None) -> tuple[Claimed, LookUp]:
    """The badge that is claimed, of a file the registry's own where one is given that holds it; and a look-up of what
    the registry knows of a report.
    """
    from moireid.badge import load_badge
    from moireid.provenance import Claimed

    badge = load_badge(badge_json) if badge_json is not None else None
    if badge is not None and registry_url is None:
        return Claimed(badge), _unknown
    from moireid.registry import claimed, claimed_by_file, open_registry

    def look_up(document: Mapping[str, Any]) -> Circumstances:
        with open_registry(registry_url, create=False) as registry:
            return _known_by(registry, document)

    with open_registry(registry_url, create=False) as registry:
        found = claimed(registry, claim or "") if badge is None else claimed_by_file(registry, badge)
    return found, look_up


@click.command("identify")
@click.argument("video", type=click.Path(path_type=Path))
@registry_option
@focal_option
@json_option
@friendly
def identify_command(video: Path, registry_url: str | None, focal_px: float | None, as_json: bool) -> None:
    """Find out whose badge a film shows.

    Everyone in the registry is considered, and no claim is needed.

    Exit code 0: found; 1: nobody enrolled; 2: bad input; 3: inconclusive.
    """
    from moireid.registry import People, open_registry
    from moireid.verifier.session.identify import identify
    from moireid.verifier.video import Film

    Film(video)
    with open_registry(registry_url, create=False) as registry, progress_bar("reading the film") as progress:
        people = People(registry)
        outcome = identify(video, registry.layouts(), people, focal_px=focal_px, progress=progress)
        document = outcome.to_json() | {"found_name": people.name(outcome.found_id)}
        known = _known_by(registry, document)
    if as_json:
        show_json(document)
    else:
        _show_verdict(outcome.finding.upper(), document, known)
    sys.exit({"found": ACCEPT, "nobody": REJECT, "inconclusive": INCONCLUSIVE}[outcome.finding])


def _unknown(document: Mapping[str, Any]) -> Circumstances:
    """What is known where no registry is asked: the present time."""
    from moireid.verifier.report.circumstances import Circumstances

    return Circumstances(datetime.now(UTC))


def _known_by(registry: Registry, document: Mapping[str, Any]) -> Circumstances:
    """What a registry knows of a report: who holds the badge that was read, and whose word that is."""
    from moireid.registry import holder_of
    from moireid.verifier.report.circumstances import Circumstances, read_id

    read = holder_of(registry, read_id(document))
    return Circumstances(datetime.now(UTC), read=read, authority=registry.fingerprint, registry=registry.shown_url)


def _show_verdict(word: str, document: Mapping[str, Any], known: Circumstances) -> None:
    """Print the headline, what it means and what to do; then failures first, and what holds in one line."""
    from moireid.verifier.report.findings import sorted_findings
    from moireid.verifier.report.headline import headline_of
    from moireid.verifier.report.seconds import seconds_of

    headline, found = headline_of(document, known), sorted_findings(document["reasons"])
    click.echo(f"{word}: {headline.title}")
    click.echo(headline.text)
    click.echo(f"What to do: {headline.advice}")
    if (seconds := seconds_of(document)) is not None:
        click.echo(f"Seconds: {seconds.text}")
    for finding in found.first:
        option = OPTIONS.get(finding["code"], "") if finding["level"] in ("undecided", "note") else ""
        click.echo(f"  {MARKS[finding['level']]} {finding['text']}{f' ({option})' if option else ''}")
    if found.hold:
        click.echo(f"  ✓ holds: {', '.join(dict.fromkeys(finding['code'] for finding in found.hold))}")
    for one in document.get("detectors", []):
        click.echo(f"  · Detector {one['name']} gives {one['score']:g}; that is no part of the verdict.")
