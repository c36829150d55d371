"""One sight line at a time, in float64: through the sheet onto the page, whatever the angle.

This is the careful half of the analytic renderer.  It takes the pixels that `quick` leaves: those at the border of a
grating, of the board or of what covers it, and those that see the sheet so steeply that a ray may pass over a lens.

Convention: board frame of `motion`, mm; the lens apex plane is z = -g; across and along as in `page`.
Source: `traced_sheet`.  Functions with tables among their arguments are inlined, as numba counts references to each
table at every call, which costs more than the optics.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from moireid.simulate.analytic.light_kernels import lit
from moireid.simulate.analytic.traced_sheet import TracedSheet, land
from moireid.simulate.analytic.uneven_sheet import smooth_at
from moireid.simulate.compiled import njit

#: Radiance of what covers a part of the board, such as a hand.
HIDDEN_RADIANCE = 0.35


class TracedBoard(NamedTuple):
    """The rest of what a ray may meet: half sizes as printed, covered part (x0, y0, x1, y1), radiances, and the
    picture of the markers, its columns and rows to the printed millimetre, and the value of its even blocks
    (`traced_page`); lamps, lights: as `light_kernels.lit` wants them;
    field: parallax added to parts of a forged badge, of one entry where there is none; places: how far each lens lies
    from its even place, of one entry where none does; asides, waves: of `uneven_sheet`."""

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
    lamps: Any
    lights: Any
    field: Any
    places: Any
    asides: Any
    waves: Any


class FrameView(NamedTuple):
    """The camera during one frame: the first pixel's middle, px from the principal point; its number across and down,
    counted from the board's own corner, so that a pixel has the same rays in every crop; focal length, px; centres
    (rows, 5, 3) and turns (rows, 5, 3, 3) board -> camera at the `TIMES` of each row's exposure; distortion, as
    `Camera.distortion`.

    shown (5, 3): how far from the camera the place is from which a forged film shows the fringes, mm, at these times; 0
    in a true film.  points (3, R) float32: places of a pixel's rays in it, and their times in the exposure, -1/2 to
    1/2; moving: whether the times differ; quick: whether `quick` may be used.
    """

    corner_x: float
    corner_y: float
    first_column: int
    first_row: int
    focal: float
    centres: Any
    turns: Any
    distortion: Any
    shown: Any
    points: Any
    moving: bool
    quick: bool


#: Times of an exposure, -1/2 to 1/2, at which poses are given.
TIMES = (0.0, -0.5, 0.5, -0.25, 0.25)
#: How a pixel moves while it is exposed.  At a time t its place on the page has moved by a t + b t^2 + c t^3 + d t^4,
#: and its tangents by a t + b t^2: a, b, c, d of x, then of y; a and b of the tangent of x, then of y.
NO_SWEEP = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@njit(inline="always")
def moved(time: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """What a place changes at a time of the exposure."""
    return (a + (b + (c + d * time) * time) * time) * time


@njit(inline="always")
def turned(x: float, y: float, frame: Any) -> tuple[float, float]:
    """A vector of the page across and along a grating's lines; frame: a row of `Cells.frames`."""
    return frame[0] * x + frame[1] * y, frame[2] * x + frame[3] * y


@njit(inline="always")
def bins_of(grating: int, cells: Any) -> tuple[Any, Any, Any, Any, Any, Any, bool]:
    """Begin, bins to the millimetre and last bin, across and along; and whether each bin is a strip."""
    return (
        cells.bins[grating, 0, 0],
        cells.bins[grating, 0, 1],
        cells.bins[grating, 0, 2],
        cells.bins[grating, 1, 0],
        cells.bins[grating, 1, 1],
        cells.bins[grating, 1, 2],
        cells.bins[grating, 0, 3] * cells.bins[grating, 1, 3] > np.float32(0.0),
    )


