"""Markers of 10 px: enlarged tiles, two markers without perspective, mirror images.  Beside each test: what it would
catch.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from kit.drawn_pages import CORNERS, MARKERS, draw, filmed, nudged, seen_from
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.finding.markers import USUAL, MarkerFinder, tiles_of
from moireid.verifier.tracking.finding.page_finder import PicturePart
from moireid.verifier.tracking.finding.page_groups import PLAIN_BELOW_PX, pages_of, same_page
from moireid.verifier.tracking.patches import marker_corners_mm
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


@pytest.mark.parametrize("shape", [(1080, 1920), (2160, 3840), (1920, 1080), (480, 640), (360, 480), (90, 120), (7, 5)])
def test_tiles_hold_each_place_with_its_surroundings(shape):
    """Catches: a seam on which no page lies whole; tiles beyond the frame; a tile as large as a large frame."""
    tiles = tiles_of(shape)
    ways = [(0, 2, shape[1]), (1, 3, shape[0])]
    for low, high, size in ways:
        spans = sorted({(tile[low], tile[high]) for tile in tiles})
        assert spans[0][0] == 0 and spans[-1][1] == size and max(end - start for start, end in spans) <= 1200
        assert all(end - after >= min(90, size) for (_, end), (after, _) in itertools.pairwise(spans))
    assert len(set(tiles)) == len(tiles) == np.prod([len({tile[low] for tile in tiles}) for low, _, _ in ways])


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


def test_a_small_badge_that_was_hidden_is_found_again_at_once(shown, ada, rng):
    """Catches: a neighbourhood forgotten with the first frame that does not show the badge."""
    for away in range(12, 16):
        view = SceneTracker(ada)
        assert push(view, filmed(shown[1], rng, noise=1.0), 0)
        for index in range(away):
            assert not push(view, np.full(SHAPE, 200, np.uint8), 1 + index)
        assert push(view, filmed(shown[1], rng, noise=1.0), 1 + away)


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


def test_a_close_look_finds_what_is_less_clear_and_each_marker_once(rng):
    """Catches: a close look by the quick one's threshold alone; a marker that two thresholds find taken for two."""
    truth, finder = seen_from(px_per_mm=0.7, turn_deg=0.0, tilt=(0.0, 0.0), at=(150.3, 90.7)), MarkerFinder(MARKERS)
    pale = filmed(draw(truth, ink=160.0, paper=180.0, shape=SHAPE), rng, noise=1.0)
    assert finder.quick(pale)[0] == []
    (page,) = finder.either_way(pale)[0]
    assert same_page(page, truth, CORNERS)
    pages, count = finder._searched(USUAL, PicturePart(filmed(draw(truth, shape=SHAPE), rng, noise=1.0), SHAPE[1]))
    assert count == 4 and len(pages[0]) == 1


def test_two_small_markers_are_also_placed_without_perspective(rng):
    """Catches: a place from two markers of 10 px whose other markers lie modules away, where no registration begins."""
    for pair in ((0, 1), (1, 2), (0, 2)):
        truth, far = small(), []
        for _ in range(20):
            quads = mapped(truth)[list(pair)] + 0.25 * rng.standard_normal((2, 4, 2))
            _, plain = pages_of(quads, list(pair), CORNERS)
            far.append(np.linalg.norm(mapped(plain) - mapped(truth), axis=-1).max())
        # A module is 1.7 px; registration begins within some of them.
        assert np.median(far) < 1.7 and max(far) < 4.0


def test_larger_markers_and_more_of_them_make_one_page(rng):
    """Catches: a needless second place for a page whose perspective is well determined."""
    large = seen_from(px_per_mm=1.1 * PLAIN_BELOW_PX / 26)
    for page, members in ((large, [0, 1]), (small(), [0, 1, 2]), (small(), [0, 1, 2, 3])):
        assert len(pages_of(mapped(page)[members], members, CORNERS)) == 1


def test_of_two_badges_each_pair_keeps_its_own(rng):
    """Catches: a place without perspective through markers of two pages."""
    one, other = small((50.0, 60.0)), nudged(small((50.0, 60.0)), 240.0, 30.0)
    quads = np.concatenate([mapped(one)[[0, 1]], mapped(other)[[0, 1]]])
    pages = pages_of(quads + 0.1 * rng.standard_normal(quads.shape), [0, 1, 0, 1], CORNERS)
    assert len(pages) == 4
    for page in pages[2:]:
        assert sum(same_page(page, truth, CORNERS) for truth in (one, other)) == 1


def mapped(page: np.ndarray) -> np.ndarray:
    """Corners of the markers in the picture, (4, 4, 2)."""
    told = np.einsum("ij,mcj->mci", page, np.concatenate([CORNERS, np.ones((4, 4, 1))], axis=-1))
    return told[..., :2] / told[..., 2:]
