"""How often a drift or a delay would pass on a course.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import FORGED_GAIN_MAX_RATIO, FORGED_GAIN_MIN_RATIO, GAIN_TOLERANCE_SHARE
from moireid.verifier.motion.judge import judge_signals
from moireid.verifier.motion.steady_course import chance_of_delay, chance_of_drift

TIMES = np.arange(240) / 30.0
SWEEP = 0.4 * (TIMES - TIMES.mean())
SWAY = 1.2 * np.sin(2 * np.pi * 0.4 * TIMES)


def signal(course: np.ndarray, measured: np.ndarray | None = None, stretch: np.ndarray | None = None) -> GratingSignal:
    return GratingSignal(
        course if measured is None else measured,
        course - course.mean(),
        np.full(240, 0.01),
        0.01,
        np.array([0.005, 0.01]),
        TIMES,
        np.array([0.02, 0.02]),
        stretch=np.zeros(240, np.int64) if stretch is None else stretch,
    )


def as_the_law(forged: GratingSignal) -> bool:
    """Stands for the judge: a signal passes if it is near the prediction, its gain within the tolerance."""
    power = float(forged.predicted_rad @ forged.predicted_rad)
    gain = float(forged.predicted_rad @ forged.measured_rad) / power
    left = forged.measured_rad - gain * forged.predicted_rad
    return abs(gain - 1) <= GAIN_TOLERANCE_SHARE and float(left.std()) < 0.1


def test_on_one_sweep_a_drift_passes_by_the_width_of_the_gain_s_window():
    """Catches: drifts of the right speed alone, or none: their chance is the window over the range of ratios."""
    window = 2 * GAIN_TOLERANCE_SHARE / (FORGED_GAIN_MAX_RATIO - FORGED_GAIN_MIN_RATIO)
    assert chance_of_drift(signal(SWEEP), as_the_law) == pytest.approx(window, rel=0.25)


def test_on_one_sweep_every_delay_passes():
    """Catches: a delayed course that stands still before its beginning, which no generator's does."""
    assert chance_of_delay(signal(SWEEP), as_the_law) == 1.0


def test_to_and_fro_neither_passes():
    """Catches: a drift held against the course's ends alone; delays forgotten on the way."""
    assert chance_of_drift(signal(SWAY), as_the_law) == 0.0
    assert chance_of_delay(signal(SWAY), as_the_law) == 0.0


def test_two_sweeps_in_opposite_ways_tell_a_drift():
    """Catches: a drift that turns where the film is cut, as none at constant speed does."""
    folded = np.where(TIMES < 4, TIMES, 8 - TIMES) * 0.4
    stretch = (TIMES >= 4).astype(np.int64)
    assert chance_of_drift(signal(folded, stretch=stretch), as_the_law) == 0.0


@pytest.mark.parametrize(("course", "level"), [(SWEEP, "undecided"), (SWAY, "pass")])
def test_a_true_badge_on_one_sweep_is_left_open(course, level):
    """Catches: a chance that is counted and not acted upon; a sway left open."""
    outcome = judge_signals([signal(course, course - course.mean())])
    assert {reason.code: reason.level for reason in outcome.reasons}["steady"] == level
    assert outcome.verdict == ("accept" if level == "pass" else "inconclusive")
