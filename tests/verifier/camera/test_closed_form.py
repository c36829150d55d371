"""Axis, focal length and aspect without a search.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.verifier.camera.plane_pose import closed_form

PLANE = np.array([[x, y] for x in (-60.0, 0.0, 60.0) for y in (-40.0, 40.0)])


def pictures(
    focal: float, axis: tuple[float, float], aspect: float = 1.0, count: int = 30, seed: int = 1
) -> np.ndarray:
    """The plane's points (T, N, 2) in long sides, seen by a pinhole camera from places all around."""
    rng = np.random.default_rng(1)
    turns = Rotation.from_euler("xyz", rng.uniform(-0.5, 0.5, (count, 3))).as_matrix()
    shifts = np.column_stack([rng.uniform(-150, 150, (count, 2)), rng.uniform(800, 1200, count)])
    local = np.einsum("tij,nj->tni", turns[:, :, :2], PLANE) + shifts[:, None]
    return focal * local[..., :2] / local[..., 2:] * [aspect, 1.0] + np.array(axis)


@pytest.mark.parametrize("axis", [(0.0, 0.0), (0.3, -0.1), (-0.6, 0.5)])
@pytest.mark.parametrize("aspect", [1.0, 0.75, 1.34])
def test_exact_pictures_give_the_camera(axis, aspect):
    """Catches: axis and aspect exchanged or of the wrong sign; an axis that is stretched with the picture."""
    found = closed_form(pictures(0.8, axis, aspect), PLANE, square=aspect == 1.0)
    assert found is not None
    assert np.allclose(found.axis, np.divide(axis, (aspect, 1.0)), atol=1e-6)
    assert found.focal == pytest.approx(0.8, rel=1e-6) and found.aspect == pytest.approx(aspect, rel=1e-6)


def test_some_shaken_frames_do_not_move_the_axis():
    """Catches: plain least squares, which three bad frames of sixty lead away."""
    points = pictures(0.8, (0.2, 0.0))
    noise = np.random.default_rng(2)
    points += 2e-5 * noise.standard_normal(points.shape)
    points[:3] += 1e-3 * noise.standard_normal((3, *points.shape[1:]))
    found = closed_form(points, PLANE, square=True)
    assert found is not None and np.allclose(found.axis, (0.2, 0.0), atol=0.01)


def test_a_plane_that_is_seen_from_the_front_alone_tells_nothing_that_is_used():
    """Catches: an error, or not a number, where homographies hold no perspective."""
    straight = np.repeat((PLANE / 1000)[None], 10, axis=0)
    found = closed_form(straight, PLANE, square=True)
    assert found is None or np.isfinite([*found.axis, found.focal, found.aspect]).all()
