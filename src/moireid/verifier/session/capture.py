"""Enrolment captures: films of a freshly built badge, from which its as-built figures are measured.

The verifier must accept a capture as the issued badge in motion; otherwise nothing is measured from it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from moireid.asbuilt import AsBuilt, merge
from moireid.badge import Badge
from moireid.errors import DesignError, MediaError
from moireid.verifier.identity.compare_built import measure_built
from moireid.verifier.session.claim import Claim
from moireid.verifier.session.film import verify
from moireid.verifier.video import Progress


def capture_as_built(
    videos: list[Path],
    badge: Badge,
    *,
    focal_px: float | None = None,
    measured_scale: float | None = None,
    progress: Progress | None = None,
) -> AsBuilt:
    """As-built figures of `badge` from one or more films of it.

    Parameters: measured_scale: length of the scale bar by a ruler over its nominal length; it is only recorded.
    Convention: as `AsBuilt`.
    Raises: MediaError where a film cannot be read or does not show this badge in motion; DesignError for a board
        without an identity.
    Source: `verify`, then `built.measure_built` of each film, merged.
    """
    if badge.id is None:
        raise DesignError("a board without an identity cannot be enrolled as built; print a badge with one")
    parts = []
    for video in videos:
        report = verify(video, Claim(badge, badge.id, focal_px), progress=progress)
        if report.verdict != "accept" or report.measurement is None:
            why = next((r.text for r in report.reasons if r.level in ("fail", "undecided")), "it was not accepted")
            raise MediaError(f"capture {video} cannot be used: {why} Film the badge again, moving it sideways.")
        parts.append(measure_built(report.track, report.measurement, report.invariant))
    return replace(merge(parts), measured_scale=measured_scale)
