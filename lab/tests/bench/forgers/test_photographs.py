"""Photographs superposed on a film, each a picture of one brightness.  Each test states what it would catch."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from moireid.simulate.motion import Poses
from moireid_lab.bench.forgers import photographs
from moireid_lab.bench.forgers.photographs import Photographs

FPS, FRAMES = 30.0, 60
TIMES = np.arange(FRAMES) / FPS


def motion(times_s: np.ndarray) -> Poses:
    """Sideways by 0.4 of the distance each second, which grows from 800 to 1200 mm, and upward half as much."""
    away = 800 + 400 * np.clip(times_s, 0, 59 / FPS) * FPS / 59
    parallax = 0.4 * (times_s - 1)
    return Poses(np.column_stack([parallax * away, parallax * away / 2, -away]), np.zeros((len(times_s), 3, 3)))


CAMERA = motion(TIMES).camera_mm
PARALLAX = 0.4 * (TIMES - 1)


@pytest.fixture
def taken(monkeypatch: pytest.MonkeyPatch):
    """Photographs whose coded brightness is a figure of the place that they were taken from; the places."""
    places: list[np.ndarray] = []

    def using(figure):
        class Flat:
            def __init__(self, scene, px_per_mm):
                pass

            def picture(self, place_mm):
                places.append(place_mm)
                return np.full((20, 40), figure(place_mm) ** 2, np.float32)

        monkeypatch.setattr(photographs, "SquaredUp", Flat)
        return places

    return using


def shown(made: Photographs, badge=None) -> np.ndarray:
    """Coded brightness of the whole picture, (T, rows, columns)."""
    film = made.shown(SimpleNamespace(badge=badge), motion, CAMERA, FPS)
    return np.array([np.sqrt(film.picture(frame)) for frame in range(FRAMES)])


def along_x(place_mm: np.ndarray) -> float:
    return 2 + float(place_mm[0] / abs(place_mm[2]))


@pytest.mark.parametrize("count", [2, 5, 12])
def test_two_photographs_are_cross_faded_by_parallax_in_coded_brightness(taken, count):
    """Catches: a fade in light, which is darker between; shares exchanged; a table by time."""
    places = taken(along_x)
    seen = shown(Photographs(count))[:, 3, 3]
    # A figure that is linear in parallax is made good by linear fading.
    assert seen == pytest.approx(2 + PARALLAX, abs=1e-5)
    tangents = np.array([place[:2] / abs(place[2]) for place in places])
    assert tangents[:, 0] == pytest.approx(np.linspace(PARALLAX.min(), PARALLAX.max(), count))
    assert tangents[:, 1] == pytest.approx(tangents[:, 0] / 2)
    # Taken from the course's mean distance.
    assert -np.array(places)[:, 2] == pytest.approx(np.full(count, -CAMERA[:, 2].mean()))


def test_of_two_distances_the_nearer_shows_the_near_view(taken):
    """Catches: near and far exchanged, a share by distance where the fringes' spacing goes with one over it."""
    places = taken(lambda place_mm: 1000 / abs(place_mm[2]))
    seen = shown(Photographs(3, distances=2))[:, 0, 0]
    assert sorted({round(-place[2]) for place in places}) == [800, 1200] and len(places) == 6
    assert seen == pytest.approx(1000 / np.abs(CAMERA[:, 2]), abs=1e-5)
    nearest = shown(Photographs(3, distances=2, blend=False))[:, 0, 0]
    assert sorted({round(float(value), 4) for value in nearest}) == [0.8333, 1.25]
    assert nearest[0] == pytest.approx(1.25) and nearest[-1] == pytest.approx(1 / 1.2)
    alone = shown(Photographs(3))[:, 0, 0]
    assert np.ptp(alone) < 1e-6
