"""How much looking a film may cost: counted in work, never in time.  Beside each test: what it would catch."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.drawn_pages import draw, filmed, seen_from
from moireid.verifier.measuring import MAX_UNSEARCHED_S
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.tracking.search_work import DECODED_NS, SAVED_FRAMES, Purse

SHAPE, FPS = (480, 640), 30.0
#: Absence after which nothing is saved for glances any more, frames.
AWAY = 240


@pytest.fixture(scope="module")
def room():
    """A room full of things before a moving camera: AWAY and some more pictures, none with a badge."""
    rng = np.random.default_rng(3)
    height, width = SHAPE
    wall = np.full((2 * height, 2 * width), 120, np.uint8)
    for _ in range(400):
        place, size = rng.integers(0, (2 * width, 2 * height)), 10 * 2 ** rng.uniform(0, 3.5, 2)
        box = cv2.boxPoints((tuple(map(float, place)), tuple(map(float, size)), float(rng.normal(0, 6))))
        cv2.fillPoly(wall, [box.astype(np.int32)], int(rng.integers(20, 235)), cv2.LINE_AA)
    ways = np.linspace(0, 6, AWAY + 60)
    middles = (width + 0.4 * width * np.sin(ways), height + 0.4 * height * np.cos(1.3 * ways))
    return [filmed(cv2.getRectSubPix(wall, (width, height), at), rng, noise=1.5) for at in zip(*middles, strict=True)]


def in_room(view, badge, page):
    """A picture of a room with a badge before it."""
    x, y = badge.page_mm
    corners = cv2.perspectiveTransform(np.array([[[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]]]), page)
    there = cv2.fillConvexPoly(np.zeros(SHAPE, np.uint8), corners.round().astype(np.int32), 1)
    shown = filmed(draw(page, badge.markers, shape=SHAPE))
    return lambda picture: np.where(there > 0, shown, picture)


def seconds_until_noticed(view: SceneTracker, room, first: int, paint) -> float:
    for waited, picture in enumerate(room[first:]):
        if view.push(Frame(first + waited, (first + waited) / FPS, paint(picture))):
            return waited / FPS
    return np.inf


@pytest.mark.slow
@pytest.mark.parametrize("at", [(4.0, 4.0), (400.0, 4.0), (4.0, 250.0), (400.0, 250.0), (200.0, 120.0)])
@pytest.mark.parametrize(("marker_px", "limit_s"), [(36.0, 0.5), (18.0, 0.5), (13.0, 1.0)])
def test_a_badge_that_comes_into_a_full_room_is_noticed_soon(marker_px, limit_s, at, ada, room):
    """Catches: a glance rate that falls without end; a place or a size that no cheap look reaches; savings taken for a
    rate: here they are spent.
    """
    view, scale = SceneTracker(ada), marker_px / ada.markers.size_mm
    reach = np.minimum(at, np.array(SHAPE[::-1]) - scale * np.array(ada.page_mm) - 4)
    page = seen_from(px_per_mm=scale, turn_deg=0.0, tilt=(0.0, 0.0), at=np.maximum(reach, 4))
    for index in range(AWAY):
        assert not view.push(Frame(index, index / FPS, room[index]))
    assert not view._purses.glance.ample and not view._purses.wide.ample
    assert seconds_until_noticed(view, room, AWAY, in_room(view, ada, page)) <= limit_s


def test_a_badge_that_comes_back_after_a_long_absence_is_noticed_within_half_a_second(ada, room):
    """Catches: a lost badge searched around its last place alone; a search that soon stops."""
    there, elsewhere = (
        seen_from(px_per_mm=18.0 / ada.markers.size_mm, turn_deg=0.0, tilt=(0.0, 0.0), at=at)
        for at in ((20.0, 20.0), (400.0, 250.0))
    )
    view, paint = SceneTracker(ada), in_room(None, ada, there)
    for index in range(10):
        assert view.push(Frame(index, index / FPS, paint(room[index])))
    for index in range(10, AWAY):
        assert not view.push(Frame(index, index / FPS, room[index]))
    assert seconds_until_noticed(view, room, AWAY, in_room(None, ada, elsewhere)) <= 0.5


def noise(rng):
    return rng.integers(0, 256, SHAPE).astype(np.uint8)


def squares(rng):
    """A wall of markers with the numbers of a badge, in no badge's order."""
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    wall = np.full(SHAPE, 230, np.uint8)
    for place, (top, left) in enumerate((y, x) for y in range(10, 440, 45) for x in range(10, 600, 45)):
        wall[top : top + 30, left : left + 30] = cv2.aruco.generateImageMarker(known, place % 3, 30)
    return wall


