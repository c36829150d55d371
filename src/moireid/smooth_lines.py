"""Smooth fields: lines that pass from cell to cell without a jump, so that the fringes look like watered silk.

Lines are numbered: at a place x along a grating's axis a cell has the number (x - edge) / pitch, whole where a dark
line begins.  Near the borders of cells that blend, the number is a weighted mean of the cells' numbers.  The weight
rises from 0 to 1 across a border, from as far before it as the one cell reaches to as far behind it as the other does.
So a line bends where its neighbour cell has moved lines, and no line ends.

Convention: own coordinates (`moireid.frames`), mm.  Edges of a smooth grating are counted on: cells whose edges differ
by a whole pitch have different numbers.
Source: the step t^3 (10 - 15 t + 6 t^2) has no slope and no curvature at its ends, so fringes have no kink.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from moireid.badge import Cell, Grating
from moireid.frames import own_rect

Array = NDArray[np.float64]
#: Places at which lines are numbered, to the millimetre; between them numbers are all but straight: numbers of an even
#: table are off by 0.002 at most.  The places of lines are found among `FINER` times as many: a printed line may be off
#: by half a dot, and 0.0005 mm more would be too much.
PLACES_PER_MM, FINER = 5.0, 4
#: Of a sum of squares; less is rounding.
LEAST_GAIN = 1e-6
#: A cell's lines are its own from so large a share of the way across a border on, where its neighbours weigh less than
#: 6 %: over what is read of a cell, the mean of that turns its fringes by 0.02 rad at most.
CLEAR_SHARE = 0.8


def smooth_step(share: ArrayLike) -> Array:
    """The weight at a share of the way across a border: 0 before it, 1 behind it."""
    t = np.clip(np.asarray(share, float), 0.0, 1.0)
    # numpy's powers take five times as long.
    return np.asarray(t * t * t * (10 - t * (15 - 6 * t)))


def clear_mm(own_mm: float, other_mm: float) -> float:
    """How far within a cell's border its lines are its own, where it reaches `own_mm` and its neighbour `other_mm`."""
    return max(CLEAR_SHARE * (own_mm + other_mm) - other_mm, 0.0)


def cell_rows(grating: Grating) -> list[tuple[int, ...]]:
    """Indices of the cells in rows with the same extent along the lines, each from low to high along the axis.

    Convention: in the order of their first cells; a cell without a code, or a uniform one, is a row by itself.
    """
    roles = grating.code.roles if grating.code else ("reference",) * len(grating.cells)
    rows: dict[tuple[float, float, int], list[int]] = {}
    for index, (cell, role) in enumerate(zip(grating.cells, roles, strict=True)):
        own = -1 if role == "phase" else index
        _, top, _, bottom = own_rect(grating.axis, cell.rect_mm)
        rows.setdefault((round(top, 4), round(bottom, 4), own), []).append(index)
    return [
        tuple(sorted(row, key=lambda k: own_rect(grating.axis, grating.cells[k].rect_mm)[0])) for row in rows.values()
    ]


def rows_of(grating: Grating) -> list[list[Cell]]:
    """The cells by rows, as `cell_rows`, the rows from low to high along the lines."""
    rows = [[grating.cells[k] for k in row] for row in cell_rows(grating)]
    return sorted(rows, key=lambda row: own_rect(grating.axis, row[0].rect_mm)[1])


@lru_cache(maxsize=64)
def rims_mm(grating: Grating) -> tuple[tuple[float, float], ...]:
    """For each cell, how far from its borders its lines are not its own: along the axis, and along the lines.

    Source: an inner cell's neighbours reach as far as it does; of a row's two neighbours that which reaches less.
    """
    rows = rows_of(grating)
    found = {}
    for r, row in enumerate(rows):
        near = [other[0].blend_mm[1] for other in rows[max(r - 1, 0) : r] + rows[r + 1 : r + 2]]
        for cell in row:
            along, across = cell.blend_mm
            found[cell.rect_mm] = clear_mm(along, along), clear_mm(across, min(near, default=across))
    return tuple(found[cell.rect_mm] for cell in grating.cells)


def smoothest(grating: Grating) -> tuple[Cell, ...]:
    """Its cells, with edges counted on by whole pitches until neighbours' numbers are as near as they can be.

    Returns: in the order of the grating's own cells; rows of one cell are left as they are.
    Source: each cell in turn takes that number which makes the sum of squares of its four differences least, until no
        cell changes; that ends, as each change makes the sum over the field less.
    """
    rows = rows_of(grating)
    middles = [
        [(low + high) / 2 for low, _, high, _ in (own_rect(grating.axis, c.rect_mm) for c in row)] for row in rows
    ]
    edges = [[cell.edge_mm for cell in row] for row in rows]
    near = {(r, k): _neighbours(rows, r, k) for r, row in enumerate(rows) if len(row) > 1 for k in range(len(row))}

    def number(r: int, k: int, along: float) -> float:
        return (along - edges[r][k]) / rows[r][k].pitch_mm

    changed = True
    while changed:
        changed = False
        for (r, k), others in near.items():
            own = number(r, k, middles[r][k])
            apart = sum(own - number(*other, middles[r][k]) for other in others)
            # A whole number on changes the sum of the squares of n differences by n and twice their sum.
            if 2 * abs(apart) > len(others) + LEAST_GAIN:
                edges[r][k] += math.copysign(rows[r][k].pitch_mm, apart)
                changed = True
    counted = {
        cell.rect_mm: replace(cell, edge_mm=edge) if edge != cell.edge_mm else cell
        for row, own_edges in zip(rows, edges, strict=True)
        for cell, edge in zip(row, own_edges, strict=True)
    }
    return tuple(counted[cell.rect_mm] for cell in grating.cells)


