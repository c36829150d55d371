"""The link budget of a spacing code: from pixels a cell to the chance that the whole payload is read.

Convention: the camera is that of `design`, 8 s of swaying, H.264 at crf 28.
Source of the phase error: a power law through the films of `moireid bench identity` (cells of 7.2 and 9.1 mm at 2 and
3 m: 0.073, 0.049, 0.032 and 0.016 rad at 3.5, 4.4, 5.2 and 6.6 pixels).  Films by people are worse than a simulator's,
so the budget doubles this error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from moireid.idcodes.spacing import CELLS_PER_BYTE, PHASE_LEVELS
from moireid.idcodes.words import WordCode

PHASE_ERROR_RAD, AT_CELL_PX, POWER, FLOOR_RAD = 0.07, 3.5, 2.2, 0.01
ALLOWANCE = 2.0


@dataclass(frozen=True)
class LinkBudget:
    """Prediction at one distance: pixels of a cell's smaller side, phase error, chances of a wrong cell and of all."""

    cell_px: float
    phase_error_rad: float
    cell_error: float
    decode_probability: float


def link_budget(cell_mm: float, px_per_mm: float, word: WordCode) -> LinkBudget:
    """Predict how surely a word is read from cells whose smaller side is `cell_mm`.

    Convention and source: module docstring; errors are Gaussian, cells independent, no erasure is counted upon.
    """
    cell_px = cell_mm * px_per_mm
    error = ALLOWANCE * (PHASE_ERROR_RAD * (AT_CELL_PX / cell_px) ** POWER + FLOOR_RAD)
    wrong_cell = math.erfc(math.pi / PHASE_LEVELS / (error * math.sqrt(2)))
    wrong_byte = 1 - (1 - wrong_cell) ** CELLS_PER_BYTE
    mended, count = word.parity_bytes // 2, word.word_bytes
    read = sum(math.comb(count, k) * wrong_byte**k * (1 - wrong_byte) ** (count - k) for k in range(mended + 1))
    return LinkBudget(cell_px, error, wrong_cell, min(read, 1.0))
