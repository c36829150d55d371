"""Hands, captions and moved markers on pictures of noise.  Each test states what it would catch."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from moireid.badge import Badge
from moireid_lab.bench.forgers.cases import Shoot, cases
from moireid_lab.bench.forgers.edits import field_of

SCALE, LEFT, TOP, SIZE = 2.0, 60, 40, (720, 640)
#: Page mm -> px, from before and a little turned.
HOMOGRAPHY = np.array([[SCALE, 0.1, LEFT], [-0.05, SCALE, TOP], [1e-5, 0.0, 1.0]])
FRAMES = 60
NOISE = np.random.default_rng(1).integers(40, 216, SIZE).astype(np.uint8)
#: Cases whose edit follows the badge.
FOLLOWING = ("a hand over 60 % for 0.4 s", "a hand over 60 % for 1.5 s", "fingers over 15 %", "a caption over one row")
FOLLOWING += ("a sticker",)


def edited(badge: Badge, name: str, seed: int, frame: int) -> np.ndarray:
    (case,) = [case for case in cases() if case.name == name]
    edit = case.make(Shoot(badge, 1000.0, seed, FRAMES)).edit
    assert edit is not None
    return edit(frame, NOISE.copy(), HOMOGRAPHY)


def rect(x0: float, y0: float, x1: float, y1: float, *, grown: int = 0, by: np.ndarray = HOMOGRAPHY) -> np.ndarray:
    """Pixels within a rectangle on the page, grown by some."""
    corners = np.array([[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], float)
    mask = np.zeros(SIZE, np.uint8)
    cv2.fillPoly(mask, np.round(cv2.perspectiveTransform(corners, by)).astype(np.int32), 1)
    return cv2.dilate(mask, np.ones((2 * grown + 1,) * 2, np.uint8)).astype(bool)


def markers_of(badge: Badge) -> np.ndarray:
    half = badge.markers.size_mm / 2
    return np.any([rect(x - half, y - half, x + half, y + half) for x, y in badge.markers.centers_mm], axis=0)


@pytest.mark.parametrize("seed", [0, 7])
@pytest.mark.parametrize("name", FOLLOWING)
def test_what_lies_on_the_badge_covers_its_fringes_and_no_marker(ada, name, seed):
    """Catches: a cover over markers, whose wrong pose would be blamed; one next to the badge, which spoils nothing."""
    changed = np.any([edited(ada, name, seed, frame) != NOISE for frame in range(0, FRAMES, 6)], axis=0)
    assert not changed[markers_of(ada)].any()
    # A hand's edge is soft over 3 px.
    field = rect(*field_of(ada), grown=4)
    assert not changed[~field].any() and changed[field].mean() > 0.01
