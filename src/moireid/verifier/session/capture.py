"""Enrolment captures: films of a freshly built badge, from which its as-built figures are measured.

The verifier must accept a capture as the issued badge in motion; otherwise nothing is measured from it.  Only the gain
is free, within `ENROLLED_GAINS`: it depends on the sheet that the maker bought, and on how flat it is on the page.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

from moireid.asbuilt import AsBuilt, merge
from moireid.badge import Badge
from moireid.errors import DesignError, MediaError
from moireid.files import AnyPath
from moireid.question import KnownCamera, Question
from moireid.verifier.decision.judge import Invariant
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.compare_built import agree, filmed_built
from moireid.verifier.session.film import verify
from moireid.verifier.session.refusal import build_findings
from moireid.verifier.session.result import Report
from moireid.verifier.tracking.track import Track
from moireid.verifier.video import Progress


def capture_as_built(
    videos: Sequence[AnyPath],
    badge: Badge,
    *,
    camera: KnownCamera | None = None,
    measured_scale: float | None = None,
    track: int | None = None,
    progress: Progress | None = None,
) -> AsBuilt:
    """As-built figures of `badge` from one or more films of it.

    Parameters: camera: as in `Question`; measured_scale: length of the scale bar by a ruler over its nominal
        length; it is only recorded; track: of each film, as in `verify`.
    Convention: as `AsBuilt`.
    Raises: MediaError if a film cannot be read or does not show this badge in motion; DesignError for a board
        without an identity.
    Source: `verify`, then `compare_built.filmed_built` of each film, merged.
    """
    if badge.id is None:
        raise DesignError("a board without an identity cannot be enrolled as built; print a badge with one")
    parts = []
    for video in videos:
        question = Question(badge, badge.id, camera=camera, track=track, enrolling=True)
        report = verify(video, question, progress=progress)
        built = built_in(report)
        if built is None:
            raise MediaError(
                f"capture {video} cannot be used: {why_refused(report)} Film the badge again, moving it sideways."
            )
        parts.append(built)
    check_builds(parts, videos, badge)
    return replace(merge(parts), measured_scale=measured_scale)


def built_in(report: Report) -> AsBuilt | None:
    """As-built figures of the badge in one film that was judged for an enrolment; None where it was not accepted."""
    if report.verdict != "accept" or report.measurement is None:
        return None
    return figures_in(report.track, report.measurement, report.invariant)


def figures_in(track: Track, measurement: Measurement, invariant: Invariant) -> AsBuilt:
    """As-built figures of the badge in an accepted film; invariant: of all of it, track and measurement of a part."""
    gain, gain_sd = invariant.gain_ratio or math.nan, invariant.gain_sd or math.nan
    return filmed_built(track, measurement, gain, gain_sd, invariant.third_harmonic)[0]


def why_refused(report: Report) -> str:
    """The first finding for which a film was not accepted, and what it shows of the badge's build, in sentences."""
    why = next((r.text for r in report.reasons if r.level in ("fail", "undecided")), "it was not accepted.")
    if report.measurement is None:
        return why
    return " ".join([why, *build_findings(report.measurement, report.track.badge, report.invariant.gain_ratio)])


def check_builds(parts: list[AsBuilt], videos: Sequence[AnyPath], badge: Badge) -> None:
    """Raise MediaError if two films do not agree on the gain of one sheet, or show two builds of the badge, whose mean
    would be a third one.
    """
    for (one, first), (other, second) in combinations(zip(parts, videos, strict=True), 2):
        pairs = agree(other, one, badge)
        gain = pairs.pop("gain")
        if gain.differs:
            raise MediaError(
                f"captures {first} and {second} differ in how far the fringes move ({gain.known:.3f} and "
                f"{gain.new:.3f} times the design; {gain.limit:.3f} apart at most for their error bars); film the "
                "badge again, each time with the sheet pressed flat and without zoom"
            )
        if any(pair.level == "differs" for pair in pairs.values()):
            limits = ", ".join(f"{pair.name} {pair.difference:.3g} {pair.unit}" for pair in pairs.values())
            raise MediaError(
                f"captures {first} and {second} show two builds of the badge ({limits} apart); enroll it with films of "
                "one badge"
            )
