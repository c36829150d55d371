"""Whether the cells of the code move with the plain rows, frame by frame.

The uniform ("plain") rows are a quarter of a badge, so the rows of the code must be seen to move with them, frame by
frame.  Each cell is compared with the fringe that the plain rows and its own symbol put there.  A small shift of the
phase adds the shape's slope times the shift, so the residual of a frame, projected on that slope, is the cell's *slip*.
The slips of the cells of a row, and of neighbouring frames, are averaged.

Convention: phases in rad, positive where the cell's fringes are ahead; frames (F,) are those that cells are read in.
Source: least squares, first order in the slip; level and contrast of each cell and frame are free (Frisch and Waugh
    1933).  Single precision resolves a slip to some hundred-thousandths of a radian; noise leaves a hundred times
    that.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.sinusoid import Complex, Single, fit_columns
from moireid.verifier.measuring import SLIP_MEAN_S, SLIP_WORST_S

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CellSlip:
    """Of one cell: the slip is along / power, (F,)."""

    along: Array
    power: Array


def row_slips(seen: Array, phase: Array, shape: Complex, members: Array) -> list[CellSlip]:
    """The slip of each cell of a row, at once, as NumPy is slow on the few samples of one cell.

    Parameters: seen (F, N): brightness in contrasts about the level; phase (F, N): of the plain rows' field, with the
        phase of each cell over the whole film; shape: as `cell_waveform.learn_waveform`; members (C, N): 1 where a cell
        has a place of the row, else 0; no two cells share one.
    """
    cells = members.astype(np.float32)
    counts = np.maximum(cells.sum(axis=1), 1.0)

    def sums(values: Single) -> Single:
        return np.asarray(values @ cells.T)

    def without(values: Single, column: Single) -> Single:
        """Values without their part along a column, cell by cell and frame by frame."""
        share = sums(values * column) / np.maximum(sums(column * column), np.float32(1e-12))
        return np.asarray(values - column * (share @ cells))

    columns = np.moveaxis(fit_columns(phase.astype(np.float32), len(shape) - 1, np.zeros((0, 1))), -2, 0)
    parts = np.stack([shape, 1j * np.arange(len(shape)) * shape])[:, 1:]
    turns = np.stack([parts.real, -parts.imag], axis=-1).reshape(2, -1).astype(np.float32)
    shapes = (turns @ columns.reshape(len(columns), -1)).reshape(2, *phase.shape)
    fringe, slope, left = (part - (sums(part) / counts) @ cells for part in (*shapes, seen.astype(np.float32)))
    slope, left = without(slope, fringe), without(left, fringe)
    # What is the same in all frames is dirt, or an uneven sheet.
    left -= left.mean(axis=0)
    along, power = (sums(part * slope).astype(float) for part in (left, slope))
    return [CellSlip(*each) for each in zip(along.T, power.T, strict=True)]


@dataclass(frozen=True)
class RowsApart:
    """How far the code's rows that differ most move apart from the plain rows, rad; 0 where no cell is read.

    film: root mean square over the film; second: over the worst second; coherent: the part over the film that two
    halves of one row share, each second cell in either.

    Notes
    -----
    Convention: noise is not taken off `film` and `second`, or a row that is made noisy could hide anything.  In
        `coherent` it averages to nothing, as the halves have no noise in common: it is the root of the mean product of
        their slips, less three of its standard deviations.
    """

    film: float = 0.0
    second: float = 0.0
    coherent: float = 0.0


#: No row moves apart, or none is read.
TOGETHER = RowsApart()


def rows_apart(rows: Iterable[Sequence[CellSlip]], times_s: Array) -> RowsApart:
    """The greatest of each figure over the rows.

    Parameters: rows: the cells of each row, in order; times_s (F,).
    """
    found = []
    for cells in rows:
        parts = [(_slip(part, times_s), scale) for part, scale in _parts(cells)]
        known = [(_spread(slip, times_s), scale) for slip, scale in parts if slip is not None]
        film, second = (max((one[k] * scale for one, scale in known), default=0.0) for k in (0, 1))
        halves = [slip for slip, scale in parts if scale < 1.0 and slip is not None]
        # A row of one cell has no halves to compare.
        coherent = _shared(halves[0], halves[1], times_s) if len(halves) == 2 else film
        found.append(RowsApart(film, second, coherent))
    return greatest(found)


def greatest(several: Iterable[RowsApart]) -> RowsApart:
    """The greatest of each figure."""
    known = [TOGETHER, *several]
    return RowsApart(*(max(getattr(one, name) for one in known) for name in ("film", "second", "coherent")))


def _parts(cells: Sequence[CellSlip]) -> list[tuple[Sequence[CellSlip], float]]:
    """A row, and its two halves of each second cell with the factor by which their noise is compared with the row's:
    neighbours that deviate in opposite ways would cancel in a row's mean, and a half has sqrt(2) times its noise.
    """
    half = math.sqrt(0.5)
    return [(part, scale) for part, scale in ((cells, 1.0), (cells[::2], half), (cells[1::2], half)) if part]


def _slip(cells: Sequence[CellSlip], times_s: Array) -> tuple[Array, Array] | None:
    """Slip of several cells together, rad (F,), mean 0, and its weight (F,); None where their fringes are flat."""
    along, power = (np.sum([getattr(cell, name) for cell in cells], axis=0) for name in ("along", "power"))
    if not power.sum() > 0:
        return None
    along, power = (_moving_sums(values, SLIP_MEAN_S / max(_step_s(times_s), 1e-3)) for values in (along, power))
    slip = along / np.maximum(power, 1e-9)
    return slip - np.average(slip, weights=power), power


def _spread(slip: tuple[Array, Array], times_s: Array) -> tuple[float, float]:
    """Root mean squares of a slip over the film and over its worst second, rad."""
    values, power = slip
    frames = SLIP_WORST_S / max(_step_s(times_s), 1e-3)
    square, weight = (_moving_sums(each, frames) for each in (values**2 * power, power))
    return float(np.sqrt(np.average(values**2, weights=power))), float(
        np.sqrt((square / np.maximum(weight, 1e-9)).max())
    )


def _shared(first: tuple[Array, Array], second: tuple[Array, Array], times_s: Array) -> float:
    """Root of the mean product of two slips, rad, less three standard deviations of that mean; 0 below.

    Convention: slips are means over `SLIP_MEAN_S`, so a film holds as many independent ones as fit into it.
    """
    weight = np.sqrt(first[1] * second[1])
    if not weight.sum() > 0:
        return 0.0
    product = float(np.average(first[0] * second[0], weights=weight))
    size = math.prod(math.sqrt(float(np.average(slip**2, weights=weight))) for slip in (first[0], second[0]))
    independent = max(len(times_s) * _step_s(times_s) / SLIP_MEAN_S, 1.0)
    return math.sqrt(max(product - 3.0 * size / math.sqrt(independent), 0.0))


def _step_s(times_s: Array) -> float:
    return float(np.median(np.diff(times_s))) if len(times_s) > 1 else SLIP_MEAN_S


def _moving_sums(values: Array, frames: float) -> Array:
    """Sums over windows of so many frames about each, shorter at the ends."""
    return np.convolve(values, np.ones(min(max(round(frames), 1), len(values))), "same")
