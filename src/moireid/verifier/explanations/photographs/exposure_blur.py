"""What a long exposure does to a waveform: it smears a badge that is quick in the picture, and fine fringes most.

Convention: speeds are per second, so that missing frames change nothing.  Series (T,) or (T, N), one entry per frame.
Source: the Fourier transform of a box of width x is 1 - x^2 / 24 + x^4 / 1920 and so on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def speed2(series: Array, stretch: NDArray[np.int64], times_s: Array) -> Array:
    """Square of a series' speed, (T,), per s^2: the mean of that from the frame before and that to the one after.

    Within a stretch (`camera.stretches`); 0 for a frame that stands alone.
    """
    joined = (np.diff(stretch) == 0) & (np.diff(times_s) > 0)
    step2 = np.where(joined, np.sum(np.diff(series, axis=0) ** 2, axis=1), 0.0)
    step2 = step2 / np.where(joined, np.diff(times_s), 1.0) ** 2
    sides = np.r_[0, joined] + np.r_[joined, 0]
    return np.asarray((np.r_[0.0, step2] + np.r_[step2, 0.0]) / np.maximum(sides, 1))


def smeared_parts(place_px: Array, stretch: NDArray[np.int64], times_s: Array) -> Array:
    """What is lost by a long exposure goes with these, (T, 2): second and fourth power of the speed, at most 1."""
    square = speed2(place_px, stretch, times_s)
    square = square / max(float(square.max(initial=0.0)), 1e-12)
    return np.column_stack([square, square**2])
