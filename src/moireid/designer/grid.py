"""How a field is cut into rows and cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from moireid.badge import Cell, Rect
from moireid.frames import Axis, own_rect
from moireid.idcodes.spacing import CELLS_PER_BYTE
from moireid.idcodes.words import CHECK_BYTES, MAX_WORD_BYTES

DUTY = 0.5
#: Payload and check may take up to this share of the word; the rest is parity.
FILL = 0.5
#: Uniform rows of a field: top, middle, bottom.
UNIFORM_ROWS = 3
MAX_ROWS, MAX_COLUMNS = 40, 60

Role = Literal["reference", "beat", "phase"]
#: Of each grating, its axis and its rectangle in that axis's own frame, page mm.
Fields = tuple[tuple[Axis, Rect], ...]


@dataclass(frozen=True)
class Grid:
    """Rows of each field, cells in a row (0 where all are uniform), least height of a row and side of a cell, mm."""

    rows: int
    columns: tuple[int, ...]
    row_mm: float
    cell_mm: float


def bands(fields_mm: Fields, count: int) -> Grid:
    """All rows uniform, for the pitch family."""
    _, rect = fields_mm[0]
    row_mm = (rect[3] - rect[1]) / count
    return Grid(count, (0,) * len(fields_mm), row_mm, row_mm)


@lru_cache(maxsize=16)
def choose_grid(fields_mm: Fields, payload_bytes: int) -> Grid:
    """The largest cells of which enough fit.

    Source: of all grids whose word holds the payload at `FILL`, the one whose smaller cell side is largest.
    """
    need = math.ceil((payload_bytes + CHECK_BYTES) / FILL)
    best: Grid | None = None
    for rows in range(UNIFORM_ROWS + 2, MAX_ROWS + 1):
        for columns in range(3, MAX_COLUMNS + 1):
            grid = _grid(fields_mm, rows, columns)
            word = sum((rows - UNIFORM_ROWS) * count for count in grid.columns) // CELLS_PER_BYTE
            if need <= word <= MAX_WORD_BYTES and (best is None or grid.cell_mm > best.cell_mm):
                best = grid
    assert best is not None
    return best


def _grid(fields_mm: Fields, rows: int, columns: int) -> Grid:
    """A grid with `columns` cells in the first field's rows, like cells in the others'."""
    counts, sides = [], []
    for axis, rect in fields_mm:
        low, top, high, bottom = own_rect(axis, rect)
        along, across, first = high - low, bottom - top, fields_mm[0][1]
        count = max(3, round(columns * along / (first[2] - first[0])))
        counts.append(count)
        sides += [along / count, across / rows]
    return Grid(rows, tuple(counts), min(sides[1::2]), min(sides))


#: In a silk field: share of a code's cell, from each of its borders, that passes into its neighbours; and how far
#: uniform rows do, mm, at most the share.  Rows are read without a rim of that size anyway.
SILK_SHARE, UNIFORM_SILK_MM = 0.33, 1.2


def cells_and_roles(
    rect: Rect, axis: Axis, grid: Grid, pitch_mm: float, field: int = 0, *, silk: bool = False
) -> tuple[tuple[Cell, ...], tuple[Role, ...]]:
    """The cells of a field, row by row, and their roles; the identity is written into them later."""
    low, top, high, bottom = own_rect(axis, rect)
    cells: list[Cell] = []
    roles: list[Role] = []
    columns = grid.columns[field]
    uniform = (0, grid.rows // 2, grid.rows - 1) if columns else range(grid.rows)
    for row in range(grid.rows):
        y0, y1 = (top + (bottom - top) * (row + k) / grid.rows for k in (0, 1))
        count = 1 if row in uniform else columns
        for k in range(count):
            x0, x1 = (low + (high - low) * (k + j) / count for j in (0, 1))
            blend = _silk_mm(x1 - x0, y1 - y0, uniform=count == 1) if silk else (0.0, 0.0)
            cells.append(Cell(own_rect(axis, (x0, y0, x1, y1)), pitch_mm, 0.0, DUTY, blend))
            roles.append("phase" if count > 1 else "reference" if row == grid.rows // 2 else "beat")
    return tuple(cells), tuple(roles)


def _silk_mm(length: float, height: float, *, uniform: bool) -> tuple[float, float]:
    """How far a cell of that length and height blends."""
    if uniform:
        return 0.0, min(UNIFORM_SILK_MM, SILK_SHARE * height)
    return SILK_SHARE * length, SILK_SHARE * height
