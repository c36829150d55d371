"""How slow the errors of registration are: by closed forms, and by noise that a coder keeps for some frames."""

import math

import numpy as np
import pytest

from moireid.verifier.camera.fast_poses import SMOOTHED_S, slow_to_fast

FPS = 30.0
TIMES_S = np.arange(1200) / FPS
ONE = np.zeros(1200, np.int64)


def test_white_noise_is_as_slow_as_the_mean_leaves_it(rng: np.random.Generator) -> None:
    """Catches: the two parts exchanged, a mean of another length, and a unit of frames for seconds.

    Source: a Gaussian mean of s samples keeps 1 / (2 sqrt(pi) s) of white noise's power, and 1 / (sqrt(2 pi) s) of its
        own sample.
    """
    spread = SMOOTHED_S * FPS
    slow = 1 / (2 * math.sqrt(math.pi) * spread)
    fast = 1 - 2 / (math.sqrt(2 * math.pi) * spread) + slow
    found = slow_to_fast(rng.normal(size=(1200, 8)), TIMES_S, ONE)
    assert found == pytest.approx(math.sqrt(slow / fast), rel=0.03)


def test_noise_that_is_kept_for_ten_frames_is_mostly_slow(rng: np.random.Generator) -> None:
    """Catches: an estimate that does not see what a coder repeats; its size must not count."""
    kept = np.repeat(rng.normal(size=(120, 8)), 10, axis=0)
    assert 1.5 < slow_to_fast(kept, TIMES_S, ONE) == pytest.approx(slow_to_fast(0.01 * kept, TIMES_S, ONE))


def test_a_misregistered_frame_and_one_without_a_pose_do_not_count(rng: np.random.Generator) -> None:
    noise = rng.normal(size=(1200, 8))
    usual = slow_to_fast(noise, TIMES_S, ONE)
    noise[600], noise[300] = 1e6, np.nan
    assert slow_to_fast(noise, TIMES_S, ONE) == pytest.approx(usual, rel=0.05)
    assert slow_to_fast(np.full((1200, 8), np.nan), TIMES_S, ONE) == 0.0
    assert slow_to_fast(np.zeros((1200, 8)), TIMES_S, ONE) == 0.0


def test_frames_too_far_apart_to_be_smoothed_have_no_slow_part(rng: np.random.Generator) -> None:
    """Catches: rounding taken for what smoothing removes, by which errors were 10^15 times too large at 6 frames a
    second.
    """
    assert slow_to_fast(rng.normal(size=(90, 8)), np.arange(90) / 6, np.zeros(90, np.int64)) == 0.0