@njit(inline="always")
def _bin(place: Any, begin: Any, per_mm: Any, last: Any) -> Any:
    """The bin of a place; NaN is in the first."""
    number = (place - begin) * per_mm
    number = number if number > np.float32(0.0) else np.float32(0.0)
    return np.uint32(number if number < last else last)


@njit(inline="always")
def is_inked(x: Any, y: Any, grating: int, bins: Any, cells: Any) -> bool:
    """Whether a place of the print is inked; NaN, which no light reaches, counts as ink."""
    across, along = _bin(x, bins[0], bins[1], bins[2]), _bin(y, bins[3], bins[4], bins[5])
    if not bins[6]:
        across = np.uint32(cells.strips[grating, 0, across] + (x >= cells.next_cut[grating, 0, across]))
        along = np.uint32(cells.strips[grating, 1, along] + (y >= cells.next_cut[grating, 1, along]))
    place = (
        cells.print[grating, along, across, 0]
        + x * cells.print[grating, along, across, 1]
        + y * cells.print[grating, along, across, 3]
    )
    return not place - np.floor(place) >= cells.print[grating, along, across, 2]


@njit(inline="always")
def careful_ray(
    tx: float, ty: float, centre: Any, shown: Any, sheet: TracedSheet, cells: Any, board: TracedBoard
) -> float:
    """Radiance along one sight line from `centre`, by its tangents; -1 where it misses the board.

    Parameters: shown: how far from the centre the place is from which the fringes are shown.
    """
    x, y, page_x, page_y, sunk, slope_x, slope_y = on_page(tx, ty, centre, sheet)
    if abs(page_x) > board.half_x or abs(page_y) > board.half_y:
        return -1.0
    hidden = board.hidden
    if hidden[0] <= page_x < hidden[2] and hidden[1] <= page_y < hidden[3]:
        return HIDDEN_RADIANCE
    fall = 1.0 - tx * slope_x - ty * slope_y
    lens_x = page_x - sheet.height * (tx + slope_x) / fall
    lens_y = page_y - sheet.height * (ty + slope_y) / fall
    for k in range(cells.gratings.shape[0]):
        rect, frame = cells.gratings[k], cells.frames[k]
        across, along = turned(lens_x, lens_y, frame)
        if rect[0] <= across <= rect[2] and rect[1] <= along <= rect[3]:
            depth = sunk - (centre[2] + shown[2]) - sheet.height
            fx = (x - sheet.height * tx - centre[0] - shown[0]) / depth
            fy = (y - sheet.height * ty - centre[1] - shown[1]) / depth
            fall = 1.0 - fx * slope_x - fy * slope_y
            fx, fy = (fx + slope_x) / fall, (fy + slope_y) / fall
            if board.field.size > 2:
                i, j = field_part(page_x, page_y, board)
                fx -= board.field[i, j, 0]
                fy -= board.field[i, j, 1]
            tan_across, tan_along = turned(fx, fy, frame)
            return _lines_seen(k, across, along, tan_across, tan_along, depth, sheet, cells, board)
    return page_value(
        (page_y + board.half_y) * board.rows_per_mm, (page_x + board.half_x) * board.columns_per_mm, board
    )


@njit(inline="always")
def on_page(
    tx: float, ty: float, centre: Any, sheet: TracedSheet
) -> tuple[float, float, float, float, float, float, float]:
    """Where a sight line meets the page: x and y; the same along the bent page; how deep; its slopes along x and y.

    Source: the bend is shallow, so a few steps find the place.  A circle's arc is longer than its chord s by
        curvature^2 s^3 / 6, to fifth order.
    """
    x, y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    if sheet.curvature == 0.0 and sheet.twist == 0.0:
        return x, y, x, y, 0.0, 0.0, 0.0
    sunk = 0.0
    for _ in range(4):
        out = sheet.bent_x * x + sheet.bent_y * y
        sunk = 0.5 * sheet.curvature * out * out + sheet.twist * x * y
        x, y = centre[0] + (sunk - centre[2]) * tx, centre[1] + (sunk - centre[2]) * ty
    out = sheet.bent_x * x + sheet.bent_y * y
    longer = sheet.curvature * sheet.curvature * out * out * out / 6.0
    slope = sheet.curvature * out
    return (
        x,
        y,
        x + longer * sheet.bent_x,
        y + longer * sheet.bent_y,
        sunk,
        slope * sheet.bent_x + sheet.twist * y,
        slope * sheet.bent_y + sheet.twist * x,
    )


