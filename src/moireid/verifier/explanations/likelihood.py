"""Odds of the law over rivals that contain it: a motion of their own on top, or parts on clocks of their own.

Such a rival fits at least as well as the law, so it is judged by how large the deviation is that it explains.  On
honest films the logarithm of a deviation, over what known errors explain, is normally distributed; a forged deviation
adds in squares and is `FORGED_MIN_SHARE` to `FORGED_MAX_SHARE` of the motion, each octave equally likely.

| rival | deviation |
|---|---|
| `wander` | of the whole phase from the law |
| `rows` | of the worst strip from the others |
| `places` | of the places within a strip from the strip |

Convention: decadic logarithm of the law's odds, above 0 where the law is likelier.
Source: Bayes; means and standard deviations by `benchmarks/priors.py`.
"""

from __future__ import annotations

import math

import numpy as np

from moireid.verifier.limits import EXPECTED, FORGED_MAX_SHARE, FORGED_MIN_SHARE, Expected


def scale_rad(
    one: Expected, error_rad: float, excitation_rad: float, strip_sd_rad: float = 0.0, rounding_rad: float = 0.0
) -> float:
    """The unit of a deviation, defined in `limits.Expected`."""
    floor = max(one.floor_rad, one.strip_sd_share * strip_sd_rad, one.rounding_share * rounding_rad)
    return math.hypot(one.error_share * error_rad, floor, one.motion_share * excitation_rad)


def containing_odds(
    deviations_rad: dict[str, float],
    excitation_rad: float,
    error_rad: float,
    *,
    strip_sd_rad: float = 0.0,
    rounding_rad: float = 0.0,
) -> dict[str, float]:
    """The odds of the law over each rival.

    Parameters: deviations_rad: root mean squares by the rivals' names; excitation_rad: spread of the predicted phase;
        error_rad: expected error of one frame; strip_sd_rad: error bar of one strip in one frame; rounding_rad: as
        `strip_phase.rounding_rad`.
    """
    found = {}
    for name, one in EXPECTED.items():
        unit = scale_rad(one, error_rad, excitation_rad, strip_sd_rad, rounding_rad)
        found[name] = _log10_odds(deviations_rad[name] / unit, excitation_rad / unit, one)
    return found


def _log10_odds(deviation: float, motion: float, one: Expected) -> float:
    """Of one rival; deviation and motion are in the deviation's unit."""
    shares = np.geomspace(FORGED_MIN_SHARE, FORGED_MAX_SHARE, 24)
    forged = np.log(np.hypot(shares * motion, math.exp(one.mean_log)))
    # A deviation below the mean is not suspicious; both densities are then taken at the mean.
    place = max(math.log(max(deviation, 1e-6)), one.mean_log)
    true = -0.5 * ((place - one.mean_log) / one.sd_log) ** 2
    apart = -0.5 * ((place - forged) / one.sd_log) ** 2
    most = float(apart.max())
    return (true - most - math.log(float(np.mean(np.exp(apart - most))))) / math.log(10)
