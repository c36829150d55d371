"""Printed lines on a printer's dots: where each edge goes, and the errors of pitch and phase that this causes.

The rule: every edge goes from its own ideal place to the nearest border between dots, counted from the page's left and
upper edge.  Its neighbours do not matter.  So an edge is wrong by at most half a dot on a page of any size, and errors
do not add up.

Source: rounding; the figures of a cell are a straight line through its rounded edges by least squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Cell, Grating
from moireid.errors import SpecError
from moireid.frames import own_rect
from moireid.sheets import MM_PER_INCH

Array = NDArray[np.float64]
#: The widest growth of a line that is drawn for, um: a laser of 1200 dpi was measured at 42 to 64.
MOST_INK_UM = 150.0
#: Share of a dot by which a line is drawn within its dots, half of what either kind of raster leaves.
INSET_DOTS = 0.25
#: Figures listed for each cell on the printer's dots.
COLUMNS = ("grating", "cell", "pitch_error_ppm", "edge_error_um", "phase_error_rad", "beat_error_share")


@dataclass(frozen=True)
class RealisedCell:
    """One cell on dots, against its design.

    pitch_error: share of the pitch; edge_error_mm: the largest of all edges; phase_error_rad: shift of the middle of
    its lines, as fringe phase; beat_error: share of the beat frequency, 0 if there is none.
    """

    pitch_error: float
    edge_error_mm: float
    phase_error_rad: float
    beat_error: float


def nearest_dot(place_mm: Array, dot_mm: float) -> Array:
    """Number of the border between dots that is nearest to each place; ties are rounded up."""
    return np.floor(np.asarray(place_mm) / dot_mm + 0.5)


def ink_growth_mm(badge: Badge) -> float:
    """By how much the badge's printer widens a line, both edges together, mm; lines are drawn narrower by that.

    Raises: SpecError where the badge's file states what no printer does.
    """
    growth_um = (badge.print or {}).get("ink_growth_um", 0.0)
    if not isinstance(growth_um, int | float) or not 0 <= growth_um <= MOST_INK_UM:
        raise SpecError(
            f"print.ink_growth_um must be a number from 0 to {MOST_INK_UM:g}, got {growth_um!r}; print the badge again"
        )
    return growth_um / 1000


def line_edges_mm(grating: Grating, cell: Cell, ink_mm: float = 0.0) -> Array:
    """Begin and end of every complete dark line of a cell along the grating's axis, (lines, 2), page mm.

    Parameters: ink_mm: as `ink_growth_mm`; lines are narrower by it about their middles.
    """
    low, _, high, _ = own_rect(grating.axis, cell.rect_mm)
    first, last = math.ceil((low - cell.edge_mm) / cell.pitch_mm), math.floor((high - cell.edge_mm) / cell.pitch_mm)
    begins = cell.edge_mm + np.arange(first, last + 1) * cell.pitch_mm
    edges = np.column_stack([begins, begins + cell.duty * cell.pitch_mm])
    return np.asarray(edges[edges[:, 1] <= high + 1e-9] + ink_mm / 2 * np.array([1.0, -1.0]))


def realised(grating: Grating, cell: Cell, lens_pitch_mm: float, dot_mm: float, ink_mm: float = 0.0) -> RealisedCell:
    """Errors of a cell by rounding to dots; ink_mm: as in `line_edges_mm`.

    Convention: phase positive where the fringe is ahead, which means that lines are shifted back (`idcodes.spacing`).
    Returns: Realised; all 0 if the cell has fewer than two lines.
    """
    edges = line_edges_mm(grating, cell, ink_mm)
    if len(edges) < 2:
        return RealisedCell(0.0, 0.0, 0.0, 0.0)
    drawn = nearest_dot(edges, dot_mm) * dot_mm
    off = (drawn - edges).mean(axis=1)
    places = np.arange(len(edges)) - (len(edges) - 1) / 2
    slope = float(places @ off / (places @ places))
    pitch = cell.pitch_mm + slope
    beat = 1 / cell.pitch_mm - 1 / lens_pitch_mm
    return RealisedCell(
        pitch_error=slope / cell.pitch_mm,
        edge_error_mm=float(np.abs(drawn - edges).max()),
        phase_error_rad=float(-2 * math.pi * off.mean() / cell.pitch_mm),
        beat_error=(1 / pitch - 1 / cell.pitch_mm) / beat if beat else 0.0,
    )


def on_dots(badge: Badge) -> dict[str, Any] | None:
    """Errors of every cell of a badge by rounding to dots, as in badge.json: `columns`, and rows in `cells`.

    A turned grating is left out: its lines cross the dots at an angle, so over a cell their edges are spread evenly
    about their places.  On dots that are inked by their centres, or wherever they are touched, the fringe of a cell of
    5 mm is then off by up to 0.002 rad at 600 dpi and 0.007 at 300 (docs/decisions/optics.md).

    Returns: None for a badge that does not say how it is printed, or that leaves the dots to the printer.
    """
    print_data = badge.print or {}
    if "dpi" not in print_data or print_data.get("form") == "vector":
        return None
    dot_mm = MM_PER_INCH / int(print_data["dpi"])
    rows = []
    for g, grating in enumerate(badge.gratings):
        if not isinstance(grating.axis, str):
            continue
        for c, cell in enumerate(grating.cells):
            one = realised(grating, cell, badge.lens.pitch_mm, dot_mm, ink_growth_mm(badge))
            figures = 1e6 * one.pitch_error, 1e3 * one.edge_error_mm, one.phase_error_rad, one.beat_error
            rows.append([g, c, *(round(value, places) for value, places in zip(figures, (2, 2, 4, 6), strict=True))])
    return {"columns": list(COLUMNS), "cells": rows}
