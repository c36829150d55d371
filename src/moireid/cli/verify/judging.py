"""The film judged: in this process, or in another one where this one holds a key to sign with; and the pages of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.cli.attest.signing import Signing
from moireid.cli.common import say
from moireid.cli.verify.options import Wish

if TYPE_CHECKING:
    from moireid.provenance import Claimed
    from moireid.verifier import Claim
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.report.pictures import Pictures
    from moireid.verifier.session.result import Report

Progress = Callable[[int, int | None], None]
Scores = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Outcome:
    """A report as JSON; with what its pages are drawn of: pictures and signals, made when they are asked for."""

    document: dict[str, Any]
    drawn: Callable[[], tuple[Pictures, str]]


def claim_held(wish: Wish, found: Claimed) -> Claim:
    """What the film is held against."""
    from moireid.verifier import Claim
    from moireid.verifier.limits import MIN_COVER_SHARE

    return Claim(
        found.badge,
        found.badge.id,
        wish.focal_px,
        found.as_built,
        wish.require_original,
        found.provenance,
        MIN_COVER_SHARE if wish.cover_share is None else wish.cover_share,
        wish.photographs or 0,
        seal=found.seal,
    )


def judge_here(wish: Wish, found: Claimed, scores: Scores, progress: Progress) -> Outcome:
    """The outcome of a film that is decoded in this process."""
    from moireid.verifier.report.page import signals_csv
    from moireid.verifier.report.pictures import pictures_of

    report = replace(_report(wish, found, progress), detectors=scores)
    return Outcome(report.to_json(), lambda: (pictures_of(report), signals_csv(report)))


def _report(wish: Wish, found: Claimed, progress: Progress) -> Report:
    from moireid.verifier.published.corners import corners_from, without_corners

    corners = corners_from(wish.corners_given) if wish.corners_given is not None else None
    claim = claim_held(wish, found)
    if wish.published:
        from moireid.verifier.published.pipeline import verify_published

        return verify_published(wish.video, claim, corners=corners, progress=progress)
    from moireid.attest.carried import with_carried
    from moireid.verifier import verify

    report = verify(wish.video, claim, barred=found.barred, overlap=wish.overlap, progress=progress)
    return with_carried(without_corners(report) if corners else report, wish.video)


def judge_apart(wish: Wish, found: Claimed, scores: Scores, progress: Progress) -> Outcome:
    """The outcome of a film that is decoded in a process without the key.

    Convention: the claim is this process's own word, and so is the registry; the other one says what the film shows.
    """
    from moireid.attest.apart import Order, judged_apart
    from moireid.sandbox.seal import missing

    pictures = wish.report_folder is not None
    order = Order(wish.video, claim_held(wish, found), found.barred, wish.overlap, scores, pictures)
    judged, standing = judged_apart(order, progress), found.provenance.standing
    if (lacking := missing(judged.sealed)) is not None:
        say(f"note: the process that read the film {lacking}: this system has no means against that")
    own = {
        "registry": standing.to_json() if standing else None,
        "claim_source": found.provenance.source,
        "badge": {"id": found.badge.id, "name": found.badge.name},
    }
    return Outcome(judged.report | own, lambda: (judged.pictures, judged.signals))


def plan_pages(folder: Path | None, *, overwrite: bool, kept: Sequence[Path | None]) -> None:
    """Raise SpecError where a page would be in the way of a file, or of one of those that are read."""
    if folder is not None:
        from moireid.files import planned
        from moireid.verifier.report.page import report_paths

        planned(report_paths(folder), overwrite=overwrite, kept=kept)


def write_pages_of(outcome: Outcome, signing: Signing | None, known: Circumstances, wish: Wish) -> dict[str, Any]:
    """Sign the report where that is asked for, then write its pages; gives the report as it was signed."""
    document = outcome.document
    if signing is not None:
        document = signing.write(document, wish.video)
    if wish.report_folder is not None:
        from moireid.verifier.report.page import write_pages

        page, *_ = write_pages(document, *outcome.drawn(), known, wish.report_folder, overwrite=wish.overwrite)
        say(f"report: {page}")
    return document
