"""The range of distances at which a board is read: near, all of it is in the picture; far, all is large enough.

Convention: metres between camera and badge; the camera of a design is `link.PHONE`.
"""

from __future__ import annotations

import math

from moireid.badge import Badge
from moireid.designer.fiducial import as_marker_mm
from moireid.designer.grid import UNIFORM_ROWS, Grid
from moireid.designer.layout import Layout
from moireid.designer.link import LinkBudget, Read, found_reach_m
from moireid.designer.request import DESIGN_FOCAL_PX, Request
from moireid.errors import DesignError
from moireid.frames import own_rect
from moireid.idcodes.spacing import CELLS_PER_BYTE
from moireid.idcodes.words import MAX_WORD_BYTES, WordCode

#: The picture of the camera that a design must suffice for.
DESIGN_IMAGE_PX = (1920, 1080)
#: Print scale may be off by 0.5 % and lens pitch by 0.3 %; both shift every beat by that share of 1/p_f.
PITCH_TOLERANCE = 0.008
#: Fewest fringes across the grating that fit and shading share without confusion, and pixels that a fringe needs.
MIN_FRINGES = 2.0
MIN_PX_PER_FRINGE = 5.0
#: Least spacing of levels, in fringes across the grating: a level's half step is then a fifth of a fringe.
MIN_STEP_FRINGES = 0.40
#: A uniform band of the pitch code that is lower than this has no profile of its own.
MIN_BAND_PX = 4.0
#: Poses err by the square of the distance over that of the page, so a verdict needs so much more motion.  Eight seconds
#: of swaying, in a film of crf 28, are accepted up to this distance, m, for a millimetre of the markers' extent (root
#: of width by height).  Source: the formats' far ends in `benchmarks/link.py`; the board at 1.5 m was accepted, at
#: 1.75 m in four films of six.
VERDICT_M_PER_MM = 0.0098


def fringe_length_mm(layout: Layout) -> float:
    """Length along which the fringes of the shortest field run."""
    fields = (own_rect(axis, rect) for axis, rect in layout.fields_mm)
    return min(high - low for low, _, high, _ in fields)


def check_range(
    request: Request, layout: Layout, grids: tuple[Grid, ...], lens_pitch_mm: float, levels: int, payload_bytes: int
) -> None:
    """The whole board must be in the picture at the near end, and everything large enough at the far end.

    Parameters: grids: one a field.
    Raises: DesignError that names the range that this board has, or a board that has one.
    """
    board = (layout.board_mm[2] - layout.board_mm[0], layout.board_mm[3] - layout.board_mm[1])
    near = max(side * DESIGN_FOCAL_PX / image for side, image in zip(board, DESIGN_IMAGE_PX, strict=True)) / 1000.0
    reaches = _reach_m(layout, grids, lens_pitch_mm, levels, payload_bytes)
    what = min(reaches, key=lambda name: reaches[name])
    near_m, far_m = math.ceil(100 * near) / 100, math.floor(100 * reaches[what]) / 100
    words = f"a board of {board[0]:g} x {board[1]:g} mm"
    if near_m > far_m:
        raise DesignError(
            f"{words} fits the picture from {near_m:.2f} m on, but its {what} are too small beyond {far_m:.2f} m; "
            "give a board such as 146x160",
            near_m=near_m,
            far_m=far_m,
            size_mm=(146.0, 160.0),
        )
    if request.range_m[0] < near_m or request.range_m[1] > far_m:
        raise DesignError(
            f"{words} is read at {near_m:.2f} to {far_m:.2f} m, not {request.range_m[0]:g} to {request.range_m[1]:g}: "
            f"nearer it overfills the picture, beyond its {what} are too small; choose a range within "
            f"{near_m:.2f}-{far_m:.2f} m, or give a larger board",
            near_m=near_m,
            far_m=far_m,
        )


def _reach_m(
    layout: Layout, grids: tuple[Grid, ...], lens_pitch_mm: float, levels: int, payload_bytes: int
) -> dict[str, float]:
    """How far each part of the board can be read, metres."""
    width_mm, tolerance = fringe_length_mm(layout), PITCH_TOLERANCE / lens_pitch_mm
    fastest = 2 * tolerance + (MIN_FRINGES + (levels - 1) * MIN_STEP_FRINGES) / width_mm
    marker_mm = as_marker_mm(layout.markers)
    reaches = {
        "markers": found_reach_m(marker_mm),
        "fringes": DESIGN_FOCAL_PX / (fastest * MIN_PX_PER_FRINGE) / 1000,
    }
    cells = sum((grid.rows - UNIFORM_ROWS) * grid.columns[field] for field, grid in enumerate(grids))
    if not grids[0].columns[0]:
        return reaches | {"rows": DESIGN_FOCAL_PX * grids[0].row_mm / MIN_BAND_PX / 1000}
    smallest_mm = min(grid.cell_mm for grid in grids)
    if smallest_mm <= 0:
        # Markers and margins alone are wider than the board.
        return reaches | {"cells": 0.0}
    return reaches | {"cells": Read(smallest_mm, math.inf, _word(payload_bytes, cells)).reach_m()}


def _word(payload_bytes: int, cells: int) -> WordCode:
    return WordCode(payload_bytes, min(cells // CELLS_PER_BYTE, MAX_WORD_BYTES))


def read_of(badge: Badge) -> Read | None:
    """The parts of a badge that are read (`Read`); None for one without phase cells."""
    phases = [
        cell
        for grating in badge.gratings
        if grating.code
        for cell, role in zip(grating.cells, grating.code.roles, strict=True)
        if role == "phase"
    ]
    if not phases:
        return None
    side_mm = min(cell.rect_mm[k + 2] - cell.rect_mm[k] for cell in phases for k in (0, 1))
    return Read(side_mm, as_marker_mm(badge.markers), _word((badge.payload_bits or 0) // 8, len(phases)))


def link_budgets(badge: Badge) -> list[tuple[float, LinkBudget]]:
    """Distance in metres and link budget at each end of the badge's range; none for a badge without phase cells.

    Convention and source: `link.Read.at`.
    """
    read = read_of(badge)
    if read is None or badge.range_m is None:
        return []
    return [(metres, read.at(metres)) for metres in dict.fromkeys(badge.range_m)]


def verdict_reach_m(badge: Badge) -> float:
    """Up to where eight seconds of swaying are enough for a verdict, m.  Source: `VERDICT_M_PER_MM`."""
    dark = badge.markers.dark_mm
    wide, high = (max(rect[k + 2] for rect in dark) - min(rect[k] for rect in dark) for k in (0, 1))
    return VERDICT_M_PER_MM * math.sqrt(wide * high)
