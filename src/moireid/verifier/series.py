"""Medians, means and greatest values over windows of a series of frames.

SciPy has these filters too, but it takes longer to load than a film of two seconds takes to verify.

Convention: the first axis is time; a window is centred on its frame, and beyond an end the last frame is repeated.
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
    """The mean of a series (T,), weighted by a Gaussian of this standard deviation about each frame."""
    reach = int(REACH_SDS * sd_frames + 0.5)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(sd_frames, 1e-9)) ** 2)
    return np.convolve(np.pad(series, reach, mode="edge"), weights / weights.sum(), "valid")


def _windows(series: NDArray[Any], frames: int) -> NDArray[Any]:
    """The frames around each, on a last axis of their own."""
    around = [(frames // 2, frames // 2)] + [(0, 0)] * (series.ndim - 1)
    return np.lib.stride_tricks.sliding_window_view(np.pad(series, around, mode="edge"), frames, axis=0)
