"""verify and identify: a film in, a verdict out."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

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
    tell_standing,
    trust_option,
)
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.registry import Claimed
    from moireid.verifier.reasons import Reason

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


MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}


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
@click.option(
    "--bundle",
    "bundle_path",
    type=click.Path(path_type=Path, dir_okay=False),
    help="A file of `moireid registry publish`, instead of --registry: it needs no network and no access to one.",
)
@trust_option
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
@overwrite_option
@json_option
@friendly
def verify_command(
    video: Path,
    claim: str | None,
    registry_url: str | None,
    badge_json: Path | None,
    bundle_path: Path | None,
    trust: str | None,
    focal_px: float | None,
    report_folder: Path | None,
    require_original: bool | None,
    overlap: bool,
    cover_share: float | None,
    photographs: int | None,
    pipeline: str,
    corners_given: str | None,
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
    if (claim is None) == (badge_json is None):
        raise SpecError("give either --claim NAME|ID (with --registry) or --badge badge.json")
    found = _claimed(claim, badge_json, registry_url, bundle_path, trust)
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
    held = replace(held, seal=found.seal)
    with progress_bar("reading the film") as progress:
        if pipeline == "published":
            report = verify_published(video, held, corners=corners, progress=progress)
        else:
            report = verify(video, held, revoked=found.revoked, overlap=overlap, progress=progress)
            report = without_corners(report) if corners else report
    if report_folder is not None:
        from moireid.verifier.report.page import write_report

        page, *_ = write_report(report, report_folder, overwrite=overwrite)
        say(f"report: {page}")
    if as_json:
        show_json(report.to_json())
    else:
        from moireid.verifier.report.page import holder_words, words_of

        source = report.claim_source
        whose = "" if source == "file" and badge.id else "badge of "
        click.echo(f"{report.verdict.upper()}: {whose}{holder_words(badge.name, badge.id, source)}")
        click.echo(words_of(report.verdict, report.invariant.verdict, report.identity.verdict, source))
        _show_reasons(report.reasons)
    sys.exit(VERDICT_EXIT[report.verdict])


def _claimed(
    claim: str | None, badge_json: Path | None, registry_url: str | None, bundle_path: Path | None, trust: str | None
) -> Claimed:
    """The badge that is claimed; of a file the registry's own where one is given that holds it."""
    from moireid.badge import load_badge
    from moireid.provenance import Claimed

    if bundle_path is not None:
        return _claimed_in_bundle(bundle_path, claim, registry_url, trust)
    if trust is not None and badge_json is not None and registry_url is None:
        raise SpecError(
            "--trust is of a registry, and none is asked with --badge alone; add --registry, or leave it out"
        )
    badge = load_badge(badge_json) if badge_json is not None else None
    if badge is not None and registry_url is None:
        return Claimed(badge)
    from moireid.registry import claimed, claimed_by_file, open_registry

    with open_registry(registry_url, create=False) as registry:
        standing = registry.standing(trust)
        tell_standing(standing)
        found = claimed(registry, claim or "") if badge is None else claimed_by_file(registry, badge)
    return replace(found, provenance=replace(found.provenance, standing=standing))


def _claimed_in_bundle(bundle_path: Path, claim: str | None, registry_url: str | None, trust: str | None) -> Claimed:
    """The badge that is claimed, by a bundle alone."""
    from moireid.registry.bundle.held import Bundle

    if registry_url is not None or claim is None:
        raise SpecError("--bundle stands in the place of --registry, and goes with --claim; leave the other one out")
    with Bundle(bundle_path, trust) as bundle:
        tell_standing(bundle.standing)
        return bundle.claimed(claim)


@click.command("identify")
@click.argument("video", type=click.Path(path_type=Path))
@registry_option
@trust_option
@focal_option
@json_option
@friendly
def identify_command(
    video: Path, registry_url: str | None, trust: str | None, focal_px: float | None, as_json: bool
) -> None:
    """Find out whose badge a film shows.

    Everyone in the registry is considered, and no claim is needed.

    Exit code 0: found; 1: nobody enrolled; 2: bad input; 3: inconclusive.
    """
    from moireid.registry import People, open_registry
    from moireid.verifier.session.identify import identify
    from moireid.verifier.video import Film

    Film(video)
    with open_registry(registry_url, create=False) as registry, progress_bar("reading the film") as progress:
        standing, people = registry.standing(trust), People(registry)
        tell_standing(standing)
        outcome = identify(video, registry.layouts(), people, focal_px=focal_px, progress=progress)
        name = people.name(outcome.found_id)
    if as_json:
        show_json(outcome.to_json() | {"found_name": name, "registry": standing.to_json()})
    else:
        who = f"{name} ({outcome.found_id})" if name is not None else "nobody known"
        click.echo(f"{outcome.finding.upper()}: {who}")
        _show_reasons(outcome.reasons)
    sys.exit({"found": ACCEPT, "nobody": REJECT, "inconclusive": INCONCLUSIVE}[outcome.finding])


def _show_reasons(reasons: tuple[Reason, ...]) -> None:
    for reason in reasons:
        click.echo(f"  {MARKS[reason.level]} {reason.text}")
