"""Fringes unwrapped across hidden frames, and with wrong timestamps in the file.

Beside each test: what it would catch.
"""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.decision.figures import figures_of
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.signals import _combine
from moireid.verifier.fringes.sinusoid import joined_frames, unwrap
from moireid.verifier.fringes.strip_phase import StripPhase
from moireid.verifier.measuring import MAX_GAP_S, MAX_STEP_RAD

FRAMES = 240
TIMES = np.arange(FRAMES) / 30
COURSE = 0.8 * np.sin(2 * np.pi * 0.4 * TIMES)


def combined(hidden: slice, seed: int, *, noise: float = 0.01, gain: float = 1.0) -> GratingSignal:
    """Four strips, whose fringes are hidden in some frames: what is seen there is any phase."""
    rng = np.random.default_rng(seed)
    strips = []
    for strip in range(4):
        phase, sd = gain * COURSE + strip + noise * rng.standard_normal(FRAMES), np.full(FRAMES, noise)
        phase[hidden], sd[hidden] = rng.uniform(-np.pi, np.pi, len(phase[hidden])), 5.0
        even = np.ones(FRAMES)
        strips.append(StripPhase(np.angle(np.exp(1j * phase)), sd, even, even, 0.1, 0.001, predicted_rad=COURSE))
    return _combine(strips, 0.005, TIMES, np.zeros(FRAMES, np.int64), np.zeros(FRAMES), np.ones(FRAMES, bool))


@pytest.mark.parametrize("hidden", [slice(100, 103), slice(100, 130), slice(0, 40), slice(200, 240)])
def test_fringes_that_a_hand_hides_for_a_moment_lose_no_turn(hidden):
    """Catches: noise of hidden fringes that is followed, by which the rest of a true film stood a turn off in a third
    of all cases, and was rejected.
    """
    for seed in range(8):
        signal = combined(hidden, seed)
        clear = np.isfinite(signal.phase_sd_rad)
        assert clear.sum() == FRAMES - len(TIMES[hidden])
        assert np.ptp((signal.measured_rad - signal.predicted_rad)[clear]) < 0.1


def test_hiding_fringes_for_a_moment_does_not_put_forged_ones_right():
    """Catches: every stretch between hidden frames laid upon the prediction, by which a forger would be helped."""
    told = figures_of(combined(slice(100, 103), 1, gain=0.4))
    assert told.gain_ratio == pytest.approx(0.4, abs=0.01)


def test_a_strip_s_error_bar_is_that_of_its_clear_frames():
    """Catches: hidden frames in the median; one over the sum of information, which is the grating's."""
    for noise in (0.01, 0.1):
        signal = combined(slice(0, 150), 2, noise=noise)
        assert signal.strip_sd_rad == pytest.approx(np.full(4, noise))


def wrapped(phase: np.ndarray) -> np.ndarray:
    return np.angle(np.exp(1j * phase))


def test_frames_join_until_a_gap_or_a_step_of_half_a_turn():
    """Catches: a split a frame early or late; a step backwards that is not seen; a gap that is one frame too short."""
    times, predicted = TIMES[:10].copy(), np.zeros(10)
    assert [list(part) for part in joined_frames(predicted, times)] == [list(range(10))]
    times[4:] += MAX_GAP_S
    predicted[7:] -= MAX_STEP_RAD + 0.01
    assert [list(part) for part in joined_frames(predicted, times)] == [[0, 1, 2, 3], [4, 5, 6], [7, 8, 9]]
    # Exactly at both limits nothing ends.
    even = np.arange(3) * MAX_GAP_S
    assert len(joined_frames(np.arange(3) * MAX_STEP_RAD, even)) == 1


def test_a_phase_of_many_turns_comes_back():
    """Catches: a phase that is folded upon the prediction, or follows it: the fringes go three times as far here."""
    predicted = 6.0 * np.sin(2 * np.pi * 0.3 * TIMES)
    found = unwrap(wrapped(3 * predicted + 1.0), predicted, [np.arange(FRAMES)])
    assert np.ptp(found - 3 * predicted) < 1e-9


def test_whole_turns_between_segments_are_the_nearest_and_nothing_else():
    """Catches: a segment laid upon the prediction, which would forgive a forger more than whole turns."""
    segments = [np.arange(150), np.arange(150, FRAMES)]
    stray = np.where(np.arange(FRAMES) < 150, 0.0, 2 * np.pi * 3 + 1.2)
    found = unwrap(wrapped(COURSE + stray), COURSE, segments)
    apart = found - COURSE - (found - COURSE)[0]
    assert apart[:150] == pytest.approx(np.zeros(150), abs=1e-9)
    assert apart[150:] == pytest.approx(np.full(FRAMES - 150, 1.2), abs=1e-9)
