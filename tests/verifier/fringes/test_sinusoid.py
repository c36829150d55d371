"""The least squares of a sinusoid against closed forms.  Beside each test: what it would catch."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from moireid.verifier.fringes.sinusoid import (
    fit_columns,
    fit_rows,
    fit_series,
    fitted_rows,
    wave_and_slope,
)

SAMPLES = 200
LINE = np.linspace(-1, 1, SAMPLES)
BACKGROUND = np.stack([np.ones(SAMPLES), LINE])
#: Contrast and phase of each harmonic.
WAVE = ((30.0, 0.7), (9.0, -2.0), (4.0, 1.1))


def arguments(rows: int = 3) -> np.ndarray:
    """Some fringes of other frequency in each row, and no whole number of them."""
    return np.linspace(2.3, 4.1, rows)[:, None] * 2 * np.pi * LINE


def wave(argument: np.ndarray) -> np.ndarray:
    return sum(size * np.cos(h * argument + phase) for h, (size, phase) in enumerate(WAVE, 1))


def test_every_coefficient_of_the_formula_comes_back():
    """Catches: the phase's sign, harmonics in a wrong order, a background that takes part of the fringe."""
    argument = arguments()
    level, slope = np.array([120.0, 80.0, 10.0]), np.array([5.0, -3.0, 0.0])
    values = level[:, None] + slope[:, None] * LINE + wave(argument)
    found = fit_rows(values, argument, 3, BACKGROUND)
    expected = [size * np.exp(1j * phase) for size, phase in WAVE]
    assert found.harmonics == pytest.approx(np.tile(expected, (3, 1)), abs=1e-5)
    assert found.background == pytest.approx(np.column_stack([level, slope]), abs=1e-5)
    assert found.left == pytest.approx(np.zeros(3), abs=1e-6)


def test_what_is_left_is_what_numpy_s_own_least_squares_leaves(rng):
    """Catches: a sum over the wrong axis, a ridge that is felt."""
    argument = arguments()
    values = wave(argument) + 20.0 * rng.standard_normal(argument.shape)
    found = fit_rows(values, argument, 2, BACKGROUND)
    for row, (angle, own) in enumerate(zip(argument, values, strict=True)):
        columns = np.stack([*BACKGROUND, np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)], axis=1)
        solved, left = np.linalg.lstsq(columns, own, rcond=None)[:2]
        assert found.left[row] == pytest.approx(left[0], rel=1e-9)
        taken = fit_columns(argument.astype(np.float32), 2, BACKGROUND)
        single = fitted_rows(values.astype(np.float32), taken)[1]
        assert single.dtype == np.float32 and single[row] == pytest.approx(own - columns @ solved, abs=2e-3)
        assert found.harmonics[row, 1] == pytest.approx(solved[4] - 1j * solved[5], abs=1e-6)


def test_the_variance_of_whole_fringes_is_the_closed_form(rng):
    """Catches: a deviation for a variance; unknowns that are not counted.  Over whole fringes it is 2 s^2 / N."""
    noise, rows = 3.0, 400
    argument = np.tile(2 * np.pi * 5 * np.arange(SAMPLES) / SAMPLES, (rows, 1))
    values = 50.0 + wave(argument) + noise * rng.standard_normal(argument.shape)
    found = fit_rows(values, argument, 3, np.ones((1, SAMPLES)))
    expected = 2 * noise**2 / SAMPLES
    assert found.fundamental_variance().mean() == pytest.approx(expected, rel=0.03)
    assert found.harmonics[:, 0].real.var() == pytest.approx(expected, rel=0.25)


def test_a_chapter_s_columns_are_not_in_memory_at_once(rng):
    """Catches: 31 and 43 MB at once for half a minute at 60 frames a second; sums over a part of the rows."""
    argument = rng.uniform(0, 40, (1800, SAMPLES))
    values = 11.0 + wave(argument)
    tracemalloc.start()
    rows, series = fit_rows(values, argument, 3, BACKGROUND), fit_series(values, argument, 3)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * values.nbytes
    expected = [size * np.exp(1j * phase) for size, phase in WAVE]
    assert series[1:] == pytest.approx(np.array(expected), abs=1e-5)
    assert rows.harmonics == pytest.approx(np.tile(expected, (1800, 1)), abs=1e-4)


def test_one_series_for_a_film():
    """Catches: a level in the fundamental; harmonics in a wrong order."""
    argument = np.linspace(0, 90, 5000)
    found = fit_series(11.0 + wave(argument), argument, 4)
    expected = [11.0, *(size * np.exp(1j * phase) for size, phase in WAVE), 0.0]
    assert found == pytest.approx(np.array(expected), abs=1e-5)


def test_a_wave_and_its_slope_are_those_of_the_series():
    """Catches: a slope in other units than per rad, or of the wrong sign; a level in the wave."""
    argument, step = np.linspace(0.1, 6, SAMPLES), 1e-5
    found = fit_series(11.0 + wave(arguments()), arguments(), 3)

    def shown(turned: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return wave_and_slope(found, fit_columns(turned, 3, np.zeros((0, 1))))

    fringe, slope = shown(argument)
    assert fringe == pytest.approx(wave(argument), abs=1e-5)
    apart = shown(argument + step)[0] - shown(argument - step)[0]
    assert slope == pytest.approx(apart / (2 * step), abs=1e-6)
