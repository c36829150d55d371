"""The shape of a fringe, and the phase of a cell that sees only part of one.

A lens in focus makes fringes closer to a square wave than to a sine.  In a film with little motion, a small cell shows
less than one period, and a sine fitted to it is wrong by tenths of a radian.  So the shape is learnt from the uniform
rows, which show all of it, and each cell is compared with that shape at all phases.

Convention: brightness = level + contrast w(phase); w has mean 0 and a fundamental cos(phase) of amplitude 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import measuring
from moireid.verifier.fringes.sinusoid import Complex, fit_columns, fit_series

Array = NDArray[np.float64]
HARMONICS = 5
#: Phases at which a cell is compared; a parabola interpolates between them.
GRID = 96
STEP = 2 * np.pi / GRID
#: Fewest samples of a cell that is compared; curvature of the cost below which all phases are alike.
LEAST_SAMPLES, LEAST_BEND = 8, 1e-12
TURNS: Array = 2 * np.pi * np.arange(GRID) / GRID
#: exp(i h phase) at these phases, (GRID, 2 H + 1).
AHEAD: Complex = np.exp(1j * np.outer(TURNS, np.arange(2 * HARMONICS + 1)))


def learn_waveform(seen: Array, phase: Array) -> Complex:
    """Fourier coefficients c_0 .. c_H of the fringe's shape, w(x) = Re sum c_h exp(i h x).

    Parameters: seen (..., ): brightness in units of contrast about the level; phase: of each, same shape, rad.
    Convention: c_1 is real and 1; c_0 is 0, as the level belongs to the picture.
    Source: least squares with a small ridge, so that poorly determined harmonics stay small.
    """
    shape = fit_series(seen, phase, HARMONICS, harmonic_ridge_share=0.01)
    shape[0] = 0.0
    # The fundamental defines phase and contrast; turning the other harmonics with it keeps the shape.
    turn, size = np.angle(shape[1]), np.abs(shape[1])
    return np.asarray(shape * np.exp(-1j * turn * np.arange(HARMONICS + 1)) / max(size, 1e-9))


@dataclass(frozen=True)
class Moments:
    """What the misfit of a cell needs of its samples: their sums.

    count (...,): of samples; ones (2 H + 1, ...): sum of exp(i h phase); first (H + 1, ...): sum of seen times that;
    total, square (...,): sums of what is seen and of its square.
    """

    count: Array
    ones: Complex
    first: Complex
    total: Array
    square: Array

    def of_cells(self, members: Array, ahead_rad: Array) -> Moments:
        """The sums over cells from those at the places of a row.

        Parameters: members (C, N): 1 where a cell has a place, else 0; ahead_rad (N,): how much is added to the phase
            of each place.
        """
        turn = np.exp(1j * np.outer(np.arange(len(self.ones)), ahead_rad))
        ones, first = ((part * turn[: len(part)]) @ members.T for part in (self.ones, self.first))
        return Moments(members @ self.count, ones, first, members @ self.total, members @ self.square)


def moments(seen: Array, phase: Array) -> Moments:
    """Sums over the frames at each place of a row; seen: brightness in contrasts, phase: rad, both (F, N).

    Source: single precision, as in `cell_slip`.
    """
    values = seen.astype(np.float32)
    columns = np.moveaxis(fit_columns(phase.astype(np.float32), HARMONICS, np.ones((1, 1))), -2, 0)
    sums = (np.ones(len(values), np.float32) @ columns).astype(float)
    along = np.einsum("tn,htn->hn", values, columns).astype(float)
    ones, first = (np.concatenate([part[:1], part[1::2] + 1j * part[2::2]]) for part in (sums, along))
    # Higher ones are products of the highest with the others.
    by_cosine, by_sine = (np.einsum("tn,htn->hn", part, columns[1:]).astype(float) for part in columns[-2:])
    higher = by_cosine[::2] - by_sine[1::2] + 1j * (by_sine[::2] + by_cosine[1::2])
    ones = np.concatenate([ones, higher])
    return Moments(sums[0], ones, first, along[0], np.einsum("tn,tn->n", seen, seen))


def _lags(shape: Complex) -> Complex:
    lags = np.array([np.sum(shape[m:] * np.conj(shape[: HARMONICS + 1 - m])) for m in range(HARMONICS + 1)])
    lags[1:] *= 2
    return lags


def match_cost(sums: Moments, shape: Complex, inflation: float) -> Array:
    """Misfit of cells to the shape at each of `GRID` phases ahead of the field, in nats, (C, GRID).

    Parameters: sums: of C cells; inflation: factor by which noise exceeds that of independent samples.
    Convention: seen = level + contrast w(phase + ahead), with level and contrast near 0 and 1; a difference of costs is
        the logarithm of a likelihood ratio.
    Returns: all 0 for a cell of too few samples.
    Source: least squares over level and contrast, each within bounds; the sums over samples at all phases follow from
        the moments sum exp(i h phase) and sum seen exp(i h phase).  The misfit is relative to noise and
        `SHAPE_ERROR_CONTRASTS`.
    """
    few = HARMONICS + 1
    ones, first = sums.ones.T, sums.first.T
    total_w, total_vw = (((part[:, :few] * shape) @ AHEAD[:, :few].T).real for part in (ones, first))
    total_ww = (
        (ones * np.convolve(shape, shape)) @ AHEAD.T + (ones[:, :few] * _lags(shape)) @ AHEAD[:, :few].T
    ).real / 2
    count, total_v, total_vv = np.maximum(sums.count, 1.0)[:, None], sums.total[:, None], sums.square[:, None]
    noise2 = np.full_like(count, 0.1)
    for _ in range(3):
        spread = noise2 * inflation**2 + measuring.SHAPE_ERROR_CONTRASTS**2 * count / measuring.SHAPE_ERROR_PIECES
        a11, a22 = (
            count + spread / measuring.CELL_LEVEL_SD_CONTRASTS**2,
            total_ww + spread / measuring.CELL_CONTRAST_SD_RATIO**2,
        )
        b1, b2 = total_v, total_vw + spread / measuring.CELL_CONTRAST_SD_RATIO**2
        determinant = a11 * a22 - total_w**2
        contrast = np.clip((b2 * a11 - b1 * total_w) / determinant, *measuring.CELL_CONTRAST_RANGE_RATIO)
        level = np.clip(
            (b1 - contrast * total_w) / a11, -measuring.CELL_MAX_LEVEL_CONTRASTS, measuring.CELL_MAX_LEVEL_CONTRASTS
        )
        # Least squares within bounds: if the level is clipped, the contrast is estimated again for it.
        contrast = np.clip((b2 - level * total_w) / a22, *measuring.CELL_CONTRAST_RANGE_RATIO)
        misfit = (
            total_vv
            + spread / measuring.CELL_CONTRAST_SD_RATIO**2
            + level * (a11 * level - 2 * b1)
            + contrast * (a22 * contrast + 2 * total_w * level - 2 * b2)
        )
        noise2 = np.maximum(misfit.min(axis=1, keepdims=True) / count, 1e-4)
    return np.where(sums.count[:, None] < LEAST_SAMPLES, 0.0, misfit / (2 * spread))


def match_phase(costs: Array) -> tuple[Array, Array]:
    """The phases of least cost, and their standard deviations, (C,) each; costs (C, GRID).

    Source: a parabola through the least cost and its neighbours.  The error bar comes from its curvature, or from a
        rival phase beyond half a symbol if that is nearly as good.  Of a cell whose phases are all alike: 0, infinity.
    """
    best = costs.argmin(axis=1)
    before, here, after = _about(costs, best)
    bend = before - 2 * here + after
    alike = bend <= LEAST_BEND
    bend = np.where(alike, 1.0, bend)
    steps = np.abs((np.arange(GRID) - best[:, None] + GRID // 2) % GRID - GRID // 2)
    rival = rival_sd(np.where(steps > GRID // 8, costs, np.inf).min(axis=1) - here)
    value = TURNS[best] + STEP * (before - after) / (2 * bend)
    return _or_alike(alike, value, bend, rival)


def match_symbol(costs: Array, offsets: Array, levels: int) -> tuple[Array, Array]:
    """The phases minus `offsets` (C,) of cells that lie on one of `levels` places, and their standard deviations.

    A cell that shows only one plateau leaves its phase open by half a radian or more to both sides, but only one of the
    code's places lies on that plateau.  So each place is tried, with the remaining error of offset and twist
    (`SYMBOL_PLACE_SD_RAD`).  The error bar shows how much worse the next place is.
    """
    off = TURNS - offsets[:, None]
    step = 2 * np.pi / levels
    nearest = np.round(off / step)
    total = costs + 0.5 * ((off - step * nearest) / measuring.SYMBOL_PLACE_SD_RAD) ** 2
    place = nearest.astype(int) % levels
    least = np.sort([np.where(place == k, total, np.inf).min(axis=1) for k in range(levels)], axis=0)
    at = total.argmin(axis=1)
    rival = rival_sd(least[1] - least[0])
    before, here, after = _about(total, at)
    bend = before - 2 * here + after
    alike = bend <= LEAST_BEND
    bend = np.where(alike, 1.0, bend)
    # At the border between two places the neighbour belongs to the other one, so the shift is limited.
    value = TURNS[at] + STEP * np.clip((before - after) / (2 * bend), -0.5, 0.5) - offsets
    return _or_alike(alike, value, bend, rival)


def _about(costs: Array, places: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """The costs before, at and after a place of each cell, on the circle."""
    cells = np.arange(len(costs))
    before, here, after = (costs[cells, (places + on) % GRID] for on in (-1, 0, 1))
    return before, here, after


def _or_alike(alike: NDArray[np.bool_], value: Array, bend: Array, rival: Array) -> tuple[Array, Array]:
    """Phases within half a turn and their standard deviations; 0 and infinity where all phases are alike."""
    sd = np.maximum(STEP / np.sqrt(bend), np.where(rival > measuring.RIVAL_SD_RAD, rival, 0.0))
    turned = value - 2 * np.pi * np.round(value / (2 * np.pi))
    return np.where(alike, 0.0, turned), np.where(alike, np.inf, sd)


def rival_sd(nats: Array) -> Array:
    """Standard deviation at which a phase one symbol away would be less likely by `nats`."""
    return np.asarray((np.pi / 2) / np.sqrt(2 * np.maximum(nats, 1e-6)))
