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
from moireid.verifier.tracking.marker_readings import AGREED, FALLEN, READ_EVERY, SAME_PX, MarkerReadings
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import Registration
from moireid.verifier.tracking.scene_tracker import SceneTracker

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
