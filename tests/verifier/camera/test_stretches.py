"""Which frames are seen to join.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.camera.stretches import jumps, stretch_numbers

FPS = 30.0
TIMES = np.arange(240) / FPS


def hand(rng: np.random.Generator, noise: float = 0.004) -> np.ndarray:
    """Parallax of a hand's sway, with a pose's noise, (240, 2)."""
    sway = np.column_stack([0.15 * np.sin(2 * np.pi * 0.4 * TIMES), 0.05 * np.sin(2 * np.pi * 0.7 * TIMES)])
    return sway + noise * rng.standard_normal(sway.shape)


@pytest.mark.parametrize("noise", [0.0005, 0.004, 0.02])
def test_a_hand_s_motion_has_no_jump(rng, noise):
    """Catches: a fast or noisy true film cut to pieces, in which no motion is left."""
    assert not jumps(TIMES, hand(rng, noise)).any()


@pytest.mark.parametrize("step", [0.1, 0.3, 0.87])
def test_a_plain_cut_ends_a_stretch_where_it_is(rng, step):
    """Catches: a still picture at two views a whole turn apart (0.87 for the default badge) taken for one motion; a cut
    told a frame off, by which a frame of one take counts for the other.
    """
    cut = hand(rng)
    cut[100:, 0] += step
    numbers = stretch_numbers(TIMES, cut)
    assert np.flatnonzero(np.diff(numbers)).tolist() == [99]


def test_a_single_wrong_pose_ends_no_stretch(rng):
    """Catches: the pose of a near frontal page, whose two solutions lie close, taken for a cut whenever it flips."""
    course = hand(rng)
    course[100] += 0.1
    assert not jumps(TIMES, course).any()


@pytest.mark.parametrize(("lost", "count"), [(1, 1), (3, 1), (6, 2), (20, 2)])
def test_a_gap_ends_a_stretch(rng, lost, count):
    """Catches: motion behind a gap counted as seen; a stretch ended by a few frames that a codec or a call lost."""
    kept = np.r_[0:100, 100 + lost : 240]
    numbers = stretch_numbers(TIMES[kept], hand(rng, 0.001)[kept])
    assert numbers[-1] == count - 1
