"""Poses that follow a small change, against Gauss-Newton from the beginning."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.verifier.camera.fast_poses import NearPoses
from moireid.verifier.camera.plane_pose import moved_poses, start_poses

FOCAL, CENTRE = 1450.0, (959.5, 539.5)
FRAMES = 40


@pytest.fixture
def seen(rng) -> tuple[np.ndarray, np.ndarray]:
    """A plane of sixteen points, (16, 3) mm, and its pictures with a noise of 0.05 px, (T, 16, 2)."""
    corners = np.array([[-60.0, -50.0], [60.0, -45.0], [55.0, 50.0], [-60.0, 52.0]])
    square = np.array([[-13.0, -13.0], [13.0, -13.0], [13.0, 13.0], [-13.0, 13.0]])
    plane = np.zeros((16, 3))
    plane[:, :2] = (corners[:, None] + square).reshape(-1, 2)
    turn = Rotation.from_rotvec(rng.uniform(-0.4, 0.4, (FRAMES, 3))).as_matrix()
    place = turn @ plane.T + rng.uniform([-150, -100, 900], [150, 100, 1600], (FRAMES, 3))[..., None]
    points = FOCAL * place[:, :2] / place[:, 2:] + np.array(CENTRE)[:, None]
    return plane, points.transpose(0, 2, 1) + 0.05 * rng.standard_normal((FRAMES, 16, 2))


@pytest.mark.parametrize(
    ("zoom", "shear", "limit"),
    # A search begins with places 6 % of the focal length apart, which only lead the way, and ends with 0.2 %.
    [(1.06, 0.0, 3e-3), (0.94, 0.0, 3e-3), (1.0, 0.002, 1e-4), (1.01, -0.002, 1e-4), (0.998, 0.0, 1e-6)],
)
def test_errors_nearby_are_those_of_the_whole_way(seen, zoom, shear, limit):
    """Catches: a gradient of another place than the poses', which leaves them beside the best; a step of the wrong
    sign; turns about another point than the plane's origin; sides and frames exchanged.
    """
    plane, points = seen
    start = start_poses(plane, points, FOCAL, CENTRE)
    # What a rolling shutter does: rows move sideways.
    rolled = points + shear * (points - points.mean(axis=1, keepdims=True))[..., ::-1] * np.array([1.0, 0.0])
    near = NearPoses(plane, start).least_error_px(rolled, zoom, zoom * FOCAL, CENTRE)
    whole = moved_poses(start, plane, rolled, zoom, zoom * FOCAL, CENTRE, 30).least_error_px
    assert near.shape == (FRAMES,) and np.all(near >= whole - 1e-9)
    assert np.sum(near**2) == pytest.approx(np.sum(whole**2), rel=limit)


def test_a_plane_seen_from_behind_has_no_pose(seen):
    """Catches: a depth that changed its sign taken for a pose."""
    plane, points = seen
    start = start_poses(plane, points, FOCAL, CENTRE)
    behind = type(start)(start.rotation, -start.translation, start.error_px)
    error = NearPoses(plane, behind).least_error_px(points, 1.0, FOCAL, CENTRE)
    # Some find a pose in front, far off.
    assert np.all(error > 100 * start.least_error_px) and np.isinf(error).sum() > FRAMES / 2


@pytest.mark.parametrize("loose", [False, True])
def test_slopes_are_what_the_poses_leave_of_a_move(seen, rng, loose):
    """Catches: poses that do not follow; a wrong sign; points before coordinates; slack in residuals and not in slopes.

    Against moves made small and refined by another way.
    """
    plane, points = seen
    rows = plane[:, 1] / np.linalg.norm(plane[:, 1])
    slack = np.tile(0.9 * rows, (FRAMES, 1)) if loose else None
    start = moved_poses(start_poses(plane, points, FOCAL, CENTRE), plane, points, 1.0, FOCAL, CENTRE, 30, slack)
    near, moves, small = NearPoses(plane, start, slack), rng.standard_normal(points.shape), 1e-3
    left, there = (near.residuals_px(at, 1.0, FOCAL, CENTRE) for at in (points, points + small * moves))
    told = near.following_px(moves)
    usual = np.median(np.linalg.norm((there - left) / small - told, axis=1) / np.linalg.norm(told, axis=1))
    assert usual < 0.02
