"""One sight line at a time, in float64: through the sheet onto the page, whatever the angle.

This is the careful half of the analytic renderer.  It takes the pixels that `quick` leaves: those at the border of a
grating, of the board or of what covers it, and those that see the sheet so steeply that a ray may pass over a lens.

Convention: board frame of `motion`, mm; the lens apex plane is z = -g; across and along as in `page`.
Source: circle intersection and Snell's law in three dimensions; the same physics as `moireid.lenticule`, written
again for one ray at a time because a compiled loop shares nothing with arrays.  Functions with tables among their
arguments are inlined, as numba counts references to each table at every call, which costs more than the optics.
No fast-math flag is set: what it would allow moves rays that just miss.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from moireid.simulate.analytic.light_kernels import lit
from moireid.simulate.compiled import njit

#: Radiance of what covers a part of the board, such as a hand.
HIDDEN_RADIANCE = 0.35
#: A slanted ray may pass over the nearest lenticule and meet another one: at 80 degrees the third.
TRIES = 8


class TracedSheet(NamedTuple):
    """The lens sheet as built, mm; radius is 0 for a line mask.

    gap: thickness of the sheet; height: from the page to the lenses' tops; air: between sheet and page; curvature: of
    sheet and page along x, 1/mm, positive where the edges lie farther from the camera;
    sag: how much deeper the valleys between lenses lie than their tops; steepest: tangent across the lenses up to which
    `quick` finds the first lens that a ray meets.
    """

    pitch: float
    gap: float
    height: float
    air: float
    curvature: float
    refraction: float
    radius: float
    open_fraction: float
    sag: float
    steepest: float


class TracedBoard(NamedTuple):
    """The rest of what a ray may meet: half sizes as printed, covered part (x0, y0, x1, y1), radiances, and the
    picture of the markers, its columns and rows to the printed millimetre, and the value of its even blocks
    (`page`); lens, lamps, lights: as `light_kernels.lit` wants them;
    field: parallax added to parts of a forged badge, of one entry where there is none; places: how far each lens lies
    from its even place, of one entry where none does."""

    half_x: float
    half_y: float
    hidden: Any
    ink: float
    paper: float
    texture: Any
    even: Any
    columns_per_mm: float
    rows_per_mm: float
    block: int
    lens: Any
    lamps: Any
    lights: Any
    field: Any
    places: Any


@njit(error_model="numpy")
def land(x: float, y: float, tx: float, ty: float, sheet: TracedSheet) -> tuple[float, float, bool]:  # pragma: no cover
    """Where a ray that crosses the apex plane at (x, y), across and along the lenses, lands; False if stopped."""
    pitch, g, n, radius = sheet.pitch, sheet.gap, sheet.refraction, sheet.radius
    length2 = 1.0 + tx * tx + ty * ty
    if radius == 0.0:
        # A line mask: the openings are centred where a sheet would have its axes.
        if abs(x / pitch - math.floor(x / pitch + 0.5)) > sheet.open_fraction / 2:
            return 0.0, 0.0, False
        depth_cosine = math.sqrt(n * n * length2 - tx * tx - ty * ty)
        inside = g / depth_cosine + sheet.air
        return x + inside * tx, y + inside * ty, True
    axis = math.floor(x / pitch + 0.5) * pitch
    way = 1.0 if tx >= 0 else -1.0
    a = 1.0 + tx * tx
    for _ in range(TRIES):
        offset = x - axis
        b = offset * tx - radius
        c = offset * offset
        root = b * b - a * c
        if root >= 0.0:
            depth = c / (-b + math.sqrt(root))
            hit = offset + tx * depth
            if abs(hit) <= pitch * 0.5 * (1.0 + 1e-12):
                length = math.sqrt(length2)
                nx, nz = hit / radius, (depth - radius) / radius
                cosine = -(tx * nx + nz) / length
                bend = cosine / n - math.sqrt(1.0 - (1.0 - cosine * cosine) / (n * n))
                vx = tx / length / n + bend * nx
                vy = ty / length / n
                vz = 1.0 / length / n + bend * nz
                landed = axis + hit + vx / vz * (g - depth)
                landed_along = y + ty * depth + vy / vz * (g - depth)
                if sheet.air > 0.0:
                    # The flat back bends the ray out again, or keeps it.
                    leaving2 = 1.0 - n * n * (vx * vx + vy * vy)
                    if leaving2 <= 0.0:
                        return 0.0, 0.0, False
                    run = sheet.air * n / math.sqrt(leaving2)
                    landed, landed_along = landed + vx * run, landed_along + vy * run
                return landed, landed_along, True
        axis += way * pitch
    return 0.0, 0.0, False


@njit(inline="always", error_model="numpy")
def turned(x: float, y: float, frame: Any) -> tuple[float, float]:  # pragma: no cover
    """A vector of the page across and along a grating's lines; frame: a row of `Cells.frames`."""
    return frame[0] * x + frame[1] * y, frame[2] * x + frame[3] * y


@njit(inline="always", error_model="numpy")
def cell_at(grating: int, across: float, along: float, cells: Any) -> int:  # pragma: no cover
    """Number of the cell that holds that place of the page, mm from the board's centre; -1 for none."""
    columns, rows = strip_at(across, cells.bins[grating, 0], cells), strip_at(along, cells.bins[grating, 1], cells)
    number: int = cells.grid[grating, rows, columns]
    return number


