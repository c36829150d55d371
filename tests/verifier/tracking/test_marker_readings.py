"""How often markers are read of a page that looks less like the print than a followed one must.  Each test names what
it would catch.
"""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from kit.drawn_pages import draw, filmed, seen_from
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.finding.page_groups import same_page
from moireid.verifier.tracking.marker_readings import AGREED, FALLEN, MOST_AGREED, READ_EVERY, SAME_PX, MarkerReadings
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import Registration
from moireid.verifier.tracking.scene_tracker import GLANCE_S, SceneTracker

SHAPE, FPS, PX_PER_MM = (480, 640), 30.0, 1.3


def place(number: int, at: tuple[float, float] = (20.0, 40.0)) -> np.ndarray:
    """A page that moves by a pixel a frame."""
    return seen_from(px_per_mm=PX_PER_MM, turn_deg=2.0, tilt=(0.0, 0.0), at=(at[0] + number % 40, at[1]))


@pytest.fixture
def board(ada, rng):
    """The picture of a frame: a board with the badge's squares, the first and the third swapped."""
    false = replace(ada.markers, ids=tuple(ada.markers.ids[k] for k in (2, 1, 0, 3)))
    drawn = draw(place(0), false, shape=SHAPE)
    return lambda number: filmed(np.roll(drawn, number % 40, axis=1), rng, noise=1.0)


@pytest.fixture
def scene(ada, monkeypatch):
    """A scene tracker, a function that hands it the next picture, and how often it searched markers and smears."""
    view, numbers, calls = SceneTracker(ada), itertools.count(), Counter()
    for owner, name in ((view._finder, "near"), (view.trackers[0]._shaken, "find")):
        search = getattr(owner, name)

        def counting(*given, search=search, name=name, **named):
            calls[name] += 1
            return search(*given, **named)

        monkeypatch.setattr(owner, name, counting)

    def push(picture) -> bool:
        number = next(numbers)
        return view.push(Frame(number, number / FPS, picture))

    return view, push, calls


def test_the_markers_of_a_board_with_false_ones_are_read_now_and_then(scene, board, ada):
    """Catches: markers read and smears searched in each frame, for half as much work as decoding; a board that uses up
    what a smeared badge needs; a page elsewhere than where its markers are.
    """
    view, push, calls = scene
    frames, corners, owed = 80, marker_corners_mm(ada.markers), []
    for number in range(frames):
        assert push(board(number))
        assert same_page(view.trackers[0].place, place(number), corners)
        owed.append(view._purses.smeared._spent)
        alone = view.trackers[0]._alone
        # It jumps back once.
        assert number % 40 < 2 or (alone is not None and not alone.clear)
    assert frames / READ_EVERY - 1 < calls["near"] < frames / READ_EVERY + AGREED + 3
    assert 0 < calls["find"] < AGREED + 3
    assert view._purses.near.ample and np.all(np.diff(owed[AGREED + 4 :]) < 0)


def test_a_page_that_vanishes_is_not_followed(scene, board, rng):
    """Catches: a place that is taken for the page because the page was there; a smear that is no longer searched."""
    _, push, calls = scene
    for number in range(AGREED + 10):
        assert push(board(number))
    before = calls.copy()
    wall = filmed(np.full(SHAPE, 150.0), rng, noise=1.0)
    assert not push(wall) and not push(wall)
    assert calls["near"] > before["near"] and calls["find"] > before["find"]


def test_a_badge_next_to_such_a_board_is_found_with_the_next_glance(scene, board, ada):
    """Catches: a board that counts as smeared in each frame, so that glances at others wait half a second more."""
    view, push, _ = scene
    scale = 24.0 / ada.markers.size_mm
    page = seen_from(px_per_mm=scale, turn_deg=0.0, tilt=(0.0, 0.0), at=(400.0, 260.0))
    other = filmed(draw(page, ada.markers, shape=SHAPE))
    there = np.zeros(SHAPE, bool)
    there[255:, 395:] = True
    for number in range(10):
        push(board(number))
    found = []
    for number in range(10, 10 + round((GLANCE_S + 0.1) * FPS)):
        push(np.where(there, other, board(number)))
        found.append(len(view._places()))
    assert found[0] == 1 and found[-1] == 2


def read(correlation: float) -> Registration:
    return Registration(np.eye(3), correlation)


def test_readings_must_agree_first_and_are_made_again():
    """Catches: a page trusted after one reading, or for ever; readings that disagree counted; a page that looks less
    and less like the print; one that looks more like it refused.
    """
    readings = MarkerReadings()
    for _ in range(AGREED):
        assert not readings.agree and not readings.suffice(read(0.85))
        readings.note(read(0.85), SAME_PX / 2)
    assert readings.agree
    assert [readings.suffice(read(0.85)) for _ in range(READ_EVERY)] == [True] * (READ_EVERY - 1) + [False]
    # Registration may fail where the page moved far: that speaks for nothing and against nothing.
    assert not readings.suffice(None)
    readings.note(read(0.85), None)
    assert readings.agree and readings.suffice(read(0.89))
    # No page may lose more by many small steps than by one.
    assert readings.suffice(read(0.85 - 0.9 * FALLEN)) and not readings.suffice(read(0.85 - 1.1 * FALLEN))
    readings.note(read(0.85), 2 * SAME_PX)
    assert not readings.agree and not readings.suffice(read(0.85))


def test_readings_of_a_page_that_is_seen_clearly_are_soon_forgotten():
    """Catches: a badge that was half covered some minutes ago and is smeared now, followed by the sharp print."""
    readings = MarkerReadings()
    for _ in range(100):
        readings.note(read(0.85), 0.0)
    for _ in range(MOST_AGREED - AGREED):
        readings.fade()
        assert readings.agree
    readings.fade()
    assert not readings.agree and not readings.suffice(read(0.85))
    readings.note(read(0.85), 0.0)
    readings.forget()
    readings.fade()
    readings.note(read(0.85), 0.0)
    assert not readings.agree
