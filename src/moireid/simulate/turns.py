"""Rotations and splines of trajectories, in NumPy alone, as SciPy takes longer to import than a short film to render.

Convention: matrices turn column vectors; quaternions are x, y, z, w.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def from_vectors(vectors: Array) -> Array:
    """Matrices (T, 3, 3) of rotation vectors (T, 3), rad.

    Source: Rodrigues, 1 + sin a [u]x + (1 - cos a) [u]x^2 about the unit vector u.
    """
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = (vectors / np.maximum(angle[:, 0], 1e-300)).T
    none = np.zeros_like(x)
    crossed = np.array([[none, -z, y], [z, none, -x], [-y, x, none]]).transpose(2, 0, 1)
    return np.asarray(np.eye(3) + np.sin(angle) * crossed + (1 - np.cos(angle)) * crossed @ crossed)


def from_yxz(angles: Array) -> Array:
    """Matrices (T, 3, 3) of turns (T, 3), rad, about the fixed axes y, then x, then z."""
    about_y, about_x, about_z = (from_vectors(angles[:, k, None] * np.eye(3)[axis]) for k, axis in enumerate((1, 0, 2)))
    return np.asarray(about_z @ about_x @ about_y)


def from_quaternions(quaternions: Array) -> Array:
    """Matrices (T, 3, 3) of quaternions (T, 4) of any length but 0."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def continuous(quaternions: Array) -> Array:
    """Quaternions (T, 4) of which neighbours have one sign, as one and its negative are one rotation."""
    flips = np.where(np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0, -1.0, 1.0)
    return np.asarray(quaternions * np.concatenate([[1.0], np.cumprod(flips)])[:, None])


def spline(times: Array, values: Array) -> Callable[[Array], Array]:
    """The cubic spline through values (N, K) at rising times (N,), four or more, without knots next to its ends.

    Source: the tridiagonal equations of its slopes, solved by elimination; pieces by Hermite's polynomials.
    """
    step = np.diff(times)[:, None]
    slope = np.diff(values, axis=0) / step
    ends = step[:-1] + step[1:]
    low, high = np.append(step[1:], ends[-1:], axis=0), np.append(ends[:1], step[:-1], axis=0)
    main = np.concatenate([step[1:2], 2 * ends, step[-2:-1]])
    first = ((step[0] + 2 * ends[0]) * step[1] * slope[0] + step[0] ** 2 * slope[1]) / ends[0]
    last = ((step[-1] + 2 * ends[-1]) * step[-2] * slope[-1] + step[-1] ** 2 * slope[-2]) / ends[-1]
    at = np.concatenate([first[None], 3 * (step[1:] * slope[:-1] + step[:-1] * slope[1:]), last[None]])
    for k in range(1, len(times)):
        share = low[k - 1] / main[k - 1]
        main[k] -= share * high[k - 1]
        at[k] -= share * at[k - 1]
    at[-1] /= main[-1]
    for k in range(len(times) - 2, -1, -1):
        at[k] = (at[k] - high[k] * at[k + 1]) / main[k]

    def value(clock: Array) -> Array:
        piece = np.clip(np.searchsorted(times, clock, "right") - 1, 0, len(times) - 2)
        t = (clock - times[piece])[:, None] / step[piece]
        bow = step[piece] * (t * (1 - t) ** 2 * at[piece] - t**2 * (1 - t) * at[piece + 1])
        return np.asarray((1 + 2 * t) * (1 - t) ** 2 * values[piece] + t**2 * (3 - 2 * t) * values[piece + 1] + bow)

    return value