@njit(inline="always", error_model="numpy")
def strip_at(place: float, bins: Any, cells: Any) -> int:  # pragma: no cover
    """Which strip between cuts a place lies in; `bins` is one row of `Cells.bins`."""
    number = int(min(max((place - bins[0]) * bins[1], 0.0), bins[2] - 1.0))
    strip: int = cells.strip[number + int(bins[3])]
    return strip + (1 if place >= cells.cuts[strip + int(bins[4])] else 0)


@njit(inline="always", error_model="numpy")
def careful_ray(
    tx: float, ty: float, centre: Any, shown: Any, sheet: TracedSheet, cells: Any, board: TracedBoard
) -> float:  # pragma: no cover
    """Radiance along one sight line from `centre`, by its tangents; -1 where it misses the board.

    In a forged film the fringes are those of a camera moved by `shown`; in a true film `shown` is zero.
    """
    page_x, page_y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    sunk, slope = 0.0, 0.0
    if sheet.curvature != 0.0:
        # The bow is shallow, so the place where the sight line meets it is found in a few steps.
        for _ in range(4):
            sunk = 0.5 * sheet.curvature * page_x * page_x
            page_x = centre[0] + (sunk - centre[2]) * tx
        page_y = centre[1] + (sunk - centre[2]) * ty
        slope = sheet.curvature * page_x
    if abs(page_x) > board.half_x or abs(page_y) > board.half_y:
        return -1.0
    hidden = board.hidden
    if hidden[0] <= page_x < hidden[2] and hidden[1] <= page_y < hidden[3]:
        return HIDDEN_RADIANCE
    lens_x, lens_y = page_x - sheet.height * (tx + slope) / (1.0 - tx * slope), page_y - sheet.height * ty
    for k in range(cells.gratings.shape[0]):
        rect, frame = cells.gratings[k], cells.frames[k]
        across, along = turned(lens_x, lens_y, frame)
        if rect[0] <= across <= rect[2] and rect[1] <= along <= rect[3]:
            depth = sunk - (centre[2] + shown[2]) - sheet.height
            fx = (page_x - sheet.height * tx - centre[0] - shown[0]) / depth
            fx, fy = (fx + slope) / (1.0 - fx * slope), (lens_y - centre[1] - shown[1]) / depth
            if board.field.size > 2:
                i, j = field_part(page_x, page_y, board)
                fx -= board.field[i, j, 0]
                fy -= board.field[i, j, 1]
            tan_across, tan_along = turned(fx, fy, frame)
            return _lines_seen(k, across, along, tan_across, tan_along, depth, sheet, cells, board)
    return page_value(page_x, page_y, board)


@njit(inline="always", error_model="numpy")
def _lines_seen(
    grating: int,
    across: float,
    along: float,
    tx: float,
    ty: float,
    depth: float,
    sheet: TracedSheet,
    cells: Any,
    board: TracedBoard,
) -> float:  # pragma: no cover
    """Radiance at a place of the sheet along the tangents, seen from `depth` in front; all as (across, along)."""
    frame = cells.frames[grating]
    offset, cosine, sine = frame[6], frame[7], frame[8]
    x, y = across * cosine + along * sine - offset, along * cosine - across * sine
    tan_x, tan_y = tx * cosine + ty * sine, ty * cosine - tx * sine
    aside = 0.0
    if board.places.size > 1:
        number = math.floor(x / sheet.pitch + 0.5) + board.places.size // 2
        aside = board.places[min(max(number, 0), board.places.size - 1)]
    landed, ly, through = land(x - aside, y, tan_x, tan_y, sheet)
    if not through:
        return board.ink
    lx = landed + aside + offset
    page_across, page_along = lx * cosine - ly * sine, ly * cosine + lx * sine
    page_across, page_along = page_across + frame[4] * page_along, page_along + frame[5] * page_across
    cell = cell_at(grating, page_across, page_along, cells)
    value = board.paper
    if cell >= 0:
        place = (page_across - cells.lines[cell, 0]) * cells.lines[cell, 1]
        if place - math.floor(place) < cells.lines[cell, 2]:
            value = board.ink
    if board.lamps[grating, 9] > 0.0:
        # Across the lenses a ray covers its share of the pixel, widened by the slant.
        step = depth * (1.0 + tan_x * tan_x) * board.lamps[grating, 9]
        value = lit(value, x, y, tan_x, tan_y, landed, step, board.lens, board.lamps[grating], board.lights[grating])
    return value


@njit(inline="always", error_model="numpy")
def field_part(page_x: float, page_y: float, board: TracedBoard) -> tuple[int, int]:  # pragma: no cover
    """Row and column of the forged field at a place of the page."""
    i = int((page_y / board.half_y + 1.0) * 0.5 * board.field.shape[0])
    j = int((page_x / board.half_x + 1.0) * 0.5 * board.field.shape[1])
    return min(i, board.field.shape[0] - 1), min(j, board.field.shape[1] - 1)


@njit(inline="always", error_model="numpy")
def page_value(page_x: float, page_y: float, board: TracedBoard) -> float:  # pragma: no cover
    """Radiance of the page outside the gratings."""
    column = int((page_x + board.half_x) * board.columns_per_mm)
    row = int((page_y + board.half_y) * board.rows_per_mm)
    column = min(max(column, 0), board.texture.shape[1] - 1)
    row = min(max(row, 0), board.texture.shape[0] - 1)
    value: float = board.texture[row, column]
    return value
