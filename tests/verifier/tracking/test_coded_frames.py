"""Pages found and registered by a thin coded frame.  Beside each test: what it would catch."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from kit.drawn_frames import FRAME, corners_apart_px, draw_frame
from kit.drawn_pages import filmed, nudged, seen_from
from moireid.verifier.tracking.finding.coded_frames import FrameFinder
from moireid.verifier.tracking.registration import PageRegistrar

SHAPE = (360, 480)


def turned_about(page: np.ndarray, degrees: float) -> np.ndarray:
    """The page with its picture turned about the picture's middle."""
    turn = np.eye(3)
    turn[:2] = cv2.getRotationMatrix2D(((SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2), degrees, 1.0)
    return turn @ page


def middling(*, px_per_mm: float = 1.45, tilt=(2.0e-4, -1.3e-4)) -> np.ndarray:
    """A page whose frame lies in the middle of the picture."""
    page = seen_from(px_per_mm=px_per_mm, tilt=tilt)
    ((x, y),) = cv2.perspectiveTransform(np.array([[[80.0, 75.0]]]), page)[0]
    return nudged(page, SHAPE[1] / 2 - x, SHAPE[0] / 2 - y)


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0, 270.0])
def test_a_frame_is_found_the_right_way_round(degrees, rng):
    """Catches: notches read anticlockwise, from a wrong corner, or of a turned page."""
    page = turned_about(middling(), degrees)
    straight, mirrored = FrameFinder(FRAME).either_way(filmed(draw_frame(page, SHAPE), rng, noise=1.5))
    assert corners_apart_px(straight[0], page) < 1.5
    assert mirrored == []


def test_a_mirrored_frame_is_found_as_mirrored(rng):
    """Catches: a self-view read as a turned page, whose fringes would move the wrong way; x of the wrong picture."""
    page = middling()
    luma = np.ascontiguousarray(filmed(draw_frame(page, SHAPE), rng, noise=1.5)[:, ::-1])
    straight, mirrored = FrameFinder(FRAME).either_way(luma)
    assert straight == []
    assert corners_apart_px(mirrored[0], page) < 1.5


def test_what_is_no_frame_of_this_layout_is_no_page(rng):
    """Catches: any window or table taken for a page; the board's own outline; another layout's notches."""
    page, finder = middling(), FrameFinder(FRAME)
    plain = replace(FRAME, notches_mm=())
    assert finder.either_way(filmed(draw_frame(page, SHAPE, plain), rng, noise=1.5)) == ([], [])
    x0, _, x1, _ = FRAME.rect_mm
    other = replace(FRAME, notches_mm=tuple((x0 + x1 - c, b, x0 + x1 - a, d) for a, b, c, d in FRAME.notches_mm[:3]))
    assert finder.either_way(filmed(draw_frame(page, SHAPE, other), rng, noise=1.5))[0] == []


def test_the_whole_frame_is_registered_to_a_small_part_of_a_pixel(rng):
    """Catches: a template off by half a sample; samples of the sides in each other's places."""
    page = middling()
    found = PageRegistrar(FRAME).register(filmed(draw_frame(page, SHAPE), rng, noise=1.5), nudged(page, 0.7, -0.6))
    assert found is not None and found.correlation > 0.97
    assert corners_apart_px(found.homography, page) < 0.1


@pytest.mark.parametrize(("rect", "held"), [((10.0, 85.0, 26.0, 100.0), True), ((10.0, 25.0, 26.0, 125.0), False)])
def test_a_thumb_over_a_side_is_borne_but_no_side_may_be_missing(rect, held, rng):
    """Catches: a page that slides along its top and bottom because one side is hidden, up to 7 px; a thumb that ends
    the track.
    """
    page = middling()
    luma = filmed(draw_frame(page, SHAPE), rng, noise=1.5)
    x0, y0, x1, y1 = rect
    corners = cv2.perspectiveTransform(np.array([[[x0, y0]], [[x1, y0]], [[x1, y1]], [[x0, y1]]]), page)
    cv2.fillConvexPoly(luma, corners.round().astype(np.int32), 150)
    found = PageRegistrar(FRAME).register(luma, nudged(page, 0.4, 0.3))
    assert (found is not None) == held
    if found is not None:
        assert corners_apart_px(found.homography, page) < 0.2
