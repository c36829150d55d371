"""Poses of a plane.  Beside each test: what it would catch."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.verifier.camera.plane_pose import plane_homographies, start_poses


@pytest.fixture
def seen(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A plane of twelve points, not about its origin's middle, (12, 3) mm, and its pictures, (30, 12, 2) px."""
    plane = np.column_stack([rng.uniform(-60, 80, 12), rng.uniform(-30, 50, 12), np.zeros(12)])
    turn = Rotation.from_rotvec(rng.uniform(-0.6, 0.6, (30, 3))).as_matrix()
    local = turn @ plane.T + rng.uniform([-300, -200, 500], [300, 200, 3000], (30, 3))[..., None]
    points = 1450.0 * local[:, :2] / local[:, 2:] + np.array([[959.5], [539.5]])
    return plane, points.transpose(0, 2, 1)


def test_homographies_take_the_plane_to_its_pictures(seen: tuple[np.ndarray, np.ndarray]) -> None:
    """Catches: units or middles that are put back in the wrong order; x and y exchanged."""
    plane, points = seen
    for corners in (slice(None), slice(0, 4)):
        found = plane_homographies(plane[corners, :2], points[:, corners])
        mapped = np.column_stack([plane[:, :2], np.ones(12)]) @ found.swapaxes(-1, -2)
        assert mapped[..., :2] / mapped[..., 2:] == pytest.approx(points, abs=1e-5)
        assert np.all(found[:, 2, 2] == 1)


@pytest.mark.parametrize("noise_px", [0.0, 0.1])
def test_both_poses_are_those_of_another_library(
    seen: tuple[np.ndarray, np.ndarray], noise_px: float, rng: np.random.Generator
) -> None:
    """Catches: a reflection for a rotation; the one pose twice; a depth that is not the plane's."""
    plane, points = seen
    plane = plane - plane.mean(axis=0)
    points = points + noise_px * rng.standard_normal(points.shape)
    found = start_poses(plane, points, 1450.0, (959.5, 539.5))
    matrix = np.array([[1450.0, 0, 959.5], [0, 1450.0, 539.5], [0, 0, 1]])
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
    for frame, own in enumerate(points):
        _, _, _, errors = cv2.solvePnPGeneric(plane, own, matrix, None, flags=cv2.SOLVEPNP_IPPE)
        # Refined poses leave at most what those of the library leave, in coordinates.
        assert np.all(np.sort(found.error_px[frame]) <= np.sqrt(2) * np.sort(np.ravel(errors)) + 1e-6)
    # The other pose is another one but where the plane is seen straight.
    apart = found.rotation[:, 0].swapaxes(-1, -2) @ found.rotation[:, 1]
    assert np.mean(np.trace(apart, axis1=1, axis2=2) < 2.99) > 0.8
