"""How far the cells of the code move, over how far the plain rows and the symbols that were read make them.

Each cell has a ratio of its own: 1 on a badge, 0 in a still picture.  The typical cell is their median, as a hand or a
caption may cover some.  Fringes that were dragged from one picture to another by optical flow drag those of their
neighbours, so the typical cell moves less than the law.

Convention: the error bar is the scatter between cells, or between rows of cells, whichever is greater: noise and dirt
    differ from cell to cell, blur and coding from row to row.
Source: standard error of a median of normal values, sqrt(pi / 2) times that of their mean, from the median absolute
    deviation (Rousseeuw and Croux 1993); the jackknife that leaves out a row at a time (Shao and Wu 1989).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import measuring
from moireid.verifier.identity.cell_phase import CellPhase

Array = NDArray[np.float64]
#: Standard deviation of normal values over their median absolute deviation.
SD_OVER_MAD = 1.4826


@dataclass(frozen=True)
class CellMotion:
    """Motion of the code's cells over that expected; pure numbers.

    whole: of all cells together; typical: of the median cell; sd: standard deviation of that.
    """

    whole: float
    typical: float
    sd: float


def cell_motion_of(gratings: Iterable[Iterable[CellPhase]]) -> CellMotion | None:
    """The motion of the cells of each grating that carries a code; None where the rows hardly move."""
    rows, moved, power = [], [], []
    for number, cells in enumerate(gratings):
        for cell in cells:
            rows.append((number, cell.across_mm))
            moved.append(cell.moved)
            power.append(cell.power)
    if not sum(power) > measuring.MIN_CELL_CHANGE_CONTRASTS2 * max(len(power), 1):
        return None
    weight = np.array(power)
    ratio = np.array(moved) / np.maximum(weight, 1e-12)
    typical = _median(ratio, weight)
    spread = SD_OVER_MAD * _median(np.abs(ratio - typical), weight)
    over_cells = math.sqrt(math.pi / 2 * float(np.sum(weight**2))) / float(weight.sum()) * spread
    _, row = np.unique(np.array(rows), axis=0, return_inverse=True)
    count = int(row.max()) + 1
    without = np.array([_median(ratio[row != k], weight[row != k]) for k in range(count)]) if count > 1 else np.zeros(1)
    over_rows = math.sqrt((count - 1) * float(without.var()))
    return CellMotion(sum(moved) / sum(power), typical, max(over_cells, over_rows))


def _median(values: Array, weight: Array) -> float:
    """The value that half of the weight is below."""
    order = np.argsort(values)
    below = np.cumsum(weight[order]) - weight[order] / 2
    return float(np.interp(weight.sum() / 2, below, values[order]))
