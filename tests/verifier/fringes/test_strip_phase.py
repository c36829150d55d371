"""Frequency and phase of synthetic fringes, against the formula that made them.  Beside each test: what it would catch.

brightness = level + slope + contrast cos(2 pi f (X - middle) + phase), with two harmonics, a trend and noise.
"""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.strip_phase import (
    StripLaw,
    StripPhase,
    covered_frames,
    measure_strip,
)

LENGTH_MM = 76.0
SAMPLES = 152
FRAMES = 48
ALONG = np.linspace(40.0, 40.0 + LENGTH_MM, SAMPLES)
MIDDLE = (ALONG[0] + ALONG[-1]) / 2
#: Of the published prototype: p_f = 0.508, p_r = 0.52 mm.
BEAT = 1 / 0.52 - 1 / 0.508
BAND = (BEAT - 0.0157, BEAT + 0.0157)


def straight(frames: int = FRAMES, fixed: np.ndarray | None = None) -> StripLaw:
    """A view geometry that stretches nothing, or by the given cycles (T, N)."""
    bend = np.zeros((frames, SAMPLES)) if fixed is None else fixed
    centre = np.array([np.interp(MIDDLE, ALONG, row) for row in bend])
    return StripLaw(bend, np.tile(ALONG, (frames, 1)), centre, np.full(frames, MIDDLE))


def fringes(
    phase: np.ndarray,
    frequency: float = BEAT,
    *,
    bend: np.ndarray | None = None,
    contrast=30.0,
    second=(0.35, 0.8),
    third=(0.12, -1.1),
) -> np.ndarray:
    """Profiles (T, N) in counts, on paper that is lit from the side, with the harmonics of a lens that focuses."""
    turn = 2 * np.pi * frequency * (ALONG - MIDDLE)[None, :] + phase[:, None]
    if bend is not None:
        turn = turn + 2 * np.pi * (bend - np.array([np.interp(MIDDLE, ALONG, row) for row in bend])[:, None])
    wave = np.cos(turn) + second[0] * np.cos(2 * turn + second[1]) + third[0] * np.cos(3 * turn + third[1])
    light = 120.0 + 0.4 * (ALONG - MIDDLE)[None, :] + 10.0 * np.sin(np.arange(len(phase)) / 9.0)[:, None]
    return light + contrast * wave


def wandering(rng: np.random.Generator, frames: int = FRAMES) -> np.ndarray:
    """A course of phase that visits every angle."""
    t = np.arange(frames) / 30.0
    return 2.5 * np.sin(3.1 * t + rng.uniform(0, 6)) + 1.3 * np.sin(5.3 * t + rng.uniform(0, 6))


def measured(profiles: np.ndarray, law: StripLaw | None = None, band: tuple[float, float] = BAND) -> StripPhase:
    return measure_strip(profiles, law or straight(len(profiles)), LENGTH_MM, band)


