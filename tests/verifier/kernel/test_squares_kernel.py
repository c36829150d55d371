"""Square markers found by the kernel, against NumPy and OpenCV.  Each test says what it catches."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.drawn_pages import MARKERS, draw, filmed, seen_from
from moireid.verifier.kernel.library import picture_struct
from moireid.verifier.kernel.squares import SquareCodes, memory_for
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.patches import marker_corners_mm

LEVELS = np.arange(256, dtype=np.float32)
SEARCH = {"window": 13, "steps": 9, "least_px": 9.0}


@pytest.fixture(scope="module")
def finder():
    return MarkerFinder(MARKERS)


def corner_error_px(page, way):
    """Largest distance of a found page's marker corners from those drawn, px."""
    corners = marker_corners_mm(MARKERS).reshape(-1, 1, 2)
    apart = cv2.perspectiveTransform(corners, page) - cv2.perspectiveTransform(corners, way)
    return float(np.linalg.norm(apart, axis=2).max())


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("marker_px", [20, 30, 60])
def test_a_page_is_found_at_any_angle_and_mirrored(finder, marker_px, mirrored):
    """Catches: a corner taken for the next one; a turned or a mirrored word; corners that are right for upright squares
    alone.
    """
    # Each size is seen at other angles.
    for turn_deg in range(marker_px % 45, 360, 45):
        turn = np.radians(turn_deg)
        scale, middle = marker_px / 26, np.array([73.0, 86.0])
        shift = (300, 300) - scale * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ middle
        way = seen_from(px_per_mm=scale, turn_deg=turn_deg, tilt=(4e-4, -3e-4), at=tuple(shift))
        picture = filmed(draw(way, shape=(640, 640)))
        straight, turned = finder.quick(picture[:, ::-1] if mirrored else picture)
        pages, none = (turned, straight) if mirrored else (straight, turned)
        assert len(pages) == 1 and not none
        assert corner_error_px(pages[0], way) < 2.5


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
