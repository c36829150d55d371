"""How much looking a film may cost: counted in work, never in time.  Beside each test: what it would catch."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.drawn_pages import draw, filmed, seen_from
from moireid.verifier.tracking.markers import MarkerFinder
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.tracking.search_work import DECODED_NS, SAVED_FRAMES, Purse, search_work_ns
from moireid.verifier.video import Frame

SHAPE, FPS = (480, 640), 30.0


def test_a_purse_bounds_what_is_paid_in_the_long_run():
    """Catches: debts forgiven, savings without end, a search too dear to be ever made."""
    purse, paid, frames = Purse(0.1), 0.0, 5000
    dear = 300 * 0.1 * DECODED_NS * 1000
    for _ in range(frames):
        purse.earn(1000)
        if purse.open:
            purse.pay(dear)
            paid += dear
    earned = frames * 0.1 * DECODED_NS * 1000
    assert earned <= paid <= earned * (1 + SAVED_FRAMES / frames) + dear


def test_noise_is_dearer_than_an_even_wall(rng):
    """Catches: work by pixels alone, by which a film of noise costs ten times what it may."""
    parameters = cv2.aruco.DetectorParameters()
    wall, noise = np.full(SHAPE, 90, np.uint8), rng.integers(0, 256, SHAPE).astype(np.uint8)
    cheap, dear = (search_work_ns(picture, parameters, 0) for picture in (wall, noise))
    # Measured: 2.5 and 95 ns a pixel.
    assert cheap / wall.size == pytest.approx(2.5, rel=0.3) and dear / noise.size == pytest.approx(95, rel=0.3)
    assert search_work_ns(wall, parameters, 100) > 2 * cheap


def test_a_film_without_a_badge_is_searched_less_and_less(ada, rng, monkeypatch):
    """Catches: every frame searched; a search that stops for good; the first frame unsearched; frames not counted."""
    looks: list[int] = []
    view = SceneTracker(ada)
    monkeypatch.setattr(view._finder, "_found_by", counted(view._finder, looks))
    room = rng.integers(0, 256, (60, 80)).astype(np.uint8)
    room = cv2.resize(room, SHAPE[::-1], interpolation=cv2.INTER_NEAREST)
    every = []
    for index in range(900):
        before = len(looks)
        assert not view.push(Frame(index, index / FPS, filmed(room, rng, noise=1.0)))
        every.append(len(looks) > before)
    first, last = np.mean(every[:30]), np.mean(every[-300:])
    assert every[0] and first > 4 * last > 0 and view.unsearched == 900 - sum(every)


def counted(finder: MarkerFinder, looks: list[int]):
    found_by = finder._found_by

    def counting(*given):
        looks.append(1)
        return found_by(*given)

    return counting


def test_a_badge_that_comes_into_view_is_found_within_half_a_second(ada, rng):
    """Catches: a glance rate that falls without end."""
    view = SceneTracker(ada)
    shown = draw(seen_from(px_per_mm=1.5, at=(120.0, 60.0)), ada.markers, shape=SHAPE)
    for index in range(300):
        assert not view.push(Frame(index, index / FPS, np.full(SHAPE, 120, np.uint8)))
    found = [view.push(Frame(300 + k, 10 + k / FPS, filmed(shown, rng, noise=1.0))) for k in range(15)]
    assert any(found)
