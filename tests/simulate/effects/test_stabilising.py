"""Rows that wobble, and shutters of either direction.  Each test names what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.takes import SIZE, a_take
from moireid.simulate.effects.table import KINDS, STRENGTHS, effect_named


@pytest.mark.parametrize("strength", STRENGTHS)
def test_rows_shift_against_each_other_by_the_skew_and_change_over_time(strength):
    """Catches: a whole picture that shifts; a skew of degrees taken for radians; the same skew in all frames."""
    take = a_take(120)
    begin = effect_named(f"jello:{strength}").begin
    assert begin is not None
    step, after = begin(take)
    assert after is take
    ramp = np.tile(np.clip(6.0 * (np.arange(SIZE[0]) - 299), 0, 255), (SIZE[1], 1)).astype(np.uint8)
    skews, means = [], []
    for number in range(120):
        shift = (step(number, ramp).astype(float) - ramp)[:, 315:326].mean(axis=1) / 6.0
        skews.append((shift[-10:].mean() - shift[:10].mean()) / SIZE[1])
        means.append(shift.mean())
    most = math.radians(KINDS["jello"].figures[STRENGTHS.index(strength)])
    assert np.abs(skews).max() == pytest.approx(most, rel=0.1) and np.abs(means).max() < 0.3
    assert min(skews) < -0.3 * most and max(skews) > 0.3 * most
