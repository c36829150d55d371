"""A painted page against its badge: every edge, the pitch of each row, and what is read off the page alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Cell
from moireid.layers import is_smooth
from moireid.smooth_lines import LineField
from moireid_lab.bench.fabricate.raster import Raster, line_edges, read_page, without_lines

#: Length over which a row's pitch is fitted.
FIT_MM = 80.0


def painted_figures(page: Raster, badge: Badge) -> dict[str, Any]:
    """Edge errors in dots, shares by which the pitches of uniform rows are off, and what is read off the page alone."""
    errors, pitches = edge_errors(page, badge)
    reading = read_page(page, without_lines(badge))
    payload = reading.found.payload if reading else None
    return {
        "errors": errors,
        "pitches": pitches,
        "markers": len(reading.markers) if reading else 0,
        "read": payload is not None and payload.hex() == badge.id and bool(reading and reading.found.beats_agree),
        "wrong": payload is not None and payload.hex() != badge.id,
        "phase_rad": reading.phase_error_rad if reading else float("nan"),
    }


def edge_errors(page: Raster, badge: Badge) -> tuple[NDArray[np.float64], list[float]]:
    """Distance of every painted edge from its place, in dots, and the pitch error of each row of `FIT_MM` or more."""
    dot, to_dots = page.dot_mm, np.array([[1 / page.dot_mm, 0.0]] * 2)
    errors, pitches = [], []
    for grating in badge.gratings:
        k = 0 if grating.axis == "x" else 1
        field = LineField(grating) if is_smooth(grating) else None
        for cell in grating.cells:
            sides = []
            begins, ends, across = line_edges(page, grating, cell, to_dots)
            for edges, first in ((begins * dot, 0.0), (ends * dot, cell.duty)):
                numbers, per_mm = _own_numbers(cell, edges), np.full(len(edges), 1 / cell.pitch_mm)
                if field is not None:
                    # Where lines bend they are a little nearer to each other, or farther apart, than the pitch.
                    before, numbers, after = (field.numbers(edges + step, across) for step in (-dot, 0.0, dot))
                    per_mm = (after - before) / (2 * dot)
                count = np.round(numbers - first)
                errors.append((numbers - first - count) / per_mm / dot)
                sides.append((count, edges))
            if cell.rect_mm[k + 2] - cell.rect_mm[k] < FIT_MM:
                continue
            middle = (cell.rect_mm[k] + cell.rect_mm[k + 2]) / 2
            slopes = []
            for count, places in sides:
                use = np.abs(places - middle) <= FIT_MM / 2
                slopes.append(np.polyfit(count[use], places[use], 1)[0])
            pitches.append(float(np.mean(slopes) / cell.pitch_mm - 1))
    return np.concatenate(errors), pitches


def _own_numbers(cell: Cell, along_mm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Numbers of a cell's lines where none bends."""
    return (along_mm - cell.edge_mm) / cell.pitch_mm
