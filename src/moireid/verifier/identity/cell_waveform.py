"""The shape of a fringe, and the phase of a cell that sees only part of one.

A lens in focus makes fringes closer to a square wave than to a sine.  In a film with little motion, a small cell shows
less than one period, and a sine fitted to it is wrong by tenths of a radian.  So the shape is learnt from the uniform
rows, which show all of it, and each cell is compared with that shape at all phases.

Convention: brightness = level + contrast w(phase); w has mean 0 and a fundamental cos(phase) of amplitude 1.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import measuring
from moireid.verifier.fringes.sinusoid import Complex, fit_series

Array = NDArray[np.float64]
HARMONICS = 5
#: Phases at which a cell is compared; a parabola interpolates between them.
GRID = 96
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


def match_cost(seen: Array, phase: Array, shape: Complex, inflation: float) -> Array:
    """Misfit of a cell to the shape at each of `GRID` phases ahead of the field, in nats.

    Parameters: seen, phase (T, n); inflation: factor by which noise exceeds that of independent samples.
    Convention: seen = level + contrast w(phase + ahead), with level and contrast near 0 and 1; a difference of costs is
        the logarithm of a likelihood ratio.
    Returns: (GRID,), all 0 if there are too few samples.
    Source: least squares over level and contrast, each within bounds; the sums over samples at all phases follow from
        the moments sum exp(i h phase) and sum seen exp(i h phase).  The misfit is relative to noise and
        `SHAPE_ERROR_CONTRASTS`.
    """
    values, angle = seen.ravel(), phase.ravel()
    count = len(values)
    if count < 8:
        return np.zeros(GRID)
    ones, first = _moments(values, angle)
    # w^2 = Re( sum_hk c_h c_k e^{i(h+k)x} + c_h conj(c_k) e^{i(h-k)x} ) / 2, as w is a real part.
    sums = np.convolve(shape, shape)
    lags = np.array([np.sum(shape[m:] * np.conj(shape[: HARMONICS + 1 - m])) for m in range(HARMONICS + 1)])
    lags[1:] *= 2
    few = HARMONICS + 1
    total_w, total_vw = (AHEAD[:, :few] @ (shape * ones[:few])).real, (AHEAD[:, :few] @ (shape * first)).real
    total_ww = ((AHEAD @ (sums * ones)).real + (AHEAD[:, :few] @ (lags * ones[:few])).real) / 2
    total_v, total_vv = float(values.sum()), float(values @ values)
    noise2 = 0.1
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
        noise2 = max(float(misfit.min()) / count, 1e-4)
    return np.asarray(misfit / (2 * spread))


def match_phase(cost: Array) -> tuple[float, float]:
    """The phase of least cost, and its standard deviation.

    Source: a parabola through the least cost and its neighbours.  The error bar comes from its curvature, or from a
        rival phase beyond half a symbol if that is nearly as good.  Returns: (0, infinity) if all phases are alike.
    """
    best = int(np.argmin(cost))
    before, here, after = cost[best - 1], cost[best], cost[(best + 1) % GRID]
    bend = float(before - 2 * here + after)
    step = 2 * np.pi / GRID
    if bend <= 1e-12:
        return 0.0, math.inf
    value = TURNS[best] + step * float(before - after) / (2 * bend)
    away = np.abs(np.angle(np.exp(1j * (TURNS - TURNS[best])))) > np.pi / 4
    rival = rival_sd(float(cost[away].min() - here))
    return math.remainder(float(value), 2 * np.pi), max(
        step / math.sqrt(bend), rival if rival > measuring.RIVAL_SD_RAD else 0.0
    )


def match_symbol(cost: Array, offset: float, levels: int) -> tuple[float, float]:
    """The phase minus `offset` of a cell that lies on one of `levels` places, and its standard deviation.

    A cell that shows only one plateau leaves its phase open by half a radian or more to both sides, but only one of the
    code's places lies on that plateau.  So each place is tried, with the remaining error of offset and twist
    (`SYMBOL_PLACE_SD_RAD`).  The error bar shows how much worse the next place is.
    """
    off = TURNS - offset
    step = 2 * np.pi / levels
    wander = np.abs(off - step * np.round(off / step))
    total = cost + 0.5 * (wander / measuring.SYMBOL_PLACE_SD_RAD) ** 2
    place = np.round(off / step).astype(int) % levels
    least = np.array([total[place == k].min() for k in range(levels)])
    chosen = int(np.argmin(least))
    at = int(np.flatnonzero(place == chosen)[np.argmin(total[place == chosen])])
    rival = rival_sd(float(np.sort(least)[1] - least[chosen]))
    before, here, after = total[at - 1], total[at], total[(at + 1) % GRID]
    bend = float(before - 2 * here + after)
    if bend <= 1e-12:
        return 0.0, math.inf
    # At the border between two places the neighbour belongs to the other one, so the shift is limited.
    shift = float(np.clip((before - after) / (2 * bend), -0.5, 0.5)) if bend > 0 else 0.0
    value = TURNS[at] + (2 * np.pi / GRID) * shift - offset
    curve_sd = 2 * np.pi / GRID / math.sqrt(bend)
    return math.remainder(float(value), 2 * np.pi), max(curve_sd, rival if rival > measuring.RIVAL_SD_RAD else 0.0)


def rival_sd(nats: float) -> float:
    """Standard deviation at which a phase one symbol away would be less likely by `nats`."""
    return (np.pi / 2) / math.sqrt(2 * max(nats, 1e-6))


def _moments(values: Array, angle: Array) -> tuple[Complex, Complex]:
    """Sums over samples of exp(i h angle) for h to 2 H, and of values exp(i h angle) for h to H."""
    turn = np.empty(len(angle), complex)
    np.cos(angle, out=turn.real)
    np.sin(angle, out=turn.imag)
    power = np.empty((HARMONICS + 1, len(angle)), complex)
    power[0] = 1.0
    for harmonic in range(HARMONICS):
        np.multiply(power[harmonic], turn, out=power[harmonic + 1])
    ones: Complex = np.empty(2 * HARMONICS + 1, complex)
    ones[: HARMONICS + 1] = power.sum(axis=1)
    # Higher ones are products of the highest with the others.
    ones[HARMONICS + 1 :] = power[1:] @ power[HARMONICS]
    return ones, np.asarray(power @ values)
