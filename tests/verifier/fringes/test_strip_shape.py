"""The shape of a strip's fringes, and what it leaves.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.strip_phase import StripLaw, StripPhase
from moireid.verifier.fringes.strip_shape import places_apart_rad, strip_shape

FRAMES, SAMPLES, FRINGES = 90, 160, 3.2
ALONG = np.linspace(-0.5, 0.5, SAMPLES)
#: Every angle as often, so that what stands still is like no fringe.
COURSE = 2 * np.pi * 7 * np.arange(FRAMES) / FRAMES
#: Light and contrast that change from frame to frame, counts.
LEVEL, CONTRAST = 120.0 + 20.0 * np.cos(np.arange(FRAMES) / 5.0), 50.0 + 15.0 * np.sin(np.arange(FRAMES) / 7.0)


def wave(phase: np.ndarray) -> np.ndarray:
    return np.cos(phase) - 0.2 * np.cos(3 * phase) + 0.1 * np.sin(2 * phase)


def slope(phase: np.ndarray) -> np.ndarray:
    return -np.sin(phase) + 0.6 * np.sin(3 * phase) + 0.2 * np.cos(2 * phase)


def filmed(*, added: np.ndarray | float = 0.0, ahead: np.ndarray | float = 0.0, vague: slice = slice(0)):
    """Profiles, law and phases of a strip; added: contrasts; ahead: rad, of places along it; vague: unread frames."""
    turned = 2 * np.pi * FRINGES * ALONG + COURSE[:, None]
    profiles = LEVEL[:, None] + CONTRAST[:, None] * (wave(turned + ahead) + added)
    law = StripLaw(np.zeros_like(turned), np.tile(FRINGES * ALONG, (FRAMES, 1)), np.zeros(FRAMES), np.zeros(FRAMES))
    sd, contrast = np.full(FRAMES, 0.01), CONTRAST.copy()
    sd[vague], contrast[vague], profiles[vague] = np.inf, 0.0, 7.0
    return turned, strip_shape(profiles, law, StripPhase(COURSE, sd, contrast, LEVEL, 1.0, 0.0))


def test_a_strip_of_one_shape_leaves_nothing_and_tells_its_slope():
    """Catches: counts for contrasts, where light changes; harmonics left out; a slope by the place along the strip."""
    turned, found = filmed()
    assert found is not None and found.clear.all()
    assert found.turned == pytest.approx(turned, abs=1e-5)
    assert np.abs(found.left).max() < 1e-5 and found.slope == pytest.approx(slope(turned), abs=1e-5)


def test_a_small_shift_is_left_as_slope_times_shift():
    """Catches: a shift of the wrong sign, or one that the shape takes up as its own blur."""
    ahead = 0.02 * np.sin(np.arange(FRAMES) / 4.0)[:, None] * np.sign(ALONG)
    turned, found = filmed(ahead=ahead)
    assert found is not None
    shown = slope(turned) * ahead
    shown -= np.outer(shown @ ALONG / (ALONG @ ALONG), ALONG)
    assert found.left == pytest.approx(shown, abs=0.004)


def test_what_stands_still_is_taken_away():
    """Catches: dirt or shading that is left, which correlates with fringes that stand still over it."""
    _, found = filmed(added=0.3 * np.sin(20 * ALONG))
    assert found is not None and np.abs(found.left.mean(axis=0)).max() < 1e-6
    assert found.left.std() < 0.02


def test_frames_that_cannot_be_read_are_left_out():
    """Catches: entries for unread frames, a shape learnt from them, and NaN from their contrast of 0."""
    unread = slice(20, 50)
    turned, found = filmed(vague=unread)
    assert found is not None and found.clear.sum() == FRAMES - 30 and not found.clear[unread].any()
    assert found.left.shape == found.slope.shape == found.turned.shape == (FRAMES - 30, SAMPLES)
    assert np.abs(found.left).max() < 1e-5 and found.slope == pytest.approx(slope(turned[found.clear]), abs=1e-5)
    assert filmed(vague=slice(0, FRAMES))[1] is None


def test_light_that_slopes_along_a_strip_moves_no_place():
    """Catches: a glare or a lamp to one side, which comes and goes, taken for places that move apart."""
    times = np.arange(FRAMES) / 30.0
    sloping = 0.4 * np.sin(2 * np.pi * times)[:, None] * ALONG
    none = np.zeros(FRAMES)
    assert places_apart_rad(filmed(added=sloping)[1], times, none, none) < 0.001
    apart = 0.05 * np.sin(np.arange(FRAMES) / 12.0)[:, None] * np.sin(7 * ALONG)
    for added in (0.0, sloping):
        found = places_apart_rad(filmed(ahead=apart, added=added)[1], times, none, none)
        assert found == pytest.approx(float(apart.std()), rel=0.25)
