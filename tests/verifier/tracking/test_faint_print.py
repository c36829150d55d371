"""Faint print: its markers found and followed, and error bars that grow as it fades.  Beside each test: what it would
catch.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kit.drawn_pages import CORNERS, MARKERS, draw, filmed, seen_from
from moireid.verifier.fringes.strip_phase import StripPhase, rounding_rad
from moireid.verifier.picture import LINEAR_COUNTS, counts_of
from moireid.verifier.tracking.finding.markers import FAINT_EVERY, MarkerFinder, faint_turns
from moireid.verifier.tracking.finding.page_groups import same_page
from moireid.verifier.tracking.registration import FOLLOWED_CORRELATION, PageRegistrar


@pytest.fixture(scope="module")
def faint():
    """A page whose black and white are 8 counts apart."""
    truth = seen_from(px_per_mm=1.1)
    return truth, draw(truth, ink=180.0, paper=188.0)


def test_faint_markers_are_found_by_every_third_search(faint, rng):
    """Catches: a threshold that faded print does not reach; faint searches left out."""
    truth, picture = faint
    finder, turns = MarkerFinder(MARKERS), faint_turns()
    pages = [finder.pages(filmed(picture, rng, noise=0.7), faint=next(turns)) for _ in range(2 * FAINT_EVERY)]
    assert [len(found) for found in pages] == [0, 0, 1, 0, 0, 1]
    assert same_page(pages[2][0], truth, CORNERS)


def test_faint_print_is_followed_in_spite_of_noise(faint, rng):
    """Catches: noise taken for another page; a contrast of the page instead of a marker."""
    truth, picture = faint
    found = PageRegistrar(MARKERS).register(filmed(picture, rng, noise=2.4), truth)
    assert found.correlation < FOLLOWED_CORRELATION and found.clear
    # Blurred, black and white are somewhat less than 8 counts apart.
    assert 5.0 < found.contrast < 9.0


@pytest.mark.parametrize("level", [40.0, 110.0, 200.0])
def test_what_is_held_is_what_rounding_does_to_light(level, rng):
    """Catches: the coding's derivative turned over; counts taken for light; a phase that errs less as print fades."""
    light = level + rng.uniform(-4, 4, 20000).astype(np.float32)
    rounded = float(np.std(LINEAR_COUNTS[counts_of(light)] - light))
    even = np.ones(50)
    strip = StripPhase(even, 0.1 * even, 6.0 * even, level * even, 1.0, 0.0)
    assert rounding_rad(strip) == pytest.approx(rounded / 6.0, rel=0.1)
    assert rounding_rad(replace(strip, contrast=60.0 * even)) == pytest.approx(rounding_rad(strip) / 10)
    # What a hand hides has neither phase nor contrast.
    hidden = np.arange(50) < 20
    covered = replace(strip, contrast=np.where(hidden, 0.1, 6.0), phase_sd_rad=np.where(hidden, 5.0, 0.1))
    assert rounding_rad(covered) == pytest.approx(rounding_rad(strip))
    assert rounding_rad(replace(strip, contrast=0.0 * even)) == 0.0
