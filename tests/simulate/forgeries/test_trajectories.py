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


@pytest.mark.parametrize("fps", [24.0, 60.0])
def test_late_lags_by_its_seconds_whatever_the_frame_rate(fps):
    """Catches: a lead instead of a lag; a delay in frames."""
    true = tangents(course())
    shown = tangents(false_camera("late", course(), fps, seed=3))
    delay = round(LATE_S * fps)
    assert delay >= 5
    assert np.allclose(shown[delay:], true[:-delay])
    assert np.allclose(shown[:delay], true[0])


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
