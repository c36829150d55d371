"""How many times likelier is what was measured of a true badge than of a forged one?

A forgery is exact in everything but one thing, and nobody says which.  So six kinds are held against the true badge,
each told by one figure; the others are as on a true one.  With g the density of a figure on true badges, f on forged
ones of the kind that shows in it, and w the kinds' shares,

    LR = 1 / sum_k w_k f_k / g_k,

because in each kind's likelihood all densities but its own cancel against the true badge's.

- *gain*: the fringes go too far, not far enough or the wrong way: any ratio from -2 to 3 alike;
- *wander*: a slow motion of the fringes' own; *jitter*: a fast one; *spell*: either, for a second;
- *strips*: rows of the badge move apart; *places*: parts of a row do.

All but the gain are from `LEAST_SHARE` to `MOST_SHARE` of the motion, each octave alike.  A figure is told as its
logarithm over what is expected of it by the known errors, normally distributed on true badges; a forger's share adds
to that in squares.  So a film with little motion, or of poor poses, comes out near 1 by itself: neither can be told.

Convention: natural densities, decadic logarithm of the ratio, held to +-`MOST_LOG10`.
Source: Bayes; means and spreads of the logarithms by `benchmarks/decision.py`, which also prints what they do to films
that they were not fitted on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Half of the tolerance that a gain is allowed (`invariant.GAIN_TOLERANCE`): sheets as sold scatter by that.
GAIN_SD = 0.075
LEAST_GAIN, GAIN_RANGE = -2.0, 5.0
#: The law is traced for the sheet as sold, flat and even; a true badge strays from it by this share of the motion.
LAW_SHARE = 0.02
LEAST_SHARE, MOST_SHARE = 0.1, 3.0
#: More certainty than this no model deserves.
MOST_LOG10 = 20.0
#: Verdicts by the ratio: 6.3 times likelier true than forged is accepted, ten times likelier forged is rejected.
#: A film that cannot tell one kind of the six at all has a ratio of 6 at most, and is left open.
ACCEPTED, REJECTED = 0.8, -1.0
#: Each kind in words.
KINDS = {
    "gain": "the fringes move too far, or not far enough",
    "wander": "the fringes drift slowly by themselves",
    "jitter": "the fringes drift or tremble by themselves",
    "spell": "the fringes do not follow the motion for a while",
    "strips": "the rows of the badge do not move together",
    "places": "places within a row do not move together",
}


@dataclass(frozen=True)
class Expected:
    """What true badges show of one figure: `share` of the error that is expected of a frame, `floor`, rad, and
    `LAW_SHARE` of the motion, in squares; mean and standard deviation of the logarithm of the figure over that.

    strip_share: share of a strip's own error bar in the figure's noise, held_share: of what rounding makes of a place;
    they count where they exceed the floor.
    """

    share: float
    floor: float
    mean: float
    sd: float
    strip_share: float = 0.0
    held_share: float = 0.0

    def scale_rad(
        self, error_rad: float, excitation_rad: float, strip_sd_rad: float = 0.0, held_rad: float = 0.0
    ) -> float:
        """The figure's unit."""
        floor = max(self.floor, self.strip_share * strip_sd_rad, self.held_share * held_rad)
        return math.hypot(self.share * error_rad, floor, LAW_SHARE * excitation_rad)


#: Smoothed poses leave white errors up to 3 Hz, of which a figure below 0.5 Hz sees 0.45.  Strips share the pose, so
#: neither they nor places within them know of its error.  Means and spreads as fitted, but no spread below 0.35:
#: cameras and sheets differ by more than those of one collection.  Pale fringes make strips vague: those of films made
#: outside wander by half of their error bars and more, and a twelfth of a strip over half a second is as vague.
#: What a codec holds of faint fringes is not so averaged: places err by all of it, and strips, of a few coding blocks
#: each, by half of it.
EXPECTED: dict[str, Expected] = {
    "wander": Expected(0.45, 0.010, -0.85, 0.55),
    "jitter": Expected(1.0, 0.015, -0.45, 0.35),
    "spell": Expected(1.0, 0.015, -0.08, 0.35),
    "strips": Expected(0.0, 0.010, -0.15, 0.35, strip_share=0.7, held_share=0.5),
    "places": Expected(0.0, 0.020, -0.05, 0.35, strip_share=0.7, held_share=1.0),
}


def log10_ratio(
    gain: float,
    gain_sd: float,
    figures: Mapping[str, float],
    excitation_rad: float,
    error_rad: float,
    expected: Mapping[str, Expected] = EXPECTED,
    *,
    strip_sd_rad: float = 0.0,
    held_rad: float = 0.0,
) -> tuple[float, str]:
    """The decadic logarithm of the likelihood ratio, and the kind of forgery that speaks most against the film.

    Parameters: figures: root mean squares, rad, by the names of `EXPECTED`; excitation_rad: spread of the predicted
        phase; error_rad: what is expected of one frame's error; strip_sd_rad: error bar of one strip in one frame;
        held_rad: as `fringe.held_rad`.
    Source: module docstring.
    """
    ratios = {"gain": _gain_ratio(gain, gain_sd)}
    for name, one in expected.items():
        unit = one.scale_rad(error_rad, excitation_rad, strip_sd_rad, held_rad)
        ratios[name] = _share_ratio(figures[name] / unit, excitation_rad / unit, one)
    likeliest = max(ratios, key=lambda name: ratios[name])
    most = ratios[likeliest]
    total = most + math.log(sum(math.exp(ratio - most) for ratio in ratios.values()) / len(ratios))
    return float(np.clip(-total / math.log(10), -MOST_LOG10, MOST_LOG10)), likeliest


def _gain_ratio(gain: float, gain_sd: float) -> float:
    """Logarithm of f / g of a gain, either blurred by the gain's error bar: a vague gain tells nothing."""
    sd = math.hypot(GAIN_SD, gain_sd)
    if not math.isfinite(sd):
        return 0.0
    gain = min(max(gain, LEAST_GAIN), LEAST_GAIN + GAIN_RANGE)
    true = -0.5 * ((gain - 1) / sd) ** 2 - math.log(sd * math.sqrt(2 * math.pi))
    ends = (LEAST_GAIN - gain, LEAST_GAIN + GAIN_RANGE - gain)
    below, above = (math.erf(end / max(gain_sd, 1e-6) / math.sqrt(2)) for end in ends)
    return math.log((above - below) / 2 / GAIN_RANGE) - true


def _share_ratio(figure: float, motion: float, one: Expected) -> float:
    """Logarithm of f / g of a figure, figure and motion over the figure's unit."""
    shares = np.geomspace(LEAST_SHARE, MOST_SHARE, 24)
    place = math.log(max(figure, 1e-6))
    forged = np.log(np.hypot(shares * motion, math.exp(one.mean)))
    # Below its mean a figure is no sign of a forgery; there both densities are taken at the mean.
    place = max(place, one.mean)
    true = -0.5 * ((place - one.mean) / one.sd) ** 2
    apart = -0.5 * ((place - forged) / one.sd) ** 2
    most = float(apart.max())
    return most + math.log(float(np.mean(np.exp(apart - most)))) - true
