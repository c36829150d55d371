"""Trajectories of attacks and mishaps.  Each test states what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.simulate.motion import Poses
from moireid_lab.bench.forgers.cases import (
    Shoot,
    moving,
    slides,
)
from moireid_lab.bench.forgers.motions import one_way

FPS, FRAMES, AWAY = 30.0, 120, 1000.0
TIMES = np.arange(FRAMES) / FPS


def middle_of(poses: Poses) -> np.ndarray:
    """Where the board's middle is seen, as tangents from the picture's middle, (T, 2); NaN behind the camera."""
    seen = -np.einsum("tij,tj->ti", poses.rotation, poses.camera_mm)
    return np.where(seen[:, 2:] > 0, seen[:, :2] / seen[:, 2:], np.nan)


def proper(poses: Poses) -> bool:
    """Whether all rotations are such, and mirror nothing."""
    unit = poses.rotation @ poses.rotation.transpose(0, 2, 1)
    return bool(np.allclose(unit, np.eye(3), atol=1e-9) and np.all(np.linalg.det(poses.rotation) > 0))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_one_sweep_goes_one_way_at_one_speed_and_keeps_the_badge_in_view(seed):
    """Catches: a sweep that turns, a camera that looks past the badge, two ways that are never both drawn."""
    poses = one_way(AWAY, seed, length_s=FRAMES / FPS)(TIMES)
    steps = np.diff(poses.camera_mm[:, 0])
    assert np.ptp(steps) < 1e-9 * AWAY and np.ptp(poses.camera_mm[:, 0]) > 350
    assert not poses.camera_mm[:, 1].any() and (poses.camera_mm[:, 2] == -AWAY).all()
    assert proper(poses) and np.abs(middle_of(poses)).max() < 0.1


def test_a_slide_show_rests_and_steps_to_true_places(ada):
    """Catches: photographs away from the trajectory; a step a frame early or late; a film at another rate."""
    shoot = Shoot(ada, 1000.0, 1, 240)
    filming, times = slides(0.25, 12.0)(shoot), np.arange(36) / 12
    shown, true = filming.motion(times).camera_mm, moving(shoot)(times).camera_mm
    assert filming.fps == 12.0 and filming.show is None
    assert shown == pytest.approx(np.repeat(true[::3], 3, axis=0))
