"""Filters and cubic splines over the frames of a film.

Medians, means and greatest values over windows of frames; a smoothing spline at its own places, and an interpolating
spline's slope.  SciPy has all of them too, but it takes longer to load than a film of two seconds takes to verify.

Convention: the first axis is time; a window is centred on its frame, and beyond an end the last frame is repeated; the
places of a spline rise strictly.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: A Gaussian window reaches so many standard deviations to either side.
REACH_SDS = 4.0


def standard(series: Array) -> Array:
    """A series with mean 0 and standard deviation 1; 0 where it does not change."""
    return np.asarray((series - series.mean()) / max(float(series.std()), 1e-12))


def spread_out(count: int, most: int) -> NDArray[np.int64]:
    """Numbers of at most so many of `count` frames, evenly from the first to the last."""
    return np.linspace(0, count - 1, min(most, count)).astype(int)


def median_near(series: Array, frames: int) -> Array:
    """The median of each window of so many frames, an odd number."""
    return np.asarray(np.median(_windows(series, frames), axis=-1))


def greatest_near(series: NDArray[Any], frames: int) -> NDArray[Any]:
    """The greatest value of each window of so many frames, an odd number; of booleans, whether any is true."""
    return np.asarray(_windows(series, frames).max(axis=-1))


def moving_mean(series: Array, frames: int) -> Array:
    """The mean of each window of so many frames, of a series (T, B); an even window reaches one frame further back."""
    size, anchor = (1, frames), (0, frames // 2)
    return np.asarray(cv2.blur(series, size, anchor=anchor, borderType=cv2.BORDER_REPLICATE)).reshape(series.shape)


def gaussian_mean(series: Array, sd_frames: float) -> Array:
    """The mean of a series (T,) or of several (T, B), weighted by a Gaussian of this standard deviation about each
    frame.
    """
    reach = int(REACH_SDS * sd_frames + 0.5)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(sd_frames, 1e-9)) ** 2)
    columns = series.reshape(len(series), -1)
    mean = cv2.sepFilter2D(columns, -1, np.ones(1), weights / weights.sum(), borderType=cv2.BORDER_REPLICATE)
    return np.asarray(mean).reshape(series.shape)


def _windows(series: NDArray[Any], frames: int) -> NDArray[Any]:
    """The frames around each, on a last axis of their own."""
    around = [(frames // 2, frames // 2)] + [(0, 0)] * (series.ndim - 1)
    return np.lib.stride_tricks.sliding_window_view(np.pad(series, around, mode="edge"), frames, axis=0)


def smoothed(places: Array, values: Array, stiffness: float, weights: Array | None = None) -> Array:
    """The values (T,) of a natural cubic smoothing spline at its own places.

    It has the least sum of weight times squared residual, plus stiffness times the integral of the squared second
    derivative.
    Source: Reinsch's algorithm as in Green and Silverman, Nonparametric Regression and Generalized Linear Models
    (1994), 2.3.3: (R + stiffness Q' W^-1 Q) c = Q' y, residuals stiffness W^-1 Q c.
    """
    step = np.diff(places)
    share = np.ones(len(places)) if weights is None else 1 / weights
    # The three diagonals of Q, by row: before, at and after each inner place.
    before, after = 1 / step[:-1], 1 / step[1:]
    at = -before - after
    left, middle, right = share[:-2], share[1:-1], share[2:]
    main = (step[:-1] + step[1:]) / 3 + stiffness * (left * before**2 + middle * at**2 + right * after**2)
    first = step[1:-1] / 6 + stiffness * (middle[:-1] * at[:-1] * before[1:] + right[:-1] * after[:-1] * at[1:])
    second = stiffness * right[:-2] * after[:-2] * before[2:]
    curvature = _solved(main, first, second, np.diff(np.diff(values) / step))
    residual = np.zeros(len(values))
    residual[:-2] += before * curvature
    residual[1:-1] += at * curvature
    residual[2:] += after * curvature
    return np.asarray(values - stiffness * share * residual)


def _solved(main: Array, first: Array, second: Array, right: Array) -> Array:
    """The solution (N,) of a positive definite system of five diagonals, by its Cholesky factors without roots."""
    # Plain numbers: a step of the recursion has too few of them for arrays.
    a, b, c, y = main.tolist(), [0.0, *first.tolist()], [0.0, 0.0, *second.tolist()], right.tolist()
    pivot, near, far = [0.0] * len(a), [0.0] * (len(a) + 2), [0.0] * (len(a) + 2)
    for i in range(len(a)):
        # Of row i of the lower factor: one and two places before the diagonal.
        far[i] = c[i] / pivot[i - 2] if i > 1 else 0.0
        near[i] = (b[i] - far[i] * pivot[i - 2] * near[i - 1]) / pivot[i - 1] if i else 0.0
        pivot[i] = a[i] - (near[i] ** 2 * pivot[i - 1] + far[i] ** 2 * pivot[i - 2] if i else 0.0)
        y[i] -= near[i] * y[i - 1] + far[i] * y[i - 2] if i else 0.0
    x = [0.0] * (len(a) + 2)
    for i in range(len(a) - 1, -1, -1):
        x[i] = y[i] / pivot[i] - near[i + 1] * x[i + 1] - far[i + 2] * x[i + 2]
    return np.array(x[: len(a)])


def slopes(places: Array, values: Array, at: Array) -> Array:
    """Derivative at `at` (S,) of the cubic spline through values (T, ...), T >= 4, whose third derivative does not
    jump at the second and the last but one place; (S, ...).

    Source: de Boor, A Practical Guide to Splines (1978), chapter IV: a system of three diagonals for the slopes at the
    places; between them Hermite's cubic.
    """
    step = np.diff(places).reshape(-1, *[1] * (values.ndim - 1))
    chord = np.diff(values, axis=0) / step
    own = _slopes_at_places(step, chord)
    part = np.clip(np.searchsorted(places, at, side="right") - 1, 0, len(places) - 2)
    share = (at - places[part]).reshape(-1, *[1] * (values.ndim - 1)) / step[part]
    bend = 3 * (own[part] + own[part + 1] - 2 * chord[part])
    return np.asarray(own[part] + share * (2 * (chord[part] - own[part]) - 2 * bend / 3 + share * bend))


def _slopes_at_places(step: Array, chord: Array) -> Array:
    """Slopes (T, ...) of the spline at its places, from its steps (T - 1, 1 ...) and chords (T - 1, ...)."""
    ends = step[0] + step[1], step[-1] + step[-2]
    below = np.concatenate([step[1:], ends[1][None]])
    main = np.concatenate([step[1:2], 2 * (step[:-1] + step[1:]), step[-2:-1]])
    above = np.concatenate([ends[0][None], step[:-1]])
    right = np.empty((len(main), *chord.shape[1:]))
    right[1:-1] = 3 * (step[1:] * chord[:-1] + step[:-1] * chord[1:])
    right[0] = ((step[0] + 2 * ends[0]) * step[1] * chord[0] + step[0] ** 2 * chord[1]) / ends[0]
    right[-1] = ((step[-1] + 2 * ends[1]) * step[-2] * chord[-1] + step[-1] ** 2 * chord[-2]) / ends[1]
    for i in range(1, len(main)):
        factor = below[i - 1] / main[i - 1]
        main[i] -= factor * above[i - 1]
        right[i] -= factor * right[i - 1]
    right[-1] /= main[-1]
    for i in range(len(main) - 2, -1, -1):
        right[i] = (right[i] - above[i] * right[i + 1]) / main[i]
    return right
