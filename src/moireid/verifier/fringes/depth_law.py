"""The depth law: does the spacing of the fringes follow the camera's distance?

Nearer to the badge the fringes stand closer.  Along a strip that is a few thousandths of a radian for a hand's sway,
and hundreds of frames show it.  A photograph that is laid over a film keeps the spacing of the place where it was
taken.  So a table of photographs, indexed by parallax, has all that depends on parallax and nothing that depends on
distance; only the second is used here.

Convention: the gain is seen over predicted change of spacing: 1 on a genuine badge, 0 on such a table.
Source: `predicted_phase`; the change is 2 pi X g_eff / p_r times the change of 1 / |Cz| for a place X along the strip.
    Least squares of the left-over of `strip_shape` against slope times change, both without what the fit of each
    frame takes up (Frisch and Waugh 1933).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.predicted_phase import StripLaw
from moireid.verifier.fringes.sinusoid import left_of_rows
from moireid.verifier.fringes.strip_phase import StripPhase, harmonics_of
from moireid.verifier.fringes.strip_shape import StripShape

Array = NDArray[np.float64]
#: What depends on parallax is taken away as a polynomial of this degree.
DEGREE = 3


@dataclass(frozen=True)
class DepthLaw:
    """Evidence of one strip or grating, frame by frame; sums over frames, strips and gratings are evidence too.

    score (T,) and information (T,): the gain less 1 is the sum of scores over the sum of information; power (T,):
    information times the square of the predicted change along the strip, rad^2.
    """

    score: Array
    information: Array
    power: Array

    def __add__(self, other: DepthLaw) -> DepthLaw:
        """Both together."""
        return DepthLaw(self.score + other.score, self.information + other.information, self.power + other.power)

    def under(self, gain: float) -> DepthLaw:
        """The same where that many times the change of spacing is predicted.

        Source: what is left of the picture is regressed on the pattern, which grows as the prediction does.
        """
        score = gain * (self.score - (gain - 1) * self.information)
        return DepthLaw(score, gain**2 * self.information, gain**4 * self.power)

    def part(self, frames: NDArray[np.int64] | slice) -> DepthLaw:
        """The same in some frames."""
        return DepthLaw(self.score[frames], self.information[frames], self.power[frames])


def depth_law(
    shape: StripShape | None, law: StripLaw, found: StripPhase, parallax: Array, length_mm: float
) -> DepthLaw:
    """Evidence of one strip.

    Parameters: shape: of the strip; law, found: as in `strip_shape`; parallax (T,): of the camera, along the strip;
        length_mm: of the strip.
    Returns: all 0 if there are no fringes.
    Source: module docstring; information is in units of the strip's own noise, so that strips add up.
    """
    score, information, power = np.zeros((3, len(parallax)))
    if shape is None or shape.clear.sum() < 10 * DEGREE:
        return DepthLaw(score, information, power)
    seen = parallax[shape.clear] - parallax[shape.clear].mean()
    table = np.vander(seen / max(float(seen.std()), 1e-9), DEGREE + 1)
    change = law.phase_rad(found.frequency_per_mm)[shape.clear]
    change = change - table @ np.linalg.lstsq(table, change, rcond=None)[0]
    # Of each frame, the fit took up the background and these harmonics.
    taken = shape.columns[:, : 2 + 2 * harmonics_of(found.frequency_per_mm, length_mm)]
    pattern = left_of_rows(change.astype(np.float32) * shape.slope, taken)
    pattern -= pattern.mean(axis=0)
    noise = float(np.median(np.mean(shape.left**2, axis=1)))
    if noise > 0:
        score[shape.clear] = np.einsum("tn,tn->t", shape.left, pattern) / noise
        information[shape.clear] = np.einsum("tn,tn->t", pattern, pattern) / noise
        power[shape.clear] = information[shape.clear] * np.mean(change**2)
    return DepthLaw(score, information, power)
