"""Do the rows of the code move with the plain rows, frame by frame?

The plain rows are a quarter of a badge.  Each cell of the others is compared with the fringe that the plain rows and
its own symbol put there; a small shift of the phase adds the shape's slope times the shift, so what is left of a frame,
projected on that slope, is the cell's *slip*.  The cells of a row, and neighbouring frames, are averaged.

Convention: phases in rad, positive where the cell's fringes are ahead; frames (F,) are those that cells are read in.
Source: least squares, first order in the slip; level and contrast of each cell and frame are free (Frisch and Waugh
    1933).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.sinusoid import Complex, series
from moireid.verifier.measuring import SLIP_MEAN_S, SLIP_WORST_S

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CellSlip:
    """Of one cell: the slip is along / power, (F,)."""

    along: Array
    power: Array


def cell_slip(seen: Array, phase: Array, shape: Complex, ahead: float) -> CellSlip:
    """The slip of one cell.

    Parameters: seen (F, n): brightness in contrasts about the level; phase (F, n): of the plain rows' field; shape: as
        `waveform.learn_waveform`; ahead: the cell's phase over the whole film, rad.
    """
    argument = phase + ahead
    fringe = series(shape, argument)
    slope = series(1j * np.arange(len(shape)) * shape, argument)
    level = np.ones_like(fringe)
    fringe = _without(fringe, level)
    slope = _without(_without(slope, level), fringe)
    left = _without(_without(seen, level), fringe)
    # What is the same in all frames is dirt, or an uneven sheet.
    left = left - left.mean(axis=0)
    return CellSlip(np.sum(left * slope, axis=1), np.sum(slope * slope, axis=1))


def row_apart_rad(cells: Sequence[CellSlip], times_s: Array) -> tuple[float, float]:
    """How far a row moves apart from the plain rows, root mean squares over the film and over its worst second, rad.

    Parameters: times_s (F,).

    Notes
    -----
    Convention: noise is not taken off, or a row that is made noisy could hide anything.
    """
    along, power = (np.sum([getattr(cell, name) for cell in cells], axis=0) for name in ("along", "power"))
    if not power.sum() > 0:
        return 0.0, 0.0
    step = float(np.median(np.diff(times_s))) if len(times_s) > 1 else SLIP_MEAN_S
    along, power = (_moving_sums(values, SLIP_MEAN_S / max(step, 1e-3)) for values in (along, power))
    slip = along / np.maximum(power, 1e-9)
    slip = slip - np.average(slip, weights=power)
    square, weight = (_moving_sums(values, SLIP_WORST_S / max(step, 1e-3)) for values in (slip**2 * power, power))
    return float(np.sqrt(np.average(slip**2, weights=power))), float(np.sqrt((square / np.maximum(weight, 1e-9)).max()))


def _moving_sums(values: Array, frames: float) -> Array:
    """Sums over windows of so many frames about each, shorter at the ends."""
    return np.convolve(values, np.ones(min(max(round(frames), 1), len(values))), "same")


def _without(values: Array, column: Array) -> Array:
    """Values (F, n) without their part along a column (F, n), frame by frame."""
    size = np.maximum(np.sum(column * column, axis=1, keepdims=True), 1e-12)
    return np.asarray(values - column * (np.sum(values * column, axis=1, keepdims=True) / size))
