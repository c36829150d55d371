"""Markers of 10 px: enlarged tiles, slanted pages begun from one marker, mirror images.  Beside each test: what it
would catch.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.drawn_pages import CORNERS, MARKERS, WIDTH, apart_px, draw, filmed, seen_from
from moireid.verifier.picture import Frame, as_picture
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.finding.page_groups import pages_of_one, same_page
from moireid.verifier.tracking.patch_search import registered
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import KeptTemplate, PageRegistrar, scale_px_per_mm
from moireid.verifier.tracking.scene_tracker import SceneTracker

SHAPE = (480, 640)
FPS = 30.0


def small(at=(150.3, 90.7)) -> np.ndarray:
    """A page whose markers are 10.4 px wide."""
    return seen_from(px_per_mm=0.40, turn_deg=0.0, tilt=(0.0, 0.0), at=at)


def push(view: SceneTracker, luma: np.ndarray, index: int) -> bool:
    return view.push(Frame(index, index / FPS, luma))


@pytest.fixture(scope="module")
def shown(ada):
    """A small badge in a corner of the frame, and its place."""
    truth = small((480.3, 300.7))
    return truth, draw(truth, ada.markers, shape=SHAPE)


@pytest.mark.parametrize("at", [(20.3, 20.7), (480.3, 20.7), (20.3, 330.7), (480.3, 330.7), (280.0, 200.0)])
def test_a_small_badge_is_found_in_the_first_frame(at, ada, rng):
    """Catches: a corner that no tile reaches; a tile's corner forgotten; small badges found by luck, or as several."""
    view, truth = SceneTracker(ada), small(at)
    assert push(view, filmed(draw(truth, ada.markers, shape=SHAPE), rng, noise=1.0), 0)
    (tracker,) = view.trackers
    assert same_page(tracker.place, truth, marker_corners_mm(ada.markers)) and not tracker.take().mirrored


def test_a_small_badge_that_comes_in_later_is_found_within_the_tiles_round(shown, ada, rng):
    """Catches: all tiles in the first frame and none after it; a turn that leaves one out."""
    for first in range(1, 5):
        view = SceneTracker(ada)
        for index in range(first):
            assert not push(view, np.full(SHAPE, 200, np.uint8), index)
        found = [push(view, filmed(shown[1], rng, noise=1.0), first + k) for k in range(5)]
        assert any(found[:4]) and found[4]


@pytest.mark.parametrize("px_per_mm", [0.4, 1.2])
def test_a_mirrored_badge_is_found_without_turning_the_picture(px_per_mm, ada, rng):
    """Catches: corners in the mirror's order; places in the mirrored picture; a film unmirrored twice."""
    truth = seen_from(px_per_mm=px_per_mm, turn_deg=5.0, tilt=(0.0, 0.0), at=(150.3, 90.7))
    picture = filmed(draw(truth, ada.markers, shape=SHAPE), rng, noise=1.0)[:, ::-1]
    view = SceneTracker(ada)
    for index in range(3):
        assert push(view, np.ascontiguousarray(picture), index)
        assert same_page(view.trackers[0].place, truth, marker_corners_mm(ada.markers))
    track = view.trackers[0].take()
    assert track.mirrored and track.tracked == 3


def test_what_a_mirror_shows_is_told_apart(rng):
    """Catches: pages of the mirror image among those of the picture, which would be registered in vain each frame."""
    truth = seen_from()
    picture = filmed(draw(truth), rng, noise=1.0)
    straight, turned = MarkerFinder(MARKERS).either_way(picture)
    assert len(straight) == 1 and not turned and same_page(straight[0], truth, CORNERS)
    straight, turned = MarkerFinder(MARKERS).either_way(np.ascontiguousarray(picture[:, ::-1]))
    assert len(turned) == 1 and not straight and same_page(turned[0], truth, CORNERS)


def slanted(degrees=55.0, axis=(0.6, 0.8, 0.0)) -> np.ndarray:
    """A page of 110 px, were it seen from the front, turned about an axis."""
    turn = cv2.Rodrigues(np.radians(degrees) * np.array(axis))[0]
    from_page = np.array([[1.0, 0.0, -73.0], [0.0, 1.0, -85.0], [0.0, 0.0, 1.0]])
    page = np.diag([480.0, 480.0, 1.0]) @ np.column_stack([turn[:, :2], [0.0, 0.0, 640.0]]) @ from_page
    return np.array([[1.0, 0.0, 240.3], [0.0, 1.0, 180.7], [0.0, 0.0, 1.0]]) @ page / page[2, 2]


@pytest.mark.parametrize("marker", range(4))
def test_one_marker_begins_a_slanted_page(marker, rng):
    """Catches: a page placed by one marker whose other markers are not sought; the wrong one of its two slants."""
    truth, registrar = slanted(), PageRegistrar(MARKERS)
    picture = as_picture(filmed(draw(truth), rng, noise=1.5))
    quad = mapped(truth)[marker] + 0.3 * rng.standard_normal((4, 2))
    starts = pages_of_one(quad, CORNERS[marker], 0.75 * WIDTH)
    found = [registered(registrar, picture, page, KeptTemplate(registrar.printer).at(page)) for page in starts]
    assert min(apart_px(one.homography, truth) for one in found if one is not None) < 0.3


def test_a_slanted_page_looks_like_its_print_as_much_as_one_from_the_front(rng):
    """Catches: a print with one blur for both directions, which a slanted small page does not resemble."""
    truth, registrar = slanted(65.0, (0.0, 1.0, 0.0)), PageRegistrar(MARKERS)
    picture = filmed(draw(truth), rng, noise=1.5)
    even = registrar.printer.draw(scale_px_per_mm(truth, registrar.printer.middle))
    slant = registrar.register(picture, truth).correlation
    assert slant > 0.985 > registrar.register(picture, truth, even).correlation


def mapped(page: np.ndarray) -> np.ndarray:
    """Corners of the markers in the picture, (4, 4, 2)."""
    told = np.einsum("ij,mcj->mci", page, np.concatenate([CORNERS, np.ones((4, 4, 1))], axis=-1))
    return told[..., :2] / told[..., 2:]
