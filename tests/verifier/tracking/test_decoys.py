"""Squares that are near a badge and are not its own: they hide nothing, and the time that they take is counted."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.drawn_pages import CORNERS, MARKERS, draw, filmed, seen_from
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.finding.page_groups import MOST_OF_ONE, MOST_TRIALS, Trials, pages_of, same_page


@pytest.mark.parametrize("shape", [(64, 1), (1, 64), (1, 1)])
def test_a_picture_too_small_for_a_marker_shows_none(shape: tuple[int, int]) -> None:
    """Catches: a film of one column of pixels that ends the process that reads it."""
    assert MarkerFinder(MARKERS).quick(np.zeros(shape, np.uint8)) == ([], [])


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


def test_a_wall_of_markers_takes_a_bounded_number_of_fits(rng: np.random.Generator) -> None:
    """Catches: a wall of markers whose grouping takes a third of a second in each look, which no budget counts."""
    side = np.array([[0, 0], [20, 0], [20, 20], [0, 20]], float)
    quads = side + rng.uniform(0, 600, (4 * MOST_OF_ONE, 1, 2))
    index, trials = [k % 4 for k in range(len(quads))], Trials()
    pages_of(quads, index, CORNERS, trials)
    assert MOST_TRIALS <= trials.number < MOST_TRIALS + 20 < 6 * MOST_OF_ONE**2
    # Two whole pages are told apart without a look at all pairs.
    pages = [seen_from(px_per_mm=1.6, at=(60.0, 40.0)), seen_from(px_per_mm=1.9, at=(460.0, 60.0))]
    two = np.concatenate([cv2.perspectiveTransform(CORNERS.reshape(-1, 1, 2), page).reshape(4, 4, 2) for page in pages])
    trials = Trials()
    assert len(pages_of(two, [0, 1, 2, 3] * 2, CORNERS, trials)) == 2
    assert trials.number < 20
