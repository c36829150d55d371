"""Poses and smeared prints by the kernel, against NumPy and OpenCV.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.camera.plane_pose import DAMPING, MOST_TURN_RAD, rotations
from moireid.verifier.kernel.fitting import refined_poses, smeared_means

FRAMES, POINTS = 6, 16


@pytest.fixture
def view(rng):
    """As `view_of` so many points."""
    return view_of(rng, POINTS)


def view_of(rng, points):
    """A plane, its pictures from some poses, and two starts near each pose; another one for each frame."""
    plane = np.column_stack([rng.uniform(-60, 60, (points, 2)), np.zeros(points)])
    turn = rotations(rng.normal(0, 0.3, (FRAMES, 3)))
    shift = np.column_stack([rng.uniform(-200, 200, (FRAMES, 2)), rng.uniform(600, 1500, FRAMES)])
    local = plane @ turn.swapaxes(-1, -2) + shift[:, None]
    seen = local[..., :2] / local[..., 2:] + rng.normal(0, 2e-5, (FRAMES, points, 2))
    off = rotations(rng.normal(0, 0.1, (FRAMES, 2, 3)))
    return plane, seen, off @ turn[:, None], shift[:, None] + rng.normal(0, 5, (FRAMES, 2, 3))


def test_a_plane_behind_the_camera_or_without_extent_has_no_pose(view):
    """Catches: a pose from behind that counts as the best; a crash where the equations have no solution."""
    plane, seen, rotation, translation = view
    given = {"steps": 2, "damping": DAMPING, "most_turn": MOST_TURN_RAD}
    behind = translation * [1, 1, -1]
    assert np.isinf(refined_poses(plane, seen, None, rotation, behind, **given | {"steps": 0})[2]).all()
    for nothing in (np.zeros_like(plane), np.full_like(plane, np.nan), np.full_like(plane, np.inf)):
        left = refined_poses(nothing, seen, None, rotation, translation, **given)[2]
        assert np.isinf(left).all()


def test_drawings_of_other_sizes_are_refused():
    """Catches: C that works on memory which is not there."""
    good = np.zeros((2, 2, 9, 9), np.float32)
    for phases, corner, shape, steps in (
        (good, (0, 0), (9, 8), 1),
        (good, (-1, 0), (5, 5), 1),
        (good, (4, 4), (5, 4), 1),
        (good, (0, 0), (0, 4), 1),
        (good, (0, 0), (4, 4), 0),
        (np.zeros((2, 2, 9, 9)), (0, 0), (4, 4), 1),
        (np.zeros((2, 9, 9), np.float32), (0, 0), (4, 4), 1),
    ):
        with pytest.raises(ValueError):
            smeared_means(phases, corner, shape, (0.0, 0.0), steps)
