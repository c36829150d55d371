"""The shape of a fringe, and the phase of a cell that sees only part of one.

A lens that focuses shows fringes closer to square than to sine, and a small cell on a film with little motion sees
less than one period of it; a sine fitted to such a piece is wrong by tenths of a radian.  So the shape is learnt from
the uniform rows, which see all of it, and every cell is compared with that shape at all phases.

Convention: brightness = level + contrast w(phase); w has mean 0 and a fundamental cos(phase) of amplitude 1.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
HARMONICS = 5
#: Phases at which a cell is compared; a parabola goes between them.
GRID = 96
#: A cell's level and contrast are those of the uniform rows within these shares of the contrast: uneven light.
LEVEL_SD, CONTRAST_SD = 0.15, 0.25
#: No cell lies beyond these.  A cell on a film with little motion shows one plateau of the fringe; with its level free
#: the other plateau, half a turn away, would fit as well, and the many samples of a film would outvote any prior.
MAX_LEVEL, MIN_CONTRAST, MAX_CONTRAST = 0.5, 0.4, 1.8


def learn_waveform(seen: Array, phase: Array) -> Complex:
    """Fourier coefficients c_0 .. c_H of the fringe's shape, w(x) = Re sum c_h exp(i h x).

    Parameters: seen (..., ): brightness in units of contrast about the level; phase: of each, same shape, rad.
    Convention: c_1 is real and 1; c_0 is 0, as the level belongs to the picture.
    Source: least squares with a light ridge, so that harmonics that were hardly seen stay small.
    """
    angle, values = phase.ravel(), seen.ravel()
    columns = [np.ones_like(angle)]
    for harmonic in range(1, HARMONICS + 1):
        columns += [np.cos(harmonic * angle), np.sin(harmonic * angle)]
    basis = np.stack(columns, axis=1)
    normal = basis.T @ basis + 0.01 * len(values) * np.diag([0.0] + [0.0] * 2 + [1.0] * (2 * HARMONICS - 2))
    solved = np.linalg.solve(normal, basis.T @ values)
    shape = np.zeros(HARMONICS + 1, complex)
    shape[1:] = solved[1::2] - 1j * solved[2::2]
    # The fundamental defines phase and contrast; turning the other harmonics with it keeps the shape.
    turn, size = np.angle(shape[1]), np.abs(shape[1])
    return shape * np.exp(-1j * turn * np.arange(HARMONICS + 1)) / max(size, 1e-9)


def match_phase(seen: Array, phase: Array, shape: Complex, inflation: float) -> tuple[float, float]:
    """Phase by which a cell is ahead of the field, and its standard deviation; seen and phase (T, n).

    Convention: seen = level + contrast w(phase + result), with level and contrast near 0 and 1.
    Returns: (0, infinity) where there are too few samples.
    Source: least squares over phase, level and contrast; the sums over samples at all phases follow from the moments
    sum exp(i h phase) and sum seen exp(i h phase).  The error bar is that of the minimum's curvature, or of the next
    best minimum a symbol away where that is nearly as good.
    """
    values, angle = seen.ravel(), phase.ravel()
    count = len(values)
    if count < 8:
        return 0.0, math.inf
    ones, first = _moments(values, angle)
    turns = 2 * np.pi * np.arange(GRID) / GRID
    ahead = np.exp(1j * np.outer(turns, np.arange(2 * HARMONICS + 1)))
    # w^2 = Re( sum_hk c_h c_k e^{i(h+k)x} + c_h conj(c_k) e^{i(h-k)x} ) / 2, as w is a real part.
    sums = np.convolve(shape, shape)
    lags = np.array([np.sum(shape[m:] * np.conj(shape[: HARMONICS + 1 - m])) for m in range(HARMONICS + 1)])
    lags[1:] *= 2
    total_w = (ahead[:, : HARMONICS + 1] @ (shape * ones[: HARMONICS + 1])).real
    total_vw = (ahead[:, : HARMONICS + 1] @ (shape * first)).real
    total_ww = ((ahead @ (sums * ones)).real + (ahead[:, : HARMONICS + 1] @ (lags * ones[: HARMONICS + 1])).real) / 2
    total_v, total_vv = float(values.sum()), float(values @ values)
    noise2 = 0.1
    for _ in range(3):
        a11, a22 = count + noise2 / LEVEL_SD**2, total_ww + noise2 / CONTRAST_SD**2
        b1, b2 = total_v, total_vw + noise2 / CONTRAST_SD**2
        determinant = a11 * a22 - total_w**2
        contrast = np.clip((b2 * a11 - b1 * total_w) / determinant, MIN_CONTRAST, MAX_CONTRAST)
        level = np.clip((b1 - contrast * total_w) / a11, -MAX_LEVEL, MAX_LEVEL)
        # Least squares within bounds: where the level stands at one, the contrast is sought again beside it.
        contrast = np.clip((b2 - level * total_w) / a22, MIN_CONTRAST, MAX_CONTRAST)
        misfit = (
            total_vv + noise2 / CONTRAST_SD**2 + level * (a11 * level - 2 * b1)
            + contrast * (a22 * contrast + 2 * total_w * level - 2 * b2)
        )  # fmt: skip
        best = int(np.argmin(misfit))
        noise2 = max(float(misfit[best]) / count, 1e-4)
    before, here, after = misfit[best - 1], misfit[best], misfit[(best + 1) % GRID]
    bend = float(before - 2 * here + after)
    step = 2 * np.pi / GRID
    if bend <= 0:
        return 0.0, math.inf
    value = turns[best] + step * float(before - after) / (2 * bend)
    sd = inflation * math.sqrt(2 * noise2 / bend) * step
    away = np.abs(np.angle(np.exp(1j * (turns - turns[best])))) > np.pi / 4
    likelihood = float(misfit[away].min() - here) / (2 * noise2 * inflation**2)
    rival_sd = (np.pi / 2) / math.sqrt(2 * max(likelihood, 1e-6))
    return math.remainder(float(value), 2 * np.pi), max(sd, rival_sd if rival_sd > 0.3 else 0.0)


def _moments(values: Array, angle: Array) -> tuple[Complex, Complex]:
    """Sums over samples of exp(i h angle) for h to 2 H, and of values exp(i h angle) for h to H."""
    turn = np.exp(1j * angle)
    power = np.ones_like(turn)
    ones, first = np.empty(2 * HARMONICS + 1, complex), np.empty(HARMONICS + 1, complex)
    for harmonic in range(2 * HARMONICS + 1):
        ones[harmonic] = power.sum()
        if harmonic <= HARMONICS:
            first[harmonic] = values @ power
        power = power * turn
    return ones, first
