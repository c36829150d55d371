"""How a field is cut into rows and cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from moireid.badge import Cell, Rect
from moireid.designer.layout import Layout
from moireid.errors import DesignError
from moireid.idcodes.spacing import CELLS_PER_BYTE
from moireid.idcodes.words import CHECK_BYTES, MAX_WORD_BYTES

DUTY = 0.5
#: Payload and check may fill this share of the word; the rest is parity.
FILL = 0.5
#: Uniform rows of a field: top, middle, bottom.
UNIFORM_ROWS = 3
#: Least size of a cell at the far end of the range, pixels; below it, neighbours' fringes blur into one another.
MIN_CELL_PX = 3.0
MAX_ROWS, MAX_COLUMNS = 40, 60

Role = Literal["reference", "beat", "phase"]


@dataclass(frozen=True)
class Grid:
    """Rows of each field, cells in a row (0 where all rows are uniform), and the least height of a row, mm."""

    rows: int
    columns: tuple[int, ...]
    row_mm: float


def bands(layout: Layout, count: int) -> Grid:
    """All rows uniform, for the pitch family."""
    _, rect = layout.fields_mm[0]
    return Grid(count, (0,) * len(layout.fields_mm), (rect[3] - rect[1]) / count)


def choose_grid(layout: Layout, payload_bytes: int, px_per_mm: float) -> Grid:
    """The largest cells of which enough fit.

    Source: of all grids whose word holds the payload at `FILL`, the one whose smaller cell side is largest.
    Raises: DesignError, with the range that would work, where those cells are too small at the far end.
    """
    need = -(-(payload_bytes + CHECK_BYTES) // FILL)
    best: tuple[float, Grid] | None = None
    for rows in range(UNIFORM_ROWS + 2, MAX_ROWS + 1):
        for columns in range(3, MAX_COLUMNS + 1):
            grid, side = _grid(layout, rows, columns)
            word = sum((rows - UNIFORM_ROWS) * count for count in grid.columns) // CELLS_PER_BYTE
            if need <= word <= MAX_WORD_BYTES and (best is None or side > best[0]):
                best = (side, grid)
    assert best is not None
    side, grid = best
    if side * px_per_mm < MIN_CELL_PX:
        reach_mm = side * px_per_mm / MIN_CELL_PX
        raise DesignError(
            f"{8 * payload_bytes} bits need cells of {side:.1f} mm on this board, {side * px_per_mm:.1f} pixels at the "
            f"far end, fewer than {MIN_CELL_PX:g}; multiply the range's end by {reach_mm:.2f} or give a larger board",
            share=reach_mm,
        )
    return grid


def _grid(layout: Layout, rows: int, columns: int) -> tuple[Grid, float]:
    """A grid with `columns` cells in the first field's rows, like cells in the others', and its smallest side, mm."""
    counts, sides = [], []
    for axis, rect in layout.fields_mm:
        along, across = (
            (rect[2] - rect[0], rect[3] - rect[1]) if axis == "x" else (rect[3] - rect[1], rect[2] - rect[0])
        )
        first = layout.fields_mm[0][1]
        count = max(3, round(columns * along / (first[2] - first[0])))
        counts.append(count)
        sides += [along / count, across / rows]
    return Grid(rows, tuple(counts), min(sides[1::2])), min(sides)


def cells_and_roles(
    rect: Rect, axis: str, grid: Grid, pitch_mm: float, field: int = 0
) -> tuple[tuple[Cell, ...], tuple[Role, ...]]:
    """The cells of a field, row by row, and their roles; the identity is written into them later."""
    low, top, high, bottom = rect if axis == "x" else (rect[1], rect[0], rect[3], rect[2])
    cells: list[Cell] = []
    roles: list[Role] = []
    columns = grid.columns[field]
    uniform = (0, grid.rows // 2, grid.rows - 1) if columns else range(grid.rows)
    for row in range(grid.rows):
        y0, y1 = (round(top + (bottom - top) * (row + k) / grid.rows, 3) for k in (0, 1))
        count = 1 if row in uniform else columns
        for k in range(count):
            x0, x1 = (round(low + (high - low) * (k + j) / count, 3) for j in (0, 1))
            place: Rect = (x0, y0, x1, y1) if axis == "x" else (y0, x0, y1, x1)
            cells.append(Cell(place, pitch_mm, 0.0, DUTY))
            roles.append("phase" if count > 1 else "reference" if row == grid.rows // 2 else "beat")
    return tuple(cells), tuple(roles)
