"""Surfaces of a photograph's scene against their closed forms."""

from __future__ import annotations

import math

import numpy as np

from moireid.simulate.photograph.surfaces import Cloth, plate, ribbon, rounded_outline, tube


def test_an_outline_is_closed_and_has_round_corners() -> None:
    """Catches: corners that turn inwards, an outline that is open, or one that goes around twice."""
    x, y = rounded_outline((30.0, 20.0), 4.0).T
    assert (x[0], y[0]) == (x[-1], y[-1])
    area = abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) / 2
    # Chords cut a little from each quarter of a circle.
    assert 60.0 * 40.0 - (4 - math.pi) * 16 - 0.5 < area <= 60.0 * 40.0 - (4 - math.pi) * 16
    assert (abs(x).max(), abs(y).max()) == (30.0, 20.0)


def test_a_plate_is_between_its_depths() -> None:
    """Catches: a plate that is pushed along another axis than down the page, or rims beyond its outline."""
    points = plate((10.0, 5.0), 2.0, -1.5, 3.0, middle_y=-40.0)
    assert np.isclose([points[..., 2].min(), points[..., 2].max()], [-1.5, 3.0]).all()
    assert np.isclose([points[..., 1].min(), points[..., 1].max()], [-45.0, -35.0]).all()
    assert np.isclose([points[..., 0].min(), points[..., 0].max()], [-10.0, 10.0]).all()


def test_a_tube_keeps_its_distance_from_its_path() -> None:
    """Catches: a tube that narrows where its path turns, and a closed one with a gap."""
    turn = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    circle = np.column_stack([7 * np.cos(turn), 7 * np.sin(turn), np.zeros(64)])
    made = tube(circle, 1.5, closed=True)
    from_path = np.hypot(np.hypot(made[..., 0], made[..., 1]) - 7.0, made[..., 2])
    assert np.allclose(from_path, 1.5, atol=0.01)
    assert np.allclose(made[0], made[-1])


def test_a_ribbon_has_its_width_across_its_path() -> None:
    """Catches: a ribbon that is widened along its path, or along a fixed axis."""
    path = np.column_stack([np.linspace(0, 30, 20), np.linspace(0, -40, 20), np.zeros(20)])
    left, _, right = np.moveaxis(ribbon(path, 15.0), 1, 0)
    assert np.allclose(np.linalg.norm(left - right, axis=1), 15.0)
    assert np.allclose((left - right)[:, :2] @ [0.6, -0.8], 0.0)


def test_cloth_is_behind_the_badge_and_repeats_by_its_seed() -> None:
    """Catches: cloth that cuts through the badge, and folds that differ from run to run."""
    cloth = Cloth((215.0, 300.0), 9.0, seed=3)
    grid = cloth.grid()
    assert grid[..., 2].min() >= 9.0
    assert np.array_equal(grid, Cloth((215.0, 300.0), 9.0, seed=3).grid())
    assert not np.array_equal(grid, Cloth((215.0, 300.0), 9.0, seed=4).grid())
    places = grid[40:60:7, 100:200:9].reshape(-1, 3)
    assert np.allclose(cloth.depth_mm(places[:, :2]), places[:, 2])
