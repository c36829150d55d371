"""Do the cells of the code move with the plain rows: frame by frame, and how far over the whole film?

The uniform ("plain") rows are a quarter of a badge, so the rows of the code must be seen to move with them.  Each cell
is compared with the fringe that the plain rows and its own symbol put there.

Frame by frame: a small shift of the phase adds the shape's slope times the shift, so the residual of a frame, projected
on that slope, is the cell's *slip*.  The slips of the cells of a row, and of neighbouring frames, are averaged.

Over the film: the change of each cell over that expected is 1 on a badge, 0 in a still picture.  The typical cell is
their median, as a hand or a caption may cover some.  Fringes that were dragged from one picture to another by optical
flow drag those of their neighbours, so the typical cell moves less than the law.

Convention: phases in rad, positive where the cell's fringes are ahead; frames (F,) are those that cells are read in.
    The error bar of the typical cell is the scatter between cells, or between rows of cells, whichever is greater:
    noise and dirt differ from cell to cell, blur and coding from row to row.
Source: least squares, first order in the slip; level and contrast of each cell and frame are free (Frisch and Waugh
    1933).  Single precision resolves a slip to some hundred-thousandths of a radian; noise leaves a hundred times
    that.  Standard error of a median of normal values, sqrt(pi / 2) times that of their mean, from the median absolute
    deviation (Rousseeuw and Croux 1993); the jackknife that leaves out a row at a time (Shao and Wu 1989).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.sinusoid import Complex, Single, fit_columns, wave_and_slope
from moireid.verifier.measuring import MIN_CELL_CHANGE_CONTRASTS2, SLIP_MEAN_S, SLIP_WORST_S

Array = NDArray[np.float64]
#: Standard deviation of normal values over their median absolute deviation.
SD_OVER_MAD = 1.4826


class RowMotion(NamedTuple):
    """The C cells of a row: along over power is the slip, (C, F) each; moved over expected the change, (C,) each.

    moved: mean over frames and samples of the measured change times that expected of the symbol; expected: mean of the
    expected change squared, contrasts squared.
    """

    along: Array
    power: Array
    moved: Array
    expected: Array


def row_motion(seen: Array, phase: Array, shape: Complex, members: Array) -> RowMotion:
    """The motion of the cells of a row, at once, as NumPy is slow on the few samples of one cell.

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

    columns = fit_columns(phase.astype(np.float32), len(shape) - 1, np.zeros((0, 1)))
    parts = (*wave_and_slope(shape, columns), seen.astype(np.float32))
    change = parts[0] - parts[0].mean(axis=0)
    moved, expected = ((part * change).mean(axis=0) @ cells.T / counts for part in (parts[2], change))
    fringe, slope, left = (part - (sums(part) / counts) @ cells for part in parts)
    slope, left = without(slope, fringe), without(left, fringe)
    # What is the same in all frames is dirt, or an uneven sheet.
    left -= left.mean(axis=0)
    along, power = (sums(part * slope).T.astype(float) for part in (left, slope))
    return RowMotion(along, power, moved.astype(float), expected.astype(float))


class CellMotion(NamedTuple):
    """Motion of the code's cells over that expected; pure numbers.

    whole: of all cells together; typical: of the median cell; sd: standard deviation of that.
    """

    whole: float
    typical: float
    sd: float


def cell_motion_of(rows: Sequence[RowMotion]) -> CellMotion | None:
    """The motion of the cells of all rows; None where the plain rows hardly move."""
    weight = np.concatenate([row.expected for row in rows]) if rows else np.zeros(0)
    if not weight.sum() > MIN_CELL_CHANGE_CONTRASTS2 * max(len(weight), 1):
        return None
    moved = np.concatenate([row.moved for row in rows])
    ratio = moved / np.maximum(weight, 1e-12)
    typical = _median(ratio, weight)
    spread = SD_OVER_MAD * _median(np.abs(ratio - typical), weight)
    over_cells = math.sqrt(math.pi / 2 * float(np.sum(weight**2))) / float(weight.sum()) * spread
    number = np.repeat(np.arange(len(rows)), [len(row.expected) for row in rows])
    without = np.array([_median(ratio[number != k], weight[number != k]) for k in range(len(rows)) if len(rows) > 1])
    over_rows = math.sqrt((len(rows) - 1) * float(without.var())) if len(without) else 0.0
    return CellMotion(float(moved.sum() / weight.sum()), typical, max(over_cells, over_rows))


def _median(values: Array, weight: Array) -> float:
    """The value that half of the weight is below."""
    order = np.argsort(values)
    below = np.cumsum(weight[order]) - weight[order] / 2
    return float(np.interp(weight.sum() / 2, below, values[order]))


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


def rows_apart(rows: Iterable[RowMotion], times_s: Array) -> RowsApart:
    """The greatest of each figure over the rows; times_s (F,)."""
    found = [TOGETHER]
    for row in rows:
        # A row, and its two halves of each second cell with the factor by which their noise is compared with the
        # row's: neighbours that deviate in opposite ways would cancel in a row's mean, and a half has sqrt(2) times
        # its noise.
        parts = ((slice(None), 1.0), (slice(0, None, 2), math.sqrt(0.5)), (slice(1, None, 2), math.sqrt(0.5)))
        known = [(slip, scale) for part, scale in parts if (slip := _slip(row, part, times_s)) is not None]
        spreads = ([scale * figure for figure in _spread(slip, times_s)] for slip, scale in known)
        film, second = map(max, zip((0.0, 0.0), *spreads, strict=True))
        halves = [slip for slip, scale in known if scale < 1.0]
        # A row of one cell has no halves to compare.
        coherent = _shared(halves[0], halves[1], times_s) if len(halves) == 2 else film
        # Slips count in contrasts of the plain rows, which cells with more contrast exceed by as much.
        coherent /= max(1.0, float(row.moved.sum()) / max(float(row.expected.sum()), 1e-12))
        found.append(RowsApart(film, second, coherent))
    return greatest(found)


def greatest(several: Iterable[RowsApart]) -> RowsApart:
    """The greatest of each figure."""
    return RowsApart(*map(max, zip(*map(astuple, (TOGETHER, *several)), strict=True)))


def _slip(row: RowMotion, part: slice, times_s: Array) -> tuple[Array, Array] | None:
    """Slip of some cells together, rad (F,), mean 0, and its weight (F,); None where their fringes are flat."""
    along, power = (values[part].sum(axis=0) for values in (row.along, row.power))
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
