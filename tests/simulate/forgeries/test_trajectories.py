"""False trajectories: each kind by the property that defines it.  Each test says what it would catch.

Forgeries of more than one trajectory are tested in test_shown.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from moireid.simulate.forgeries.trajectories import (
    GAIN_HIGH,
    GAIN_LOW,
    LATE_S,
    TRAJECTORIES,
    WOBBLE,
    false_camera,
)
from moireid.simulate.motion import motion_named

FPS = 30.0


def course(count: int = 150, scale: float = 1.0) -> np.ndarray:
    """A camera course that is symmetric in nothing: other means, spreads and speeds on each axis, changing distance."""
    t = np.arange(count) / FPS
    x = 90.0 + scale * (140.0 * np.sin(2.1 * t) + 30.0 * np.cos(5.0 * t + 1.0))
    y = -35.0 + scale * 50.0 * np.sin(1.3 * t + 0.4)
    return np.column_stack([x, y, -1000.0 - 60.0 * np.sin(0.9 * t)])


def tangents(camera_mm: np.ndarray) -> np.ndarray:
    return camera_mm[:, :2] / np.abs(camera_mm[:, 2:])


@pytest.mark.parametrize("kind", TRAJECTORIES)
def test_the_distance_stays_true(kind):
    """Catches: forging the place instead of the tangent, which would also change the beat and give itself away."""
    true = course()
    shown = false_camera(kind, true, FPS, seed=3)
    assert shown.shape == true.shape
    assert np.array_equal(shown[:, 2], true[:, 2])
    assert np.abs(tangents(shown) - tangents(true)).max() > 0.04


@pytest.mark.parametrize(("kind", "gain"), [("gain_low", GAIN_LOW), ("gain_high", GAIN_HIGH), ("reversed", -1.0)])
def test_gains_are_exact_about_the_true_mean(kind, gain):
    """Catches: a gain about zero, which shifts the mean; a gain on one axis alone; a gain on millimetres."""
    true = tangents(course())
    shown = tangents(false_camera(kind, course(), FPS, seed=3))
    assert shown.mean(axis=0) == pytest.approx(true.mean(axis=0))
    assert np.allclose(shown - shown.mean(axis=0), gain * (true - true.mean(axis=0)))


def test_the_gains_are_wrong_enough_to_be_forgeries():
    """Catches: a constant changed to something that the optics' own tolerance allows (15 %)."""
    assert 0 < GAIN_LOW < 0.8 and GAIN_HIGH > 1.25


@pytest.mark.parametrize("kind", ["drift", "randomwalk", "splice"])
def test_mean_and_spread_are_the_true_ones(kind):
    """Catches: a forgery that its size gives away; the spread of one axis used for both."""
    true = tangents(course(601))
    shown = tangents(false_camera(kind, course(601), FPS, seed=3))
    assert shown.mean(axis=0) == pytest.approx(true.mean(axis=0))
    # A ramp of 601 steps has 1 + 1/601 of the spread of an unbroken one.
    assert shown.std(axis=0) == pytest.approx(true.std(axis=0), rel=0.003)


def test_drift_is_steady():
    """Catches: a drift in frames of a changing distance; a drift that bends."""
    shown = tangents(false_camera("drift", course(), FPS, seed=3))
    steps = np.diff(shown, axis=0)
    assert np.allclose(steps, steps[0]) and np.all(np.abs(steps[0]) > 1e-4)


def test_frozen_shows_the_first_frame_for_ever():
    """Catches: the mean view; a place frozen in millimetres, whose tangent would breathe with the distance."""
    shown = tangents(false_camera("frozen", course(), FPS, seed=3))
    assert np.allclose(shown, tangents(course())[0])


@pytest.mark.parametrize("fps", [24.0, 60.0])
def test_late_lags_by_its_seconds_whatever_the_frame_rate(fps):
    """Catches: a lead instead of a lag; a delay in frames."""
    true = tangents(course())
    shown = tangents(false_camera("late", course(), fps, seed=3))
    delay = round(LATE_S * fps)
    assert delay >= 5
    assert np.allclose(shown[delay:], true[:-delay])
    assert np.allclose(shown[:delay], true[0])


def test_a_random_walk_knows_nothing_of_the_truth():
    """Catches: noise added to the true course: the walk of one seed has one shape, whatever the truth is."""
    one = tangents(false_camera("randomwalk", course(), FPS, seed=3))
    mirrored = course(scale=-0.4)
    two = tangents(false_camera("randomwalk", mirrored, FPS, seed=3))
    shape_one = (one - one.mean(axis=0)) / one.std(axis=0)
    shape_two = (two - two.mean(axis=0)) / two.std(axis=0)
    assert np.allclose(shape_one, shape_two)
    assert abs(np.corrcoef(shape_one.T)[0, 1]) < 0.9


def test_a_random_walk_is_as_smooth_as_a_hand():
    """Catches: white noise, which any smoothing would expose.  Steps of a hand are small against its range."""
    shown = tangents(false_camera("randomwalk", course(600), FPS, seed=3))
    steps = np.diff(shown, axis=0).std(axis=0) / shown.std(axis=0)
    assert np.all(steps < 0.25) and np.all(steps > 0.02)


def test_a_splice_is_the_course_of_another_true_film():
    """Catches: a random course; a splice of the film itself; one axis cut from another second than the other."""
    shown = tangents(false_camera("splice", course(), FPS, seed=3))
    run = motion_named("handheld", distance_mm=1000.0, seed=0)
    clock = np.arange(150) / FPS
    best = 0.0
    for begin in np.arange(7.0, 20.0, 0.02):
        other = tangents(run(begin + clock).camera_mm)
        both = [np.corrcoef(shown[:, k], other[:, k])[0, 1] for k in (0, 1)]
        best = max(best, min(both))
    # The search's own step of 0.02 s is all that may be missing.
    assert best > 0.999
    assert abs(np.corrcoef(shown[:, 0], tangents(course())[:, 0])[0, 1]) < 0.9


def test_a_wobble_has_the_right_gain_and_a_wander_on_top():
    """Catches: a wander that changes the gain; one of another size; one that is white noise or a copy of the truth."""
    true, shown = tangents(course()), tangents(false_camera("wobble", course(), FPS, seed=3))
    for k in (0, 1):
        assert np.polyfit(true[:, k], shown[:, k], 1)[0] == pytest.approx(1.0, abs=1e-9)
    wander = shown - true
    assert wander.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert wander.std(axis=0) == pytest.approx(WOBBLE * true.std(axis=0))
    assert np.all(np.diff(wander, axis=0).std(axis=0) < 0.25 * wander.std(axis=0))


@pytest.mark.parametrize("kind", TRAJECTORIES)
def test_a_camera_at_rest_shows_no_forged_motion(kind):
    """Catches: NaN of a spread of zero, and a forgery that moves where the truth does not."""
    still = np.tile([40.0, -20.0, -900.0], (60, 1))
    assert np.allclose(false_camera(kind, still, FPS, seed=3), still, atol=1e-6)


def test_the_seed_decides_the_random_walk_and_nothing_else():
    """Catches: a global random state; a seed that is not passed on."""

    def shown(kind: str, seed: int) -> np.ndarray:
        return false_camera(kind, course(), FPS, seed)

    assert np.array_equal(shown("randomwalk", 3), shown("randomwalk", 3))
    assert np.abs(shown("randomwalk", 3) - shown("randomwalk", 4)).max() > 10
    assert np.array_equal(shown("drift", 3), shown("drift", 4))
