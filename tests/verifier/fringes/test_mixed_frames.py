"""Frames mixed with their neighbours.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.frames import own_frame
from moireid.verifier.fringes.mixed_frames import carried_rad, mixed_share
from moireid.verifier.limits import MAX_MIXED_SHARE

TIMES = np.arange(200) / 30.0
LAW = 0.8 * np.sin(2 * np.pi * 0.5 * TIMES)
CARRIED = 1.2 * np.sin(2 * np.pi * 0.8 * TIMES + 1.0)
TURN = CARRIED - np.diff(LAW, prepend=LAW[0])


def noisy(contrast: np.ndarray, noise: float = 0.02) -> np.ndarray:
    return contrast * (1 + noise * np.random.default_rng(2).standard_normal(len(contrast)))


@pytest.mark.parametrize("weight", [0.2, 0.3, 0.4])
def test_the_weight_of_the_frame_before_is_told_by_the_contrast(weight):
    """Catches: a turn by the page alone, or by the parallax alone; a slope of the contrast's square."""
    contrast = noisy(np.abs(1 - weight + weight * np.exp(1j * TURN)))
    found = mixed_share(contrast, CARRIED, LAW)
    # The first order, whose logarithm falls a little faster, less three error bars.
    assert 0.7 < found / (weight * (1 - weight)) < 1.5
    assert found > MAX_MIXED_SHARE


def test_a_long_exposure_is_no_mixing():
    """Catches: a dim room's blur taken for noise reduction; contrast that goes with the parallax."""
    blurred = np.abs(np.sinc(TURN / 2 / np.pi))
    assert mixed_share(noisy(blurred), CARRIED, LAW) <= MAX_MIXED_SHARE
    assert mixed_share(noisy(1 - 0.3 * LAW - 0.2 * LAW**2), CARRIED, LAW) < 0.02


def test_noise_and_too_few_frames_tell_nothing():
    """Catches: an error bar that is left out; a table of no rank."""
    for seed in range(20):
        contrast = 1 + 0.1 * np.random.default_rng(seed).standard_normal(200)
        assert mixed_share(contrast, CARRIED, LAW) < MAX_MIXED_SHARE
    assert mixed_share(np.ones(200), np.zeros(200), np.zeros(200)) == 0.0
    assert mixed_share(np.where(np.arange(200) < 160, np.nan, 1.0), CARRIED, LAW) == 0.0


def test_a_page_that_moves_right_carries_its_fringes_along():
    """Catches: the wrong sign; the other axis; a frame that follows a gap."""
    moved = np.zeros((6, 3, 3))
    for frame, homography in enumerate(moved):
        homography[:] = [[2.0, 0.1, 100 + 3.0 * frame], [0.0, 2.0, 50.0], [0.0, 0.0, 1.0]]
    times = np.array([0, 1, 2, 5, 6, 7]) / 30.0
    # The pixel that shows x now showed x + 1.5 mm before.
    for axis, share in (("x", 1.0), ("y", 0.0), (60.0, 0.5), (120.0, -0.5)):
        frame = own_frame(axis, (210.0, 297.0))
        carried = carried_rad(moved, frame, frame.places((70.0, 80.0)), 0.04, times)
        assert carried == pytest.approx(share * 2 * np.pi * 0.04 * 1.5 * np.array([0, 1, 1, 0, 1, 1]), abs=1e-9)
