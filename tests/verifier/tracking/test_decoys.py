"""Squares that are near a badge and are not its own: they hide nothing, and the time that they take is counted."""

from __future__ import annotations

import cv2
import numpy as np

from kit.drawn_pages import CORNERS, MARKERS, draw, filmed, seen_from
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.finding.page_groups import (
    MOVED_SHARE,
    same_page,
    where_it_was,
)


def test_a_clear_page_next_to_a_small_faint_one_does_not_hide_it() -> None:
    """Catches: the closer look that is left out because squares were found, whichever page they are of."""
    small, clear = seen_from(px_per_mm=0.44, at=(200.0, 130.0)), seen_from(px_per_mm=0.9, at=(266.0, 110.0))
    shape = (480, 640)
    picture = np.minimum(draw(small, ink=110.0, paper=140.0, shape=shape), draw(clear, shape=shape))
    found = 0
    for seed in range(6):
        luma = filmed(picture, np.random.default_rng(seed), noise=2.0)
        found += any(same_page(page, small, CORNERS) for page in MarkerFinder(MARKERS).near(luma, small)[0])
    # The quick look, enlarged or not, finds it in one of six.
    assert found == 6


def test_markers_in_false_places_are_left_out_of_a_page_that_was_there_a_moment_ago() -> None:
    """Catches: RANSAC over swapped markers in each frame, for ten times as long; a marker that is left out because the
    page moved far; a page near markers of two numbers, which may be two pages.
    """
    before = seen_from(px_per_mm=1.6, at=(60.0, 40.0))
    true = cv2.perspectiveTransform(CORNERS.reshape(-1, 1, 2), before).reshape(4, 4, 2)
    swapped = true[[2, 1, 0, 3]] + np.array([9.0, -4.0])
    assert where_it_was(swapped, [0, 1, 2, 3], CORNERS, before) == [1, 3]
    # As far as a page may move, and turned: two of its markers are then nearer than half its size.
    turn = cv2.getRotationMatrix2D((200.0, 150.0), 25.0, 1.0)
    moved = cv2.transform(true + np.array([80.0, 0.0]), turn)
    apart = np.linalg.norm((moved - true).mean(axis=1), axis=1) / np.ptp(true.mean(axis=1), axis=0).max()
    assert apart.min() < MOVED_SHARE < apart.max()
    assert where_it_was(moved, [0, 1, 2, 3], CORNERS, before) == [0, 1, 2, 3]
    twice = np.concatenate([swapped, swapped[:1]])
    assert where_it_was(twice, [0, 1, 2, 3, 0], CORNERS, before) == [0, 1, 2, 3, 4]
    elsewhere = swapped + np.array([900.0, 0.0])
    assert where_it_was(elsewhere, [0, 1, 2, 3], CORNERS, before) == [0, 1, 2, 3]
