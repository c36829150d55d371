"""Bounds of a share that hold whenever the draws stop.  Each docstring names the wrong code that the test catches."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier.explanations.strength import LookalikeShare, one_in, share_bounds
from moireid.verifier.limits import LEAST_STRENGTH, MOST_DRAWS, SHARE_UNSURE

ASKED = 1 / LEAST_STRENGTH


def test_without_a_hit_the_bound_is_known_in_closed_form():
    """Catches: a bound for one look that is used at each.  Closed form: (1 - p)^n (a + b + n ...) for a = 1."""
    for drawn in (20, 100, 500, 5000):
        low, high = share_bounds(0, drawn, ASKED)
        assert low == 0.0
        assert LEAST_STRENGTH / (LEAST_STRENGTH + drawn) / (1 - high) ** drawn == pytest.approx(
            1 / SHARE_UNSURE, rel=1e-6
        )
    assert share_bounds(0, 0, ASKED) == (0.0, 1.0)
    assert share_bounds(7, 7, ASKED)[1] == 1.0


@pytest.mark.claim("The bound of a strength holds whenever the draws stop")
@pytest.mark.parametrize("share", [0.002, 0.02, 0.3])
def test_the_bounds_hold_however_often_one_looks(share, rng):
    """Catches: bounds of a fixed number of draws, which ten looks break several times as often."""
    wrong = 0
    for _ in range(400):
        alike = np.cumsum(rng.binomial(500, share, 10))
        found = [share_bounds(int(hits), 500 * (k + 1), ASKED) for k, hits in enumerate(alike)]
        wrong += any(not low <= share <= high for low, high in found)
    # Four standard deviations above one in a hundred.
    assert wrong / 400 <= SHARE_UNSURE + 4 * math.sqrt(SHARE_UNSURE / 400)


def test_more_draws_tell_more(rng):
    """Catches: a bound that never closes."""
    widths = [np.subtract(*share_bounds(draws // 50, draws, ASKED)[::-1]) for draws in (500, 1000, 5000)]
    assert widths == sorted(widths, reverse=True) and widths[-1] < 0.015


def test_the_strength_is_that_of_the_upper_bound_rounded_down():
    """Catches: a strength by the estimate, which is infinite where none of a few looks alike; one rounded up."""
    share = LookalikeShare.of(0, 400, ASKED)
    assert share.share == 0.0 and one_in(share.at_most) == 59
    assert one_in(1.0) == 1 and one_in(0.02) == 50 and one_in(0.0201) == 49


@pytest.mark.parametrize(("chance", "below", "above"), [(0.06, 0.018, 0.022), (0.5, 0.0148, 0.026)])
def test_all_draws_decide_shares_but_for_those_next_to_what_is_asked(chance, below, above):
    """Catches: bounds that are closest elsewhere; a chance that is left out.  The figures are those of `MOST_DRAWS`."""
    few, many = (
        LookalikeShare.of(round(share / chance * MOST_DRAWS), MOST_DRAWS, ASKED, chance) for share in (below, above)
    )
    assert few.at_most < ASKED < many.at_least
    assert LookalikeShare.of(0, 0, ASKED, chance).at_most == chance
