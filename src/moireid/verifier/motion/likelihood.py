"""How many times likelier are the measurements from a genuine badge than from a forged one?

A forgery is assumed to be exact in all but one respect, which is unknown.  So six kinds of forgery are compared with
the genuine badge.  Each kind shows in one figure; the other figures are as on a genuine badge.  With g the density of a
figure on genuine badges, f its density on forgeries of this kind, and w the share of each kind,

    LR = 1 / sum_k w_k f_k / g_k,

because all densities of a kind but its own cancel against those of the genuine badge.

- *gain*: the fringes move too far, not far enough or the wrong way: every ratio from -2 to 3 is equally likely;
- *wander*: a slow motion that does not follow the camera; *jitter*: a fast one; *spell*: either, for a second;
- *strips*: the rows of the badge move differently; *places*: parts of a row do.

Except for the gain, a forged deviation is `FORGED_MIN_SHARE` to `FORGED_MAX_SHARE` of the motion, each octave equally
likely.  A figure is used as the logarithm of its ratio to the value that known errors explain.  On genuine badges this
logarithm is normally distributed; a forged deviation adds in squares.  So a film with little motion or poor poses gets
a ratio near 1: it cannot decide.

Convention: densities by natural logarithm; decadic logarithm of the ratio, limited to +-`MAX_CERTAINTY_LOG10`.
Source: Bayes; means and standard deviations of the logarithms by `benchmarks/decision.py`, which also prints their
    effect on films outside the fit.
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
    """The unit of a figure, defined in `limits.Expected`; parameters as `log10_ratio`."""
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
    gain_spread: float = GAIN_SD_RATIO,
) -> tuple[float, str]:
    """The decadic logarithm of the likelihood ratio, and the likeliest kind of forgery.

    Parameters: figures: root mean squares, rad, by the names of `EXPECTED`; excitation_rad: spread of the predicted
        phase; error_rad: expected error of one frame; strip_sd_rad: error bar of one strip in one frame; rounding_rad:
        as `strip_phase.rounding_rad`; gain_spread: standard deviation of a genuine badge's gain about 1.
    Source: module docstring.
    """
    ratios = {"gain": _gain_ratio(gain, gain_sd, gain_spread)}
    for name, one in expected.items():
        unit = scale_rad(one, error_rad, excitation_rad, strip_sd_rad, rounding_rad)
        ratios[name] = _share_ratio(figures[name] / unit, excitation_rad / unit, one)
    likeliest = max(ratios, key=lambda name: ratios[name])
    most = ratios[likeliest]
    total = most + math.log(sum(math.exp(ratio - most) for ratio in ratios.values()) / len(ratios))
    return float(np.clip(-total / math.log(10), -MAX_CERTAINTY_LOG10, MAX_CERTAINTY_LOG10)), likeliest


def _gain_ratio(gain: float, gain_sd: float, spread: float) -> float:
    """Logarithm of f / g of a gain; both are blurred by its error bar, so a vague gain decides nothing."""
    sd = math.hypot(spread, gain_sd)
    if not math.isfinite(sd):
        return 0.0
    gain = min(max(gain, FORGED_GAIN_MIN_RATIO), FORGED_GAIN_MAX_RATIO)
    true = -0.5 * ((gain - 1) / sd) ** 2 - math.log(sd * math.sqrt(2 * math.pi))
    ends = (FORGED_GAIN_MIN_RATIO - gain, FORGED_GAIN_MAX_RATIO - gain)
    below, above = (math.erf(end / max(gain_sd, 1e-6) / math.sqrt(2)) for end in ends)
    return math.log((above - below) / 2 / (FORGED_GAIN_MAX_RATIO - FORGED_GAIN_MIN_RATIO)) - true


def _share_ratio(figure: float, motion: float, one: Expected) -> float:
    """Logarithm of f / g of a figure; figure and motion are in the unit of the figure."""
    shares = np.geomspace(FORGED_MIN_SHARE, FORGED_MAX_SHARE, 24)
    place = math.log(max(figure, 1e-6))
    forged = np.log(np.hypot(shares * motion, math.exp(one.mean_log)))
    # A figure below its mean is not suspicious; both densities are then taken at the mean.
    place = max(place, one.mean_log)
    true = -0.5 * ((place - one.mean_log) / one.sd_log) ** 2
    apart = -0.5 * ((place - forged) / one.sd_log) ** 2
    most = float(apart.max())
    return most + math.log(float(np.mean(np.exp(apart - most)))) - true
