"""Do the fringes leave the law for a while?

In each window of the film the fringes are compared with the law, and with fringes that meanwhile stay still, go the
wrong way, or go half or twice as far.  A window's phase constant is free, so nothing outside of it counts.

Convention: a window's *slip* is its residual's projection on the law's own change there, rad times the root of blocks;
on an honest film slips scatter about 0, with outliers where a pose is poor.
Source: ratio of Student's t densities with `SPELL_FREEDOM` degrees of freedom, as outliers are common; its logarithm
    is lowered by that of the number of windows that are tried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.series import PhaseSeries
from moireid.verifier.limits import LEAST_SLIP_RAD, MIN_SPELL_MOTION_RAD, SPELL_FREEDOM, SPELL_GAINS, SPELLS_S

Array = NDArray[np.float64]
#: Time that a window may hold beyond its length, as a share: frames may be missing.
LONGER_SHARE = 0.5


@dataclass(frozen=True)
class Spell:
    """The window that most resembles a lie: log10 odds of the law over it, its gain, and when it begins and ends, s."""

    log10_odds: float
    gain: float
    start_s: float
    end_s: float


def worst_spell(series: PhaseSeries, residual_rad: Array) -> Spell | None:
    """The spell that is likeliest; None where no window holds enough of the law's motion.

    Parameters: residual_rad (N,): measured phase less the whole film's fit of the law, whose gain is then 1 here.
    """
    found = [spell for length in SPELLS_S if (spell := _worst_of(series, residual_rad, length)) is not None]
    return min(found, key=lambda spell: spell.log10_odds, default=None)


def _worst_of(series: PhaseSeries, residual_rad: Array, length_s: float) -> Spell | None:
    count = round(length_s / series.step_s) + 1
    if count < 4 or 2 * count > len(residual_rad):
        return None
    first, last = np.arange(len(residual_rad) - count + 1), np.arange(count - 1, len(residual_rad))
    whole = series.stretch[first] == series.stretch[last]
    whole &= series.times_s[last] - series.times_s[first] <= (1 + LONGER_SHARE) * length_s
    law, left = series.law_rad, residual_rad
    moved = _windows(law * law, count) - _windows(law, count) ** 2 / count
    along = _windows(law * left, count) - _windows(law, count) * _windows(left, count) / count
    size = np.sqrt(np.maximum(moved, 1e-18))
    slip = along / size
    # A ramp over a range R has a standard deviation of R / sqrt(12).
    tried = whole & (size >= MIN_SPELL_MOTION_RAD * math.sqrt(count / 12))
    if not tried.any():
        return None
    usual = max(1.4826 * float(np.median(np.abs(slip[whole]))), LEAST_SLIP_RAD * math.sqrt(count))
    by_law = np.log1p((slip[tried] / usual) ** 2 / SPELL_FREEDOM)
    windows = max(float(tried.sum()) / count, 1.0)
    worst: Spell | None = None
    for gain, unlikely in SPELL_GAINS.items():
        by_lie = np.log1p(((slip[tried] - (gain - 1) * size[tried]) / usual) ** 2 / SPELL_FREEDOM)
        odds = (SPELL_FREEDOM + 1) / 2 * (by_lie - by_law) / math.log(10) + math.log10(windows) + unlikely
        k = int(np.argmin(odds))
        if worst is None or odds[k] < worst.log10_odds:
            at = np.flatnonzero(tried)[k]
            worst = Spell(float(odds[k]), gain, float(series.times_s[first[at]]), float(series.times_s[last[at]]))
    return worst


def _windows(values: Array, count: int) -> Array:
    """Sums over each window of so many entries."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(sums[count:] - sums[:-count])
