"""Square markers found by the kernel, against NumPy and OpenCV.  Each test says what it catches."""

from __future__ import annotations

import itertools

import cv2
import numpy as np
import pytest

from kit import numpy_kernel
from kit.drawn_pages import MARKERS, draw, filmed, seen_from
from moireid.verifier.kernel.library import picture_struct
from moireid.verifier.kernel.squares import MOST_STEPS, SquareCodes, memory_for
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.patches import marker_corners_mm

LEVELS = np.arange(256, dtype=np.float32)
SEARCH = {"window": 13, "steps": 9, "least_px": 9.0}
SHAPE = (260, 331)


@pytest.fixture(scope="module")
def finder():
    return MarkerFinder(MARKERS)


def corner_error_px(page, way):
    """Largest distance of a found page's marker corners from those drawn, px."""
    corners = marker_corners_mm(MARKERS).reshape(-1, 1, 2)
    apart = cv2.perspectiveTransform(corners, page) - cv2.perspectiveTransform(corners, way)
    return float(np.linalg.norm(apart, axis=2).max())


def cluttered(rng, turn_deg, marker_px):
    """Markers among boxes, discs and noise, and some that the picture's border cuts."""
    view = np.full(SHAPE, 150, np.uint8)
    for _ in range(25):
        place, size = rng.integers(0, SHAPE[::-1]), rng.uniform(3, 50, 2)
        box = cv2.boxPoints((tuple(map(float, place)), tuple(map(float, size)), float(rng.uniform(0, 90))))
        cv2.fillPoly(view, [box.astype(np.int32)], int(rng.integers(20, 235)), cv2.LINE_AA)
        cv2.circle(view, tuple(map(int, rng.integers(0, 260, 2))), int(rng.integers(2, 16)), int(rng.integers(256)), -1)
    way = seen_from(px_per_mm=marker_px / 26, turn_deg=turn_deg, at=(110.0, 5.0))
    outline = cv2.perspectiveTransform(np.array([[[0.0, 0.0], [146, 0], [146, 168], [0, 168]]]), way)
    page = cv2.fillConvexPoly(np.zeros(SHAPE, np.uint8), outline.round().astype(np.int32), 1)
    return filmed(np.where(page > 0, draw(way, shape=SHAPE), view), rng, noise=3.0)


@pytest.mark.parametrize(("turn_deg", "marker_px"), [(0, 13), (9, 20), (22.5, 26), (45, 24), (80, 34), (350, 22)])
def test_squares_are_those_of_numpy(rng, finder, turn_deg, marker_px):
    """Catches: a window that is off by a pixel; components of four neighbours, joined too late or twice; an extreme
    point that is not; cells in another order; a padded row that is read on.
    """
    picture = cluttered(rng, turn_deg, marker_px)
    padded = np.pad(picture, ((0, 0), (0, 5)), constant_values=0)[:, : SHAPE[1]]
    found = finder._codes.find(picture_struct(padded, LEVELS), **SEARCH, most=6)
    expected, runs, read = numpy_kernel.squares(picture, finder._codes, **SEARCH)
    assert (found.runs, found.read) == (runs, read) and read > 8
    assert sorted(found.word.tolist()) == sorted(word for word, _ in expected) and len(expected) >= 2
    for word, quad in expected:
        near = [np.abs(one - quad).max() for one, other in zip(found.corners, found.word, strict=True) if other == word]
        assert min(near) < 1e-9


@pytest.mark.parametrize("window", [1, 3, 5, 7, 9, 11, 13, 15])
@pytest.mark.parametrize("width", [2, 7, 63, 64, 65, 200])
def test_dark_runs_are_those_of_each_window_and_width(rng, finder, window, width):
    """Catches: sums of columns that leave some out; blocks that end early; a last block that writes too much."""
    picture = rng.choice([0, 90, 130, 255], (40, width)).astype(np.uint8)
    found = finder._codes.find(picture_struct(picture, LEVELS), window=window, steps=MOST_STEPS, least_px=5.0, most=1)
    dark = numpy_kernel.dark_pixels(picture, window, MOST_STEPS)
    assert found.runs == (np.diff(dark.astype(int), axis=1, prepend=0) > 0).sum()


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("marker_px", [20, 30, 60])
def test_a_page_is_found_at_any_angle_and_mirrored(finder, marker_px, mirrored):
    """Catches: a corner taken for the next one; a turned or a mirrored word; corners that are right for upright squares
    alone.
    """
    for turn_deg in range(0, 360, 15):
        turn = np.radians(turn_deg)
        scale, middle = marker_px / 26, np.array([73.0, 86.0])
        shift = (300, 300) - scale * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ middle
        way = seen_from(px_per_mm=scale, turn_deg=turn_deg, tilt=(4e-4, -3e-4), at=tuple(shift))
        picture = filmed(draw(way, shape=(640, 640)))
        straight, turned = finder.quick(picture[:, ::-1] if mirrored else picture)
        pages, none = (turned, straight) if mirrored else (straight, turned)
        assert len(pages) == 1 and not none
        assert corner_error_px(pages[0], way) < 2.5


def test_of_one_code_the_largest_squares_are_kept(finder):
    """Catches: many small squares that keep the badge's own from being found."""
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    wall = np.full((400, 640), 255, np.uint8)
    for row, column in itertools.product(range(8), range(25)):
        wall[10 + 24 * row :, 10 + 24 * column :][:12, :12] = cv2.aruco.generateImageMarker(known, 0, 12)
    wall[260:320, 100:160] = cv2.aruco.generateImageMarker(known, 0, 60)
    wall[260:320, 300:360] = cv2.aruco.generateImageMarker(known, 1, 60)
    found = finder._codes.find(picture_struct(wall, LEVELS), **SEARCH, most=6)
    assert np.bincount(found.word // 4).tolist() == [6, 1]
    sides = np.ptp(found.corners[:, :, 0], axis=1)
    assert sorted(sides)[-2:] == pytest.approx([60, 60], abs=1)


def test_what_the_kernel_cannot_take_is_refused(finder):
    """Catches: C that works with sums that overflow, or on memory which is not there."""
    struct = picture_struct(np.zeros((9, 9), np.uint8), LEVELS)
    for name, value in (("window", 17), ("window", 4), ("window", 0), ("steps", 31), ("steps", 0), ("most", 0)):
        with pytest.raises(ValueError):
            finder._codes.find(struct, **(SEARCH | {"most": 1} | {name: value}))
    with pytest.raises(ValueError):
        finder._codes.find(picture_struct(np.zeros((1, 9), np.uint8), LEVELS), **SEARCH, most=1)
    for words, cells in ((np.zeros((2, 3), np.uint64), 4), (np.zeros((2, 4), np.uint64), 9), (np.zeros((2, 4)), 4)):
        with pytest.raises(ValueError):
            SquareCodes(words, cells, 1, 5)
    assert memory_for(1920).ctypes.data % 16 == 0 and len(memory_for(1920)) % 16 == 0