def _neighbours(rows: list[list[Cell]], r: int, k: int) -> list[tuple[int, int]]:
    """Row and place in it of the cells on either side of one, and of those above and below it."""
    found = [(r, other) for other in (k - 1, k + 1) if 0 <= other < len(rows[r])]
    for other in (r - 1, r + 1):
        if 0 <= other < len(rows):
            found.append((other, k * len(rows[other]) // len(rows[r])))
    return found


@lru_cache(maxsize=4)
def line_field(grating: Grating) -> LineField:
    """The numbers of a smooth grating's lines, with its table, which pictures of one badge share."""
    return LineField(grating)


class LineField:
    """The numbers of a smooth grating's lines."""

    def __init__(self, grating: Grating) -> None:
        self._rows = rows_of(grating)
        self._rects = [[own_rect(grating.axis, cell.rect_mm) for cell in row] for row in self._rows]
        self.low, self.begin, self.high, self.end = own_rect(grating.axis, grating.rect_mm)
        self.duty = grating.cells[0].duty

    def numbers(self, along: ArrayLike, across: ArrayLike) -> Array:
        """The number of the line at places along the axis and across it (along the lines), broadcast together."""
        along, across = np.asarray(along, float), np.asarray(across, float)
        borders = [rects[0][1] for rects in self._rects[1:]]
        reach = [row[0].blend_mm[1] for row in self._rows]
        rows = [self._row_numbers(k, along) for k in range(len(self._rows))]
        if along.ndim == 1 and across.ndim == 2 and borders:
            # On a grid, two rows or three have a weight at each place across, all along.
            weights, grid = _blended(across, borders, reach, np.eye(len(rows))), np.zeros((len(across), len(along)))
            for k, row in enumerate(rows):
                near = np.flatnonzero(weights[:, k])
                grid[near] += weights[near, k, None] * row
            return grid
        found = _blended(across, borders, reach, rows)
        # A field of one row does not depend on the place across.
        return np.broadcast_to(found, np.broadcast_shapes(along.shape, across.shape))

    def _row_numbers(self, row: int, along: Array) -> Array:
        """The numbers within one row, as if it were alone."""
        cells, rects = self._rows[row], self._rects[row]
        own = [(along - cell.edge_mm) / cell.pitch_mm for cell in cells]
        return _blended(along, [rect[0] for rect in rects[1:]], [cell.blend_mm[0] for cell in cells], own)

    def edges_mm(self, across: ArrayLike) -> Array:
        """Where dark lines begin and end along the axis, at places across (Y,): (Y, lines, 2), cut at its ends.

        Some have no width.
        """
        places = np.linspace(self.low, self.high, round(FINER * PLACES_PER_MM * (self.high - self.low)) + 1)
        rows = self.numbers(places, np.asarray(across, float)[:, None])
        whole = np.arange(math.floor(rows[:, 0].min()), math.ceil(rows[:, -1].max()) + 1)
        edges = whole[:, None] + np.array([0.0, self.duty])
        return np.stack([np.interp(edges, row, places) for row in rows])

    def sampled(self, along: Array, across: Array) -> Array:
        """As `numbers`, for many places of one shape, from an even table: off by 0.002 lines at most.

        Beyond the field's ends, lines go straight on.
        """
        table = self._table
        columns = table.shape[1]
        x = (along - self.low) / (self.high - self.low) * (columns - 1)
        y = (across - self.begin) / (self.end - self.begin) * (len(table) - 1)
        left, top = (np.clip(p.astype(np.int32), 0, count - 2) for p, count in ((x, columns), (y, len(table))))
        right, below = (x - left).astype(np.float32), (y - top).astype(np.float32)
        corner, flat = columns * top + left, table.ravel()
        upper, lower = (
            flat[row:].take(corner) * (1 - right) + flat[row + 1 :].take(corner) * right for row in (0, columns)
        )
        return np.asarray(upper + below * (lower - upper))

    @cached_property
    def _table(self) -> Array:
        """Numbers at even places across the field, by rows and columns."""
        sides = ((self.low, self.high), (self.begin, self.end))
        along, across = (np.linspace(*side, round(PLACES_PER_MM * (side[1] - side[0])) + 1) for side in sides)
        return self.numbers(along, across[:, None]).astype(np.float32)


def _blended(place: Array, borders: Sequence[float], reach: Sequence[float], values: Sequence[Array] | Array) -> Array:
    """Values that pass into each other at borders; reach: how far each value's part blends, mm."""
    found = values[0]
    for border, before, behind, value in zip(borders, reach[:-1], reach[1:], values[1:], strict=True):
        width = before + behind
        share = (place - border + before) / width if width > 0 else (place >= border).astype(float)
        weight = smooth_step(share)
        found = found + weight * (value - found)
    return np.asarray(found)
