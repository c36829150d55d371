"""How many times likelier is what was measured of a true badge than of a forged one?

A forgery is exact in everything but one thing, and nobody says which.  So six kinds are held against the true badge,
each told by one figure; the others are as on a true one.  With g the density of a figure on true badges, f on forged
ones of the kind that shows in it, and w the kinds' shares,

    LR = 1 / sum_k w_k f_k / g_k,

because in each kind's likelihood all densities but its own cancel against the true badge's.

- *gain*: the fringes go too far, not far enough or the wrong way: any ratio from -2 to 3 alike;
- *wander*: a slow motion of the fringes' own; *jitter*: a fast one; *spell*: either, for a second;
- *strips*: rows of the badge move apart; *places*: parts of a row do.

All but the gain are from `FORGED_MIN_SHARE` to `FORGED_MAX_SHARE` of the motion, each octave alike.  A figure is told
as its logarithm over what is expected of it by the known errors, normally distributed on true badges; a forger's share
adds to that in squares.  So a film with little motion, or of poor poses, comes out near 1 by itself: neither can be
told.

Convention: natural densities, decadic logarithm of the ratio, held to +-`MAX_CERTAINTY_LOG10`.
Source: Bayes; means and spreads of the logarithms by `benchmarks/decision.py`, which also prints what they do to films
that they were not fitted on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.limits import (
    EXPECTED,
    FORGED_GAIN_MAX_RATIO,
    FORGED_GAIN_MIN_RATIO,
    FORGED_MAX_SHARE,
    FORGED_MIN_SHARE,
    GAIN_SD_RATIO,
    LAW_MOTION_SHARE,
    MAX_CERTAINTY_LOG10,
    Expected,
)

Array = NDArray[np.float64]
#: Each kind in words.
KINDS = {
    "gain": "the fringes move too far, or not far enough",
    "wander": "the fringes drift slowly by themselves",
    "jitter": "the fringes drift or tremble by themselves",
    "spell": "the fringes do not follow the motion for a while",
    "strips": "the rows of the badge do not move together",
    "places": "places within a row do not move together",
}


def scale_rad(
    one: Expected, error_rad: float, excitation_rad: float, strip_sd_rad: float = 0.0, rounding_rad: float = 0.0
) -> float:
    """The unit of a figure, as `limits.Expected` has it; parameters as `log10_ratio`."""
    floor = max(one.floor_rad, one.strip_sd_share * strip_sd_rad, one.rounding_share * rounding_rad)
    return math.hypot(one.error_share * error_rad, floor, LAW_MOTION_SHARE * excitation_rad)


def log10_ratio(
    gain: float,
    gain_sd: float,
    figures: Mapping[str, float],
    excitation_rad: float,
    error_rad: float,
    expected: Mapping[str, Expected] = EXPECTED,
    *,
    strip_sd_rad: float = 0.0,
    rounding_rad: float = 0.0,
) -> tuple[float, str]:
    """The decadic logarithm of the likelihood ratio, and the kind of forgery that speaks most against the film.

    Parameters: figures: root mean squares, rad, by the names of `EXPECTED`; excitation_rad: spread of the predicted
        phase; error_rad: what is expected of one frame's error; strip_sd_rad: error bar of one strip in one frame;
        rounding_rad: as `strip_phase.rounding_rad`.
    Source: module docstring.
    """
    ratios = {"gain": _gain_ratio(gain, gain_sd)}
    for name, one in expected.items():
        unit = scale_rad(one, error_rad, excitation_rad, strip_sd_rad, rounding_rad)
        ratios[name] = _share_ratio(figures[name] / unit, excitation_rad / unit, one)
    likeliest = max(ratios, key=lambda name: ratios[name])
    most = ratios[likeliest]
    total = most + math.log(sum(math.exp(ratio - most) for ratio in ratios.values()) / len(ratios))
    return float(np.clip(-total / math.log(10), -MAX_CERTAINTY_LOG10, MAX_CERTAINTY_LOG10)), likeliest


def _gain_ratio(gain: float, gain_sd: float) -> float:
    """Logarithm of f / g of a gain, either blurred by the gain's error bar: a vague gain tells nothing."""
    sd = math.hypot(GAIN_SD_RATIO, gain_sd)
    if not math.isfinite(sd):
        return 0.0
    gain = min(max(gain, FORGED_GAIN_MIN_RATIO), FORGED_GAIN_MAX_RATIO)
    true = -0.5 * ((gain - 1) / sd) ** 2 - math.log(sd * math.sqrt(2 * math.pi))
    ends = (FORGED_GAIN_MIN_RATIO - gain, FORGED_GAIN_MAX_RATIO - gain)
    below, above = (math.erf(end / max(gain_sd, 1e-6) / math.sqrt(2)) for end in ends)
    return math.log((above - below) / 2 / (FORGED_GAIN_MAX_RATIO - FORGED_GAIN_MIN_RATIO)) - true


def _share_ratio(figure: float, motion: float, one: Expected) -> float:
    """Logarithm of f / g of a figure, figure and motion over the figure's unit."""
    shares = np.geomspace(FORGED_MIN_SHARE, FORGED_MAX_SHARE, 24)
    place = math.log(max(figure, 1e-6))
    forged = np.log(np.hypot(shares * motion, math.exp(one.mean_log)))
    # Below its mean a figure is no sign of a forgery; there both densities are taken at the mean.
    place = max(place, one.mean_log)
    true = -0.5 * ((place - one.mean_log) / one.sd_log) ** 2
    apart = -0.5 * ((place - forged) / one.sd_log) ** 2
    most = float(apart.max())
    return most + math.log(float(np.mean(np.exp(apart - most)))) - true
