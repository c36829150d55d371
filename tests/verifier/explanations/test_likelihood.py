"""Odds over the law with a motion of its own on top.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier.explanations.residuals import own_motion_odds
from moireid.verifier.limits import FORGED_MAX_SHARE, FORGED_MIN_SHARE, MAX_RIVAL_LOG10, OWN_MOTION

MOTION, ERROR = 0.8, 0.02


def usual(motion: float = MOTION, error: float = ERROR) -> float:
    """What true badges show on average, rad."""
    return OWN_MOTION.quantile(0.0, OWN_MOTION.unit_rad(motion, error))


@pytest.mark.parametrize("times", [1.0, 1.7, 3.0, 10.0, 40.0])
def test_the_odds_are_those_of_two_densities(times):
    """Catches: natural logarithms; shares even in place of their octaves.  By numerical integration of both."""
    unit = OWN_MOTION.unit_rad(MOTION, ERROR)
    place = math.log(times * usual() / unit)
    shares = np.exp(np.linspace(math.log(FORGED_MIN_SHARE), math.log(FORGED_MAX_SHARE), 4001))
    middles = np.log(np.hypot(shares * MOTION / unit, math.exp(OWN_MOTION.mean_log)))
    true = math.exp(-0.5 * ((place - OWN_MOTION.mean_log) / OWN_MOTION.sd_log) ** 2)
    forged = np.mean(np.exp(-0.5 * ((place - middles) / OWN_MOTION.sd_log) ** 2))
    # Measured: 0.34 at most, as the mean over 24 shares gives both ends the weight of a whole step.
    assert own_motion_odds(times * usual(), MOTION, ERROR) == pytest.approx(math.log10(true / forged), abs=0.36)


def test_a_usual_true_badge_is_likelier_by_the_law():
    """Catches: odds of the rival over the law."""
    assert own_motion_odds(usual(), MOTION, ERROR) > MAX_RIVAL_LOG10


def test_an_error_of_pose_explains_a_motion():
    """Catches: poor poses rejected as a motion of their own."""
    clear, vague = (own_motion_odds(0.15, MOTION, error) for error in (0.02, 0.2))
    assert clear < -3 * MAX_RIVAL_LOG10 and vague > 0
