"""Poses of a plane.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.verifier.camera.plane_pose import rotations


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 0.3, 3.0])
def test_rotations_are_those_of_their_vectors(size: float, rng: np.random.Generator) -> None:
    """Catches: a turn the other way, a division by no angle, axes that are mixed up."""
    vectors = size * rng.normal(size=(7, 2, 3))
    expected = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(7, 2, 3, 3)
    assert rotations(vectors) == pytest.approx(expected, abs=1e-14)
    assert rotations(vectors[3, 1]) == pytest.approx(expected[3, 1], abs=1e-14)
