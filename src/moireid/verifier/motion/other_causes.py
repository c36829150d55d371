"""What else than the place may change a waveform: the printer's dots, and a long exposure.

Dots make a line wider in one place than in another, so a pattern stands still on the badge.  Where it is as fine as
the fringes' third harmonic it is read as a part of that which does not turn: seen from the fringes, it turns back by
three turns while they pass one.  Dirt and uneven lenses do the same.

A long exposure smears a badge that is quick in the picture, and fine fringes most: by the square of its speed, and by
the fourth power where it is very quick.

Convention: series (T,) or (T, N), one entry per frame.
Source: moire of two lattices; the Fourier transform of a box, 1 - x^2 / 24 + x^4 / 1920.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: The harmonic whose waveform is looked at.
HARMONIC = 3


def standing_still(phase_rad: Array) -> Array:
    """What a pattern that stands still adds to the third harmonic, as the fringes see it, (T, 2): up to a factor.

    Parameters: phase_rad (T,): the fringes' phase as measured.
    """
    return np.column_stack([np.cos(HARMONIC * phase_rad), np.sin(HARMONIC * phase_rad)])


def smeared(place_px: Array, stretch: NDArray[np.int64]) -> Array:
    """Second and fourth power of the badge's speed in the picture, (T, 2), from its place (T, 2)."""
    square = speed2(place_px, stretch)
    return np.column_stack([square, square**2])


def speed2(series: Array, stretch: NDArray[np.int64]) -> Array:
    """Square of the change from frame to frame, (T,), of a series (T, N): the mean of before and after."""
    step2 = np.where(np.diff(stretch) == 0, np.sum(np.diff(series, axis=0) ** 2, axis=1), 0.0)
    return np.asarray((np.concatenate([[0.0], step2]) + np.concatenate([step2, [0.0]])) / 2)


def standard(series: Array) -> Array:
    """A series with mean 0 and standard deviation 1, by column; 0 where it does not change."""
    return np.asarray((series - series.mean(axis=0)) / np.maximum(series.std(axis=0), 1e-12))
