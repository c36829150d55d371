"""Odds over rivals that contain the law.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier.explanations.residuals import containing_odds, scale_rad
from moireid.verifier.limits import EXPECTED, FORGED_MAX_SHARE, FORGED_MIN_SHARE, MAX_RIVAL_LOG10, REJECTED_LOG10

MOTION, ERROR = 0.8, 0.02


def usual(motion: float = MOTION, error: float = ERROR) -> dict[str, float]:
    """What true badges show on average, rad."""
    return {name: math.exp(one.mean_log) * scale_rad(one, error, motion) for name, one in EXPECTED.items()}


@pytest.mark.parametrize("name", list(EXPECTED))
@pytest.mark.parametrize("times", [1.0, 1.7, 3.0, 10.0, 40.0])
def test_the_odds_are_those_of_two_densities(name, times):
    """Catches: natural logarithms; shares even in place of their octaves.  By numerical integration of both."""
    one = EXPECTED[name]
    unit = scale_rad(one, ERROR, MOTION)
    deviation = times * usual()[name]
    place = math.log(deviation / unit)
    shares = np.exp(np.linspace(math.log(FORGED_MIN_SHARE), math.log(FORGED_MAX_SHARE), 4001))
    middles = np.log(np.hypot(shares * MOTION / unit, math.exp(one.mean_log)))
    true = math.exp(-0.5 * ((place - one.mean_log) / one.sd_log) ** 2)
    forged = np.mean(np.exp(-0.5 * ((place - middles) / one.sd_log) ** 2))
    found = containing_odds(usual() | {name: deviation}, MOTION, ERROR)[name]
    # Measured: 0.34 at most, as the mean over 24 shares gives both ends the weight of a whole step.
    assert found == pytest.approx(math.log10(true / forged), abs=0.36)


def test_a_usual_true_badge_is_likelier_by_the_law():
    """Catches: odds of the rival over the law."""
    assert min(containing_odds(usual(), MOTION, ERROR).values()) > MAX_RIVAL_LOG10


@pytest.mark.parametrize("name", list(EXPECTED))
def test_each_deviation_counts_alone(name):
    """Catches: a deviation that is not compared, or that changes the odds of another."""
    before = containing_odds(usual(), MOTION, ERROR)
    after = containing_odds(usual() | {name: 0.4 * MOTION}, MOTION, ERROR)
    assert after.pop(name) < -REJECTED_LOG10
    before.pop(name)
    assert after == before


@pytest.mark.parametrize("name", ["rows", "places"])
def test_pale_fringes_make_rows_vague_and_not_forged(name):
    """Catches: noise of pale fringes taken for rows that move apart; an error bar that excuses any error."""
    figures = usual() | {name: 0.12}
    assert containing_odds(figures, MOTION, ERROR)[name] < -REJECTED_LOG10
    assert containing_odds(figures, MOTION, ERROR, strip_sd_rad=0.15)[name] > -MAX_RIVAL_LOG10
    assert containing_odds(figures, MOTION, ERROR, rounding_rad=0.2)[name] > -MAX_RIVAL_LOG10
    torn = usual() | {name: 0.8}
    assert containing_odds(torn, MOTION, ERROR, strip_sd_rad=0.15)[name] < -REJECTED_LOG10


def test_an_error_of_pose_explains_a_wander_and_no_row():
    """Catches: rows excused by the pose that they share."""
    figures = dict.fromkeys(EXPECTED, 0.15)
    clear, vague = (containing_odds(figures, MOTION, error) for error in (0.02, 0.2))
    assert clear["wander"] < -REJECTED_LOG10 and vague["wander"] > 0
    assert (clear["rows"], clear["places"]) == (vague["rows"], vague["places"])
