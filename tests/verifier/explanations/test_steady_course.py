"""How often a drift or a delay would pass on a course.  Beside each test: what it would catch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from moireid.verifier.explanations.steady_course import chance_of_delay, chance_of_drift, chance_of_place

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.decision.judge import judge_signals
from moireid.verifier.fringes.beyond_phase import BeyondPhase
from moireid.verifier.fringes.depth_law import DepthLaw
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import FORGED_GAIN_MAX_RATIO, FORGED_GAIN_MIN_RATIO, GAIN_TOLERANCE_SHARE

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


def placed(course: np.ndarray, x_px: np.ndarray, stretch: np.ndarray | None = None) -> GratingSignal:
    """A true badge whose middle is at x_px in the picture, and trembles up and down."""
    y_px = 360 + 3 * np.random.default_rng(2).standard_normal(240)
    none = np.zeros(240)
    beyond = BeyondPhase(course, DepthLaw(none, none, none), none.astype(complex), np.column_stack([x_px, y_px]))
    made = signal(course, course - course.mean(), stretch)
    return replace(made, predicted_rad=within_stretches(made.predicted_rad, made.stretch), beyond=beyond)


#: Turning the badge moves the fringes and leaves its place: 0.7 rad to and fro at another pace.
TURN = 0.7 * np.sin(2 * np.pi * 0.55 * TIMES + 1.0)
#: By a shift before a still camera of 1150 px focal length, 1 rad is 180 px.
SHIFTED_PX = 640 + 180 * SWAY


def test_a_badge_that_only_shifts_sideways_can_be_told_by_its_place():
    """Catches: a place in page millimetres, a slope that must be right in pixels, one direction of two alone."""
    window = 2 * GAIN_TOLERANCE_SHARE / (FORGED_GAIN_MAX_RATIO - FORGED_GAIN_MIN_RATIO)
    for x_px in (SHIFTED_PX, 1280 - SHIFTED_PX, 0.3 * SHIFTED_PX):
        assert chance_of_place(placed(SWAY, x_px), as_the_law) == pytest.approx(window, rel=0.25)
    upright = placed(SWAY, SHIFTED_PX)
    assert upright.beyond is not None
    swapped = replace(upright, beyond=replace(upright.beyond, place_px=upright.beyond.place_px[:, ::-1]))
    assert chance_of_place(swapped, as_the_law) == pytest.approx(window, rel=0.25)


def test_a_badge_that_turns_too_or_a_camera_that_follows_it_cannot():
    """Catches: a place that is fitted frame by frame, and so tells everything."""
    assert chance_of_place(placed(SWAY + TURN, SHIFTED_PX), as_the_law) == 0.0
    assert chance_of_place(placed(SWAY, 640 + 60 * TURN), as_the_law) == 0.0
    assert chance_of_place(placed(SWAY, np.full(240, 640.0)), as_the_law) == 0.0
    assert chance_of_place(signal(SWAY), as_the_law) == 0.0


def test_places_after_a_cut_have_a_constant_of_their_own():
    """Catches: a take from elsewhere that seems to take fringes away from the badge's place."""
    stretch = (TIMES >= 4).astype(np.int64)
    elsewhere = placed(SWAY, SHIFTED_PX + 300 * stretch, stretch)
    assert chance_of_place(elsewhere, as_the_law) == chance_of_place(placed(SWAY, SHIFTED_PX, stretch), as_the_law) > 0


@pytest.mark.parametrize(("turned", "level"), [(0.0, "undecided"), (1.0, "pass")])
def test_a_shift_alone_is_left_open_with_the_advice_to_turn(turned, level):
    """Catches: a chance that is counted and not acted upon; a badge left open that turns as a hand's does."""
    outcome = judge_signals([placed(SWAY + turned * TURN, SHIFTED_PX)])
    (steady,) = [reason for reason in outcome.reasons if reason.code == "steady"]
    assert steady.level == level and ("turn it a little" in steady.text) == (level == "undecided")
    assert outcome.verdict == ("accept" if level == "pass" else "inconclusive")
    assert level == "pass" or "place in the picture" in steady.text