@pytest.mark.parametrize("content", [noise, squares])
def test_looking_keeps_within_its_budget_whatever_the_film_shows(content, ada, rng):
    """Catches: a look that nobody pays; work that a kind of content makes dearer than it is counted; a look that is
    free as long as something is found.
    """
    view, frames, picture = SceneTracker(ada), 2 * SAVED_FRAMES, content(rng)
    decoded_ns, whole = DECODED_NS * picture.size, 0.0
    for index in range(frames):
        before_ns = view._purses.work_ns
        view.push(Frame(index, index / FPS, picture))
        whole = max(whole, view._purses.work_ns - before_ns)
    purses = view._purses
    share = sum(one.share for one in (purses.near, purses.glance, purses.wide))
    # Each purse may owe a search at the end, and all searches of one frame together are the dearest yet.
    assert purses.work_ns <= share * decoded_ns * (frames + SAVED_FRAMES) + 3 * whole
    # Noise is the dearest content: a quick look at it is paid in 1.4 s, and one at a wall of markers in 0.43 s.
    assert view.unsearched > frames / 4 and 0.4 < view.unsearched_s < 1.1 * MAX_UNSEARCHED_S


def test_a_film_without_a_badge_is_searched_less_and_less(ada, room, monkeypatch):
    """Catches: every frame searched; a search that stops for good; the first frame unsearched; frames not counted."""
    looks: list[int] = []
    view = SceneTracker(ada)
    count_looks(monkeypatch, view._finder, looks)
    every = []
    for index, picture in enumerate(room + room[::-1]):
        before = len(looks)
        assert not view.push(Frame(index, index / FPS, picture))
        every.append(len(looks) > before)
    first, last = np.mean(every[:30]), np.mean(every[-200:])
    assert every[0] and first > 3 * last > 0 and view.unsearched == len(every) - sum(every)
    gaps = np.diff([*(index for index, looked in enumerate(every) if looked), len(every)])
    assert view.unsearched_s == pytest.approx((gaps.max() - 1) / FPS) and view.unsearched_s < MAX_UNSEARCHED_S


def count_looks(monkeypatch, finder: MarkerFinder, looks: list[int]):
    """Note each look of a finder."""
    look = finder._searched

    def noting(*given):
        looks.append(1)
        return look(*given)

    monkeypatch.setattr(finder, "_searched", noting)


def test_a_frame_in_which_one_of_two_badges_is_lost_and_not_looked_for_is_counted(ada, room, monkeypatch):
    """Catches: a badge that is followed and hides that another, which was lost, could no longer be looked for."""
    scale = 24.0 / ada.markers.size_mm
    first, second = (
        seen_from(px_per_mm=scale, turn_deg=0.0, tilt=(0.0, 0.0), at=at) for at in ((20.0, 20.0), (380.0, 230.0))
    )
    view, stays, goes = SceneTracker(ada), in_room(None, ada, first), in_room(None, ada, second)
    for index in range(70):
        view.push(Frame(index, index / FPS, goes(stays(room[index]))))
    assert len(view._places()) == 2 and view.unsearched == 0
    monkeypatch.setattr(Purse, "open", property(lambda purse: False))
    for index in range(70, 200):
        assert view.push(Frame(index, index / FPS, stays(room[index])))
    # It is due each two seconds.
    assert len(view._places()) == 1 and view.unsearched >= 2
    # The film is not blind as long as a badge is followed.
    assert view.unsearched_s == 0
