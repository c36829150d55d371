"""Poses and smeared prints by the kernel, against NumPy and OpenCV.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit import numpy_kernel
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


@pytest.mark.parametrize("loose", [False, True])
@pytest.mark.parametrize("steps", [0, 1, 6])
def test_poses_are_refined_as_by_numpy(view, rng, steps, loose):
    """Catches: a derivative of the wrong sign; u and v exchanged; a slack that is applied once; another
    frame's points.
    """
    plane, seen, rotation, translation = view
    slack = rng.uniform(-1, 1, (FRAMES, POINTS)) if loose else None
    if slack is not None:
        slack *= rng.uniform(0.2, 0.99, (FRAMES, 1)) / np.linalg.norm(slack, axis=1, keepdims=True)
    given = {"steps": steps, "damping": DAMPING, "most_turn": MOST_TURN_RAD}
    found = refined_poses(plane, seen, slack, rotation, translation, **given)
    expected = numpy_kernel.refined_poses(plane, seen, slack, rotation, translation, **given)
    for one, other, least in zip(found, expected, (1e-9, 1e-6, 1e-12), strict=True):
        assert one == pytest.approx(other, abs=least, rel=1e-9)


@pytest.mark.parametrize("loose", [False, True])
@pytest.mark.parametrize("points", [4, 15, 17, 32, 41])
def test_any_number_of_points_counts_in_full(rng, points, loose):
    """Catches: points beyond the first sixteen that are left out, or the last ones counted twice; their slack too."""
    plane, seen, rotation, translation = view_of(rng, points)
    slack = rng.uniform(-0.9, 0.9, (FRAMES, points)) / np.sqrt(points) if loose else None
    given = {"steps": 2, "damping": DAMPING, "most_turn": MOST_TURN_RAD}
    found = refined_poses(plane, seen, slack, rotation, translation, **given)
    expected = numpy_kernel.refined_poses(plane, seen, slack, rotation, translation, **given)
    for one, other, least in zip(found, expected, (1e-9, 1e-6, 1e-12), strict=True):
        assert one == pytest.approx(other, abs=least, rel=1e-9)


def test_steps_end_where_a_further_one_changes_nothing(view):
    """Catches: steps that end early, on the way."""
    plane, seen, rotation, translation = view
    given = {"damping": DAMPING, "most_turn": MOST_TURN_RAD}
    found = refined_poses(plane, seen, None, rotation, translation, steps=50, **given)
    expected = numpy_kernel.refined_poses(plane, seen, None, rotation, translation, steps=50, **given)
    for one, other, least in zip(found, expected, (1e-9, 1e-6, 1e-12), strict=True):
        assert one == pytest.approx(other, abs=least)


def test_a_large_turn_is_taken_in_parts_and_rotations_stay_rotations(view):
    """Catches: steps without a limit; a rotation whose series ends too early."""
    plane, seen, rotation, translation = view
    given = {"steps": 1, "damping": DAMPING, "most_turn": 0.01}
    found, _, _ = refined_poses(plane, seen, None, rotation, translation, **given)
    expected, _, _ = numpy_kernel.refined_poses(plane, seen, None, rotation, translation, **given)
    assert found == pytest.approx(expected, abs=1e-12)
    assert found @ found.swapaxes(-1, -2) == pytest.approx(np.broadcast_to(np.eye(3), found.shape), abs=1e-12)


def test_a_plane_behind_the_camera_or_without_extent_has_no_pose(view):
    """Catches: a pose from behind that counts as the best; a crash where the equations have no solution."""
    plane, seen, rotation, translation = view
    given = {"steps": 2, "damping": DAMPING, "most_turn": MOST_TURN_RAD}
    behind = translation * [1, 1, -1]
    assert np.isinf(refined_poses(plane, seen, None, rotation, behind, **given | {"steps": 0})[2]).all()
    for nothing in (np.zeros_like(plane), np.full_like(plane, np.nan), np.full_like(plane, np.inf)):
        left = refined_poses(nothing, seen, None, rotation, translation, **given)[2]
        assert np.isinf(left).all()


@pytest.mark.parametrize(("motion", "steps"), [((0.0, 0.0), 1), ((7.3, -2.2), 5), ((-300.0, 90.0), 9)])
def test_a_smear_is_the_mean_along_its_motion(rng, motion, steps):
    """Catches: a motion of the wrong sign; x for y; a half sample of the wrong phase; a read beyond the drawing."""
    phases = rng.normal(size=(2, 2, 40, 57)).astype(np.float32)
    for corner, shape in (((9, 12), (21, 30)), ((0, 0), (39, 56)), ((18, 1), (3, 2))):
        expected = numpy_kernel.smeared_means(phases, corner, shape, motion, steps)
        assert smeared_means(phases, corner, shape, motion, steps) == pytest.approx(expected, abs=2e-4)


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
