"""How much of the fringes' way does a film show, and how much is between its views?

Each of a few true photographs obeys the law, and so does a film that shows them in turn.  But a camera that moves sees
the fringes pass all places of their way; photographs show as many places as there are photographs, however often.

Convention: a view is a fringe phase that differs from others by `REST_RAD`; it counts once, however long it is seen, so
that a badge may rest.  Phases in rad, one per frame, (T,).
Source: Gini's mean difference (1912): two views, drawn at random, are apart by 2 times the integral of F (1 - F) over
    the way, if F is the share of views below a place.  A gap between neighbouring views counts as unseen from
    `MAX_VIEW_GAP_SHARE` of that on.  n views at even distances are apart by 3 n / (n^2 - 1) of it, so fewer than 12 are
    few.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.limits import REST_RAD
from moireid.verifier.measuring import MAX_VIEW_GAP_SHARE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SeenWay:
    """The fringes' way and its part between views, each in rad, times the number of views; sums hold for chapters."""

    whole: float = 0.0
    unseen: float = 0.0

    def __add__(self, other: SeenWay) -> SeenWay:
        """Both together."""
        return SeenWay(self.whole + other.whole, self.unseen + other.unseen)

    @property
    def unseen_share(self) -> float:
        """What lies between views, over the whole; 0 where the fringes rest."""
        return self.unseen / self.whole if self.whole > 0 else 0.0


def views_of(phase_rad: Array) -> Array:
    """The share of a view that each frame is, (T,): one over the frames that show the same."""
    phase = np.sort(phase_rad)
    alike = np.searchsorted(phase, phase_rad + REST_RAD, "right") - np.searchsorted(phase, phase_rad - REST_RAD, "left")
    return np.asarray(1 / alike)


def seen_way(phase_rad: Array) -> SeenWay:
    """The way of one grating; phase_rad (T,): unwrapped, with one phase constant for all frames, finite."""
    phase = np.sort(phase_rad)
    views = np.cumsum(views_of(phase))
    if len(phase) < 2:
        return SeenWay()
    gap, below = np.diff(phase), views[:-1] / views[-1]
    passed = below * (1 - below) * gap
    few = gap > MAX_VIEW_GAP_SHARE * 2 * passed.sum()
    return SeenWay(float(views[-1] * passed.sum()), float(views[-1] * passed[few].sum()))
