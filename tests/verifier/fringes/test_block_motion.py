"""Places within a strip that move apart.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.strip_phase import StripLaw, StripPhase
from moireid.verifier.fringes.strip_shape import BLOCKS, places_apart_rad, strip_shape

FRAMES, SAMPLES, FRINGES = 180, 160, 3.2
TIMES = np.arange(FRAMES) / 30.0
ALONG = np.linspace(-0.5, 0.5, SAMPLES)
COURSE = 0.9 * np.sin(2 * np.pi * 0.4 * TIMES)


def seen(deviation: np.ndarray | float = 0.0, *, noise: float = 0.0, dirt: np.ndarray | float = 0.0) -> float:
    """The figure for a strip whose places deviate by `deviation`, (T, N) rad; fringes are rounded squares."""
    phase = 2 * np.pi * FRINGES * ALONG + COURSE[:, None] + deviation
    wave = np.cos(phase) - 0.2 * np.cos(3 * phase) + 0.1 * np.sin(2 * phase)
    level, contrast = 120.0, 60.0
    profiles = level + contrast * wave + dirt + noise * np.random.default_rng(3).standard_normal(wave.shape)
    per_frequency = np.broadcast_to(FRINGES * ALONG, wave.shape)
    law = StripLaw(np.zeros(wave.shape), per_frequency, np.zeros(FRAMES), np.zeros(FRAMES))
    sd = np.full(FRAMES, 0.01)
    found = StripPhase(COURSE, sd, np.full(FRAMES, contrast), np.full(FRAMES, level), 1.0, 0.0)
    return places_apart_rad(strip_shape(profiles, law, found), TIMES, COURSE, np.zeros(len(TIMES)))


def patches(size_rad: float, count: int, hz: float = 0.3) -> np.ndarray:
    """Neighbouring patches that deviate slowly in opposite directions, so that their mean stays still."""
    sign = np.where(np.arange(SAMPLES) * count // SAMPLES % 2, 1.0, -1.0)
    return size_rad * np.sqrt(2) * np.sin(2 * np.pi * hz * TIMES + 1.0)[:, None] * sign


def test_a_true_strip_moves_as_one():
    """Catches: the fringe's shape taken for a deviation; noise that is not averaged."""
    assert seen() < 0.005
    assert seen(noise=6.0) < 0.03


@pytest.mark.parametrize("count", [4, BLOCKS])
def test_patches_on_clocks_of_their_own_are_told_by_their_size(count):
    """Catches: a mean over the strip, in which they cancel; a shift in other units than radians."""
    assert seen(patches(0.12, count), noise=3.0) == pytest.approx(0.12, rel=0.3)
    assert seen(patches(0.24, count), noise=3.0) > 1.7 * seen(patches(0.12, count), noise=3.0)


def test_a_sheet_with_uneven_air_moves_as_one():
    """Catches: places above more air, which move further by a share of the motion, taken for patches; a share without
    a bound, under which any motion of a patch with the badge's own would pass."""
    sign = np.where(np.arange(SAMPLES) * 4 // SAMPLES % 2, 1.0, -1.0)
    assert seen(0.08 * COURSE[:, None] * sign) < 0.02
    assert seen(0.3 * COURSE[:, None] * sign) > 0.04


def test_frames_that_cannot_be_read_do_not_count():
    """Catches: the noise of a blank strip taken for deviations; NaN where there are no fringes at all."""
    law = StripLaw(np.zeros((9, 40)), np.zeros((9, 40)), np.zeros(9), np.zeros(9))
    none = np.zeros(9)
    blank = StripPhase(none, np.full(9, np.inf), none, none, 1.0, 0.0)
    assert places_apart_rad(strip_shape(np.full((9, 40), 100.0), law, blank), np.arange(9) / 30, none, none) == 0.0
    flat = StripPhase(none, none, none, none, 1.0, 0.0)
    assert places_apart_rad(strip_shape(np.full((9, 40), 100.0), law, flat), np.arange(9) / 30, none, none) == 0.0
