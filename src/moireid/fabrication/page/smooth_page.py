"""Curved lines of a smooth field on the page: as stairs of whole dots, or as outlines.

On dots, a line is drawn row of dots by row of dots, each edge on the border between dots that is nearest to its place
in that row.  So no edge is off by more than half a dot, and nothing drifts.  Rows in which both edges are the same are
one rectangle.

Convention: own coordinates (`moireid.frames`), mm; the page's dots are counted from its left and upper edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Grating
from moireid.dots import INSET_DOTS, nearest_dot
from moireid.fabrication.page.canvas import PdfPage
from moireid.frames import OwnFrame
from moireid.smooth_lines import line_field

Array = NDArray[np.float64]
#: Places across at which lines are computed; between them they are all but straight.
STEP_MM = 0.2


def draw_smooth_lines(sheet: PdfPage, frame: OwnFrame, grating: Grating, ink_mm: float) -> None:
    """Draw all lines of a smooth grating, as `pdf.draw_lines` does those of others."""
    field = line_field(grating)
    across = np.linspace(field.begin, field.end, int((field.end - field.begin) / STEP_MM) + 2)
    edges = field.edges_mm(across)
    whole = edges[..., 1] > edges[..., 0]
    edges = edges + np.where(whole[..., None], ink_mm / 2 * np.array([1.0, -1.0]), 0.0)
    dot_mm = sheet.dot_mm
    if dot_mm is None or not isinstance(grating.axis, str):
        lines = zip(edges.swapaxes(0, 1), whole.T, strict=True)
        outlines = [_outline(across[seen], line[seen]) for line, seen in lines if np.count_nonzero(seen) > 1]
        sheet.fill_loops([[sheet.place(x, y) for x, y in frame.on_page(one).tolist()] for one in outlines])
        return
    # A badge may lie anywhere on a sheet that may be scaled, and dots are the sheet's.
    origin, unit = np.array(sheet.place(0.0, 0.0)), np.array(sheet.place(1.0, 1.0))
    turn = slice(None) if grating.axis == "x" else slice(None, None, -1)
    (along_0, across_0), (scale_along, scale_across) = origin[turn], (unit - origin)[turn]
    edges, across = along_0 + scale_along * edges, across_0 + scale_across * across
    first, last = nearest_dot(across[[0, -1]], dot_mm).astype(int)
    rects = np.concatenate([_stairs(line, across, np.arange(first, last), dot_mm) for line in edges.swapaxes(0, 1)])
    sheet.fill_drawn(rects if grating.axis == "x" else rects[:, [1, 0, 3, 2]])


def _outline(across: Array, line: Array) -> Array:
    """The corners of one line (n, 2), down its one side and up the other."""
    down, up = np.column_stack([line[:, 0], across]), np.column_stack([line[:, 1], across])
    return np.concatenate([down, up[::-1]])


def _stairs(line: Array, across: Array, rows: NDArray[np.int64], dot_mm: float) -> Array:
    """Rectangles (n, 4) of whole dots along one line, in own order.

    Parameters: line (Y, 2): its edges at places across (Y,), mm on the sheet; rows: numbers of the rows of dots.
    """
    edges = np.column_stack([np.interp((rows + 0.5) * dot_mm, across, line[:, k]) for k in (0, 1)])
    dots, drawn = nearest_dot(edges, dot_mm).astype(int), edges[:, 1] > edges[:, 0]
    dots[:, 1] = np.maximum(dots[:, 1], dots[:, 0] + 1)
    # numpy's `any` along an axis of two takes three times as long.
    begin, end = (dots[1:] != dots[:-1]).T
    new = np.flatnonzero(begin | end | (drawn[1:] != drawn[:-1])) + 1
    ends = np.concatenate([[0], new, [len(rows)]])
    tops, bottoms = ends[:-1][drawn[ends[:-1]]], ends[1:][drawn[ends[:-1]]]
    left, right = ((dots[tops] + INSET_DOTS * np.array([1, -1])) * dot_mm).T
    return np.stack([left, (rows[0] + tops) * dot_mm, right, (rows[0] + bottoms) * dot_mm], axis=-1)
