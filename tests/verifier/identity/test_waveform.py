"""The fringe's shape and the matching of cells, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier.identity.cell_slip import row_motion
from moireid.verifier.identity.cell_waveform import (
    HARMONICS,
    learn_waveform,
    match_cost,
    match_phase,
    match_symbol,
    moments,
)


def cost_of(seen, phase, shape, inflation):
    """The misfit of one cell that has all places of a row, (1, GRID)."""
    places = phase.shape[1]
    return match_cost(moments(seen, phase).of_cells(np.ones((1, places)), np.zeros(places)), shape, inflation)


def phase_of(cost):
    """The phase of one cell and its standard deviation."""
    return tuple(float(part[0]) for part in match_phase(cost))


def squarish(phase):
    """A blurred square wave of fundamental 1, with an even harmonic that makes it lopsided."""
    return np.cos(phase) - 0.25 * np.cos(3 * phase) + 0.08 * np.cos(5 * phase) + 0.06 * np.sin(2 * phase)


def test_the_shape_is_learnt_with_the_sign_of_every_harmonic(rng):
    """Catches: conjugated coefficients, which mirror the shape, and a phase that is not the fundamental's."""
    phase = rng.uniform(-20, 20, 4000)
    shape = learn_waveform(0.3 + 1.7 * squarish(phase + 0.4) + 0.05 * rng.standard_normal(4000), phase + 0.4)
    grid = np.linspace(0, 2 * np.pi, 50)
    drawn = (shape[None, :] * np.exp(1j * grid[:, None] * np.arange(HARMONICS + 1))).sum(axis=1).real
    assert np.abs(drawn - squarish(grid)).max() < 0.03
    assert shape[0] == 0 and shape[1] == pytest.approx(1.0)


@pytest.mark.parametrize("ahead", [-3.0, -1.2, 0.0, 0.7, 2.4])
@pytest.mark.parametrize(("span", "level", "contrast"), [(9.0, 0.0, 1.0), (4.2, 0.08, 0.85), (4.2, -0.1, 1.2)])
def test_a_cell_that_sees_part_of_a_fringe_gives_its_phase(rng, ahead, span, level, contrast):
    """Catches: a sign, a sine in place of the shape (0.05 rad off), light taken for phase, a shape upside down."""
    shape = learn_waveform(squarish(np.linspace(0, 40, 3000)), np.linspace(0, 40, 3000))
    phase = rng.uniform(1.0, 1.0 + span, (60, 12))
    seen = level + contrast * squarish(phase + ahead) + 0.04 * rng.standard_normal(phase.shape)
    value, sd = phase_of(cost_of(seen, phase, shape, 1.0))
    assert abs(math.remainder(value - ahead, 2 * math.pi)) < 0.02
    assert 0 < sd < 0.05


def test_error_bars_are_those_of_the_scatter(rng):
    """Catches: a variance for a standard deviation, or noise counted twice."""
    shape = learn_waveform(squarish(np.linspace(0, 40, 3000)), np.linspace(0, 40, 3000))
    errors, bars = [], []
    for _ in range(60):
        phase = rng.uniform(0, 8, (20, 10))
        # Noise that outweighs what is allowed for the shape's own error.
        seen = squarish(phase + 0.5) + 0.9 * rng.standard_normal(phase.shape)
        value, sd = phase_of(cost_of(seen, phase, shape, 1.0))
        errors.append(value - 0.5)
        bars.append(sd)
    assert 0.7 < np.std(errors) / np.mean(bars) < 1.4


def test_a_cell_that_sees_only_white_says_that_it_does_not_know(rng):
    """Catches: a confident guess from a piece of a fringe without an edge in it."""
    shape = learn_waveform(squarish(np.linspace(0, 40, 3000)), np.linspace(0, 40, 3000))
    phase = rng.uniform(-0.05, 0.05, (40, 8))
    _, sd = phase_of(cost_of(squarish(phase) + 0.3 * rng.standard_normal(phase.shape), phase, shape, 3.0))
    assert sd > 0.3
    assert phase_of(cost_of(phase[:1, :4], phase[:1, :4], shape, 1.0)) == (0.0, math.inf)


@pytest.mark.parametrize("middle", [0.0, math.pi])
@pytest.mark.parametrize("misfit", [-0.08, 0.08])
def test_one_plateau_is_never_taken_for_the_other(middle, misfit):
    """Catches: a level that many samples set free, so that white is fitted as black with another level: on outside
    films with 0.25 rad of motion a sixth of the cells came out half a turn wrong, with error bars of 0.05 rad.
    """
    shape = learn_waveform(squarish(np.linspace(0, 40, 3000)), np.linspace(0, 40, 3000))
    phase = np.linspace(-0.35, 0.35, 2000).reshape(-1, 20)
    # A slope and a bend that the shape does not know, as blur from a neighbouring cell makes.
    seen = squarish(phase + middle) + misfit * (3 * phase + np.cos(6 * phase))
    cost = cost_of(seen, phase, shape, 3.0)
    value, sd = phase_of(cost)
    assert abs(math.remainder(value - middle, 2 * math.pi)) < 2.5 * sd
    value = match_symbol(cost, np.zeros(1), 4)[0][0]
    assert abs(math.remainder(value - middle, 2 * math.pi)) < math.pi / 4


@pytest.fixture
def noisy_row(rng):
    """A row of two cells of 12 and 9 places with a gap between them: seen, phase, shape, members."""
    shape = learn_waveform(squarish(np.linspace(0, 40, 3000)), np.linspace(0, 40, 3000))
    phase = rng.uniform(-9, 9, (80, 1)) + np.linspace(0, 7, 25)
    members = np.zeros((2, 25))
    members[0, :12], members[1, 15:24] = 1.0, 1.0
    return squarish(phase + 0.4) + 0.2 * rng.standard_normal(phase.shape), phase, shape, members


def series(shape, phase):
    """The shape at phases of any form."""
    return (shape * np.exp(1j * phase[..., None] * np.arange(len(shape)))).sum(axis=-1).real


def test_slips_of_a_row_are_those_of_its_cells_by_themselves(noisy_row):
    """Catches: level or contrast that cells of a row share, so that one that is covered moves the others; a slip of the
    wrong sign.
    """
    seen, phase, shape, members = noisy_row
    phase = phase + 0.4
    found = row_motion(seen, phase, shape, members)
    for slip, weight, own in zip(found.along, found.power, members > 0, strict=True):
        argument = phase[:, own]
        fringe, slope = series(shape, argument), series(1j * np.arange(HARMONICS + 1) * shape, argument)
        left = np.empty_like(fringe)
        for frame in range(len(phase)):
            table = np.column_stack([np.ones(own.sum()), fringe[frame]])
            inverse = np.linalg.pinv(table)
            left[frame] = seen[frame, own] - table @ (inverse @ seen[frame, own])
            slope[frame] -= table @ (inverse @ slope[frame])
        left -= left.mean(axis=0)
        along, power = (left * slope).sum(axis=1), (slope**2).sum(axis=1)
        assert slip == pytest.approx(along, abs=1e-3)
        assert weight == pytest.approx(power, abs=1e-3)
    shifted = row_motion(squarish(phase + 0.02), phase, shape, members)
    assert shifted.along.sum(axis=1) / shifted.power.sum(axis=1) == pytest.approx([0.02, 0.02], abs=0.01)
