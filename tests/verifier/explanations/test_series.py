"""One grating's phase in blocks of frames.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.fringe_signals import FPS, FRAMES, clock, series_of, trajectory
from moireid.verifier.limits import MOST_BLOCKS


def weighted_means(series, values: np.ndarray) -> np.ndarray:
    """The weighted mean of each stretch."""
    total = np.bincount(series.stretch, weights=series.weight)
    return np.bincount(series.stretch, weights=series.weight * values) / total


def test_a_block_is_the_mean_of_its_frames():
    """Catches: every third frame instead of a mean of three; frames at the end that are left out."""
    frames = 2 * MOST_BLOCKS + 2
    law = trajectory(frames=frames)
    series = series_of(law)
    wanted = [law[k : k + 3].mean() for k in range(0, frames, 3)]
    wanted -= np.mean(wanted)
    assert len(series.law_rad) == -(-frames // 3) <= MOST_BLOCKS
    assert series.law_rad == pytest.approx(wanted, abs=1e-12)
    assert series.times_s == pytest.approx([clock(frames)[k : k + 3].mean() for k in range(0, frames, 3)])


def test_a_block_ends_with_its_stretch():
    """Catches: a block across a cut, whose mean phase is that of neither side."""
    lengths = (700, 5, 601)
    stretch = np.repeat([3, 4, 9], lengths)
    jumps = np.repeat([0.0, 50.0, -20.0], lengths)
    law = trajectory(frames=len(stretch))
    series = series_of(law + jumps, stretch=stretch)
    assert np.array_equal(np.unique(series.stretch), [0, 1, 2])
    assert np.bincount(series.stretch).tolist() == [-(-length // 3) for length in lengths]
    begins = np.concatenate([[0], np.cumsum(lengths)]) / FPS
    for number in range(3):
        own = series.times_s[series.stretch == number]
        assert begins[number] <= own.min() and own.max() < begins[number + 1]
    assert np.abs(series.law_rad).max() < 5


def test_each_stretch_has_mean_0_and_weights_count():
    """Catches: one mean for the whole film; a plain mean, by which vague frames shift all others."""
    stretch = np.repeat([0, 1], [100, 200])
    law = trajectory() + 30.0 * stretch
    sd = np.where(np.arange(FRAMES) % 7 == 0, 0.5, 0.02)
    series = series_of(law, 0.8 * law + 3.0, stretch=stretch, phase_sd=sd)
    for values in (series.law_rad, series.measured_rad, series.rate_rad_per_s):
        assert weighted_means(series, values) == pytest.approx(np.zeros(2), abs=1e-12)
    assert abs(series.law_rad[stretch == 0].mean()) > 1e-4


def test_vague_frames_weigh_less_and_unreadable_ones_nothing():
    """Catches: weights that are not squares; a clear frame that outweighs a typical one; unread frames in a mean."""
    sd = np.full(FRAMES, 0.02)
    sd[10], sd[20], sd[30] = 0.2, 0.002, np.inf
    measured = trajectory()
    measured[30] = 1e3
    series = series_of(trajectory(), measured, phase_sd=sd, pose_sd=0.0)
    assert len(series.times_s) == FRAMES - 1
    assert series.weight[10] == pytest.approx(0.01) and series.weight[20] == 1.0 == series.weight[0]
    assert np.abs(series.measured_rad).max() < 10


def test_errors_below_those_of_light_and_codec_weigh_alike():
    """Catches: a film without noise, of which a few frames of even less outweigh all others."""
    sd = np.full(FRAMES, 1e-4)
    sd[::2] = 5e-3
    assert series_of(trajectory(), phase_sd=sd, pose_sd=0.0).weight == pytest.approx(np.ones(FRAMES))


def test_the_rate_is_the_derivative_of_the_law():
    """Catches: a rate per frame instead of one per second; a rate that keeps the mean of a steady sweep."""
    times = clock()
    wave = series_of(np.sin(2 * np.pi * 0.4 * times))
    wanted = 0.8 * np.pi * np.cos(2 * np.pi * 0.4 * times)
    assert wave.rate_rad_per_s[1:-1] == pytest.approx((wanted - wanted.mean())[1:-1], abs=0.02)
    assert series_of(0.7 * times).rate_rad_per_s == pytest.approx(np.zeros(FRAMES), abs=1e-9)


def test_the_rate_is_not_taken_across_a_gap():
    """Catches: a jump between two stretches read as a speed of hundreds of radians a second."""
    stretch = np.repeat([0, 1], [150, 150])
    law = 0.7 * clock() * np.where(stretch == 0, 1, -1) + 40.0 * stretch
    assert np.abs(series_of(law, stretch=stretch).rate_rad_per_s).max() < 1e-9
    paused = clock() + 2.0 * (np.arange(FRAMES) >= 150)
    sway = np.sin(2 * np.pi * 0.4 * clock()) + 9.0 * (np.arange(FRAMES) >= 150)
    assert np.abs(series_of(sway, times_s=paused).rate_rad_per_s).max() < 3.0


def test_places_and_views_go_with_their_frames():
    """Catches: rows and columns exchanged; places that are taken for views where one of them is not known."""
    frames = np.arange(FRAMES, dtype=float)
    place, views = np.column_stack([frames, 1000 - frames]), np.column_stack([2 * frames, 0.1 * frames])
    both = series_of(trajectory(), place_px=place, covariates=views)
    assert both.place_px == pytest.approx(place) and both.views == pytest.approx(views)
    assert series_of(trajectory(), place_px=place).views is None
    assert series_of(trajectory(), place_px=place).place_px == pytest.approx(place)
    assert series_of(trajectory(), covariates=views).place_px is None
    assert series_of(trajectory(), covariates=views).views == pytest.approx(views)