@njit(inline="always")
def _lines_seen(
    grating: int, across: float, along: float, tx: float, ty: float, depth: float, sheet: Any, cells: Any, board: Any
) -> float:
    """Radiance at a place of the sheet along the tangents, seen from `depth` in front; all as (across, along)."""
    frame = cells.frames[grating]
    offset, cosine, sine = frame[6], frame[7], frame[8]
    x, y = across * cosine + along * sine - offset, along * cosine - across * sine
    tan_x, tan_y = tx * cosine + ty * sine, ty * cosine - tx * sine
    air, aside = sheet.air, 0.0
    if board.waves.size > 1:
        # Where there is more air the lenses are higher, so the ray meets them before.
        air = max(air + smooth_at(board.waves[grating], x, y), 0.0)
        x, y = x - (air - sheet.air) * tan_x, y - (air - sheet.air) * tan_y
    if board.places.size > 1:
        number = math.floor(x / sheet.pitch + 0.5) + board.places.size // 2
        aside = board.places[min(max(number, 0), board.places.size - 1)]
    if board.asides.size > 1:
        aside += smooth_at(board.asides[grating], x, y)
    landed, ly, seen = land(x - aside, y, tan_x, tan_y, air, sheet)
    value: float = board.ink
    if not seen:
        return value
    lx = landed + aside + offset
    page_across, page_along = lx * cosine - ly * sine, ly * cosine + lx * sine
    page_across, page_along = page_across + frame[4] * page_along, page_along + frame[5] * page_across
    if not is_inked(np.float32(page_across), np.float32(page_along), grating, bins_of(grating, cells), cells):
        value = board.paper
    if board.lamps[grating, 9] > 0.0:
        # Across the lenses a ray covers its share of the pixel, widened by the slant.
        step = depth * (1.0 + tan_x * tan_x) * board.lamps[grating, 9]
        value = lit(value, x, y, tan_x, tan_y, landed, step, sheet, board.lamps[grating], board.lights[grating])
    return value


@njit(inline="always")
def half_footprint(centre: Any, turning: Any, sweep: Any) -> tuple[float, float]:
    """Half the width and height that a pixel covers on the page while it is exposed, mm, with a little to spare."""
    reach = 0.51 * abs(centre[2])
    half_x, half_y = reach * (abs(turning[0]) + abs(turning[2])), reach * (abs(turning[1]) + abs(turning[3]))
    half_x += abs(sweep[0]) / 2 + abs(sweep[1]) / 4 + abs(sweep[2]) / 8 + abs(sweep[3]) / 16
    return half_x, half_y + abs(sweep[4]) / 2 + abs(sweep[5]) / 4 + abs(sweep[6]) / 8 + abs(sweep[7]) / 16


@njit(inline="always")
def field_part(page_x: float, page_y: float, board: TracedBoard) -> tuple[int, int]:
    """Row and column of the forged field at a place of the page."""
    i = int((page_y / board.half_y + 1.0) * 0.5 * board.field.shape[0])
    j = int((page_x / board.half_x + 1.0) * 0.5 * board.field.shape[1])
    return min(i, board.field.shape[0] - 1), min(j, board.field.shape[1] - 1)


@njit(inline="always")
def page_value(row: float, column: float, board: TracedBoard) -> float:
    """Radiance of the page outside the gratings, at a place of its picture."""
    texture = board.texture
    value: float = texture[min(max(int(row), 0), texture.shape[0] - 1), min(max(int(column), 0), texture.shape[1] - 1)]
    return value