def turned(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Difference of two phases on the circle."""
    return np.angle(np.exp(1j * (a - b)))


# Without noise: the formula itself.


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_phase_and_frequency_of_a_pure_fringe(rng, sign):
    """Catches: the sign of the phase; a phase at the strip's beginning; |f| with the wrong sign."""
    phase = wandering(rng)
    band = BAND if sign > 0 else (-BAND[1], -BAND[0])
    found = measured(fringes(phase, sign * BEAT), band=band)
    # Fringes of square form over a slope: the fit itself has an error of two thousandths of a fringe.
    assert found.frequency_per_mm == pytest.approx(sign * BEAT, abs=2e-5)
    assert np.abs(turned(found.phase_rad, phase)).max() < 0.01
    assert found.contrast == pytest.approx(30.0, rel=0.02)


def test_light_and_contrast_do_not_enter_the_phase(rng):
    """Catches: a level that leaks into the phase; a fit to one light for the whole film."""
    phase = wandering(rng)
    profiles = fringes(phase, second=(0.0, 0.0), third=(0.0, 0.0))
    shaded = profiles * (0.4 + 0.5 * rng.random((FRAMES, 1))) + 60.0 * rng.random((FRAMES, 1))
    one, two = measured(profiles), measured(shaded)
    assert np.abs(turned(one.phase_rad, two.phase_rad)).max() < 1e-4
    assert one.frequency_per_mm == pytest.approx(two.frequency_per_mm, abs=5e-6)


def test_moving_the_strip_on_the_page_moves_nothing(rng):
    """Catches: page coordinates in the phase, which would tie it to the frequency's error."""
    phase = wandering(rng)
    here = straight()
    there = StripLaw(
        here.fixed + 3.0, here.per_frequency + 90.0, here.fixed_middle + 3.0, here.per_frequency_middle + 90.0
    )
    one, two = (measured(fringes(phase), law) for law in (here, there))
    assert np.abs(turned(one.phase_rad, two.phase_rad)).max() < 1e-6
    assert one.frequency_per_mm == pytest.approx(two.frequency_per_mm, abs=1e-9)


def test_the_view_s_own_stretch_is_taken_out(rng):
    """Catches: a frequency that drifts with distance (2.5 % at 1 m); the geometry of the mean frame used for all."""
    phase = wandering(rng)
    # A camera that comes nearer: the parallax across the strip grows, and bends.
    share = np.linspace(0.0008, 0.0016, FRAMES)[:, None]
    bend = share * (ALONG - MIDDLE)[None, :] + 2e-5 * share / 0.001 * (ALONG - MIDDLE)[None, :] ** 2
    profiles = fringes(phase, bend=bend)
    found = measured(profiles, straight(fixed=bend))
    # The refinement fits no harmonics, and over few angles of phase theirs do not cancel: 1e-4, 1/40 of a step.
    assert found.frequency_per_mm == pytest.approx(BEAT, abs=1.5e-4)
    assert np.abs(turned(found.phase_rad, phase)).max() < 0.02
    blind = measured(profiles)
    assert abs(blind.frequency_per_mm - BEAT) > 5e-4


def test_the_overtone_is_the_third_harmonic_turned_to_the_fundamental(rng):
    """Catches: an overtone that turns with the fringes, is in counts, or is that of the second harmonic."""
    phase = wandering(rng)
    one, two = (measured(fringes(phase, contrast=contrast)) for contrast in (30.0, 10.0))
    # The fit's own error, as in the phase: a slope is not orthogonal to fringes that are no whole number.
    assert np.abs(one.overtone - 0.12 * np.exp(-1.1j)).max() < 0.01
    assert np.abs(one.overtone - two.overtone).max() < 0.01
    short = measure_strip(fringes(phase), straight(), 30.0, BAND)
    assert short.overtone.shape == (FRAMES,) and not short.overtone.any()


# With noise: unbiased, and honest about itself.


def noisy_runs(count: int = 24, noise: float = 12.0):
    """Frequencies, their bars, phase errors and their bars of films with white noise."""
    for seed in range(count):
        rng = np.random.default_rng(seed)
        phase = wandering(rng)
        frequency = BEAT + rng.uniform(-0.012, 0.012)
        profiles = fringes(phase, frequency) + noise * rng.standard_normal((FRAMES, SAMPLES))
        found = measured(profiles)
        yield frequency, found, turned(found.phase_rad, phase)


def test_the_frequency_is_unbiased_and_its_bar_honest():
    """Catches: a search grid that shows through; a bar that is the spread of blocks and not of their mean."""
    off, bars = np.array([(found.frequency_per_mm - f, found.frequency_sd) for f, found, _ in noisy_runs()]).T
    # An eighth of half a symbol's step.
    assert np.abs(off).max() < 5e-4
    assert abs(off.mean()) < 3 * off.std() / np.sqrt(len(off))
    # The bar comes from four blocks, so each is good to about 40 %; their mean over 24 films is not.
    assert 0.6 < off.std() / np.sqrt(np.mean(bars**2)) < 1.6


@pytest.mark.claim("The phase error matches its bar")
def test_the_phase_error_matches_its_bar():
    """Catches: a variance for a deviation; harmonics counted as noise; a bar that ignores the contrast."""
    errors, bars = [], []
    for _, found, error in noisy_runs(12):
        errors.append(error - error.mean())
        bars.append(found.phase_sd_rad)
    ratio = np.std(errors) / np.sqrt(np.mean(np.square(bars)))
    # White noise here; the bar allows for neighbours that share pixels, by `limits.STRIP_NOISE_RATIO` = 1.4.
    assert 0.6 < ratio < 0.85


def test_a_trend_is_no_fringe(rng):
    """Catches: shading taken for the slowest beat: a light from the side, six times as strong as the fringes."""
    phase = wandering(rng)
    profiles = fringes(phase, contrast=8.0) + 1.2 * (ALONG - MIDDLE)[None, :]
    found = measured(profiles + rng.standard_normal(profiles.shape))
    assert found.frequency_per_mm == pytest.approx(BEAT, abs=3e-4)
    assert np.abs(turned(found.phase_rad, phase)).max() < 0.25


def test_a_frozen_fringe_is_measured_as_frozen(rng):
    """Catches: a phase that takes over the predicted motion, which would accept every forgery."""
    still = np.full(FRAMES, 0.9)
    bend = 0.3 * np.sin(np.arange(FRAMES) / 5.0)[:, None] * np.ones((1, SAMPLES))
    found = measured(fringes(still) + rng.standard_normal((FRAMES, SAMPLES)), straight(fixed=bend))
    assert np.abs(turned(found.phase_rad, still)).max() < 0.05


# The search.


def test_of_two_fringes_the_one_in_the_band_is_read(rng):
    """Catches: a search beyond its band; a band that is widened by the refinement."""
    phase = wandering(rng)
    both = fringes(phase, contrast=12.0) + fringes(0.7 * phase, 2.4 * BEAT, contrast=20.0)
    found = measured(both)
    assert found.frequency_per_mm == pytest.approx(BEAT, abs=2e-3)
    other = measured(both, band=(2.4 * BEAT - 0.01, 2.4 * BEAT + 0.01))
    assert other.frequency_per_mm == pytest.approx(2.4 * BEAT, abs=2e-3)


def test_a_strip_without_fringes_says_that_it_is_vague(rng):
    """Catches: a blank strip that votes; a division by zero; a bar of zero."""
    blank = measured(np.full((FRAMES, SAMPLES), 130.0))
    assert np.all((blank.phase_sd_rad > 0.5) | (blank.contrast < 1e-6))
    assert np.all(np.isfinite(blank.phase_rad)) and not np.any(np.isnan(blank.phase_sd_rad))
    noise = measured(130.0 + 5.0 * rng.standard_normal((FRAMES, SAMPLES)))
    assert np.median(noise.phase_sd_rad) > 0.5


def test_frames_that_something_covers_are_found_and_forged_ones_are_not():
    """Catches: a hand's frames counted as fringes that moved; fringes that stand still, which fit well, excused."""
    misfit, contrast = np.full(200, 4.0), np.full(200, 100.0)
    misfit[50:60] = 35.0
    found = covered_frames(misfit, contrast)
    assert found[50:60].all() and found.sum() <= 14
    assert not covered_frames(np.full(200, 40.0), contrast).any()
    assert not covered_frames(misfit, 100 * contrast).any()
