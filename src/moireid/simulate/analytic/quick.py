"""Many sight lines at a time, in float32: the pixels that lie wholly on a grating or wholly on plain page.

This is the fast half of the analytic renderer.  The loop over a pixel's rays has no branch and no table, so the
compiler runs eight or sixteen rays at once.  Float32 is enough because all numbers in the loop are small: places count
from the pixel's own lens, lines from the edge next to that lens; both origins are found in float64 once for each pixel.

Two things are simplified.  All rays of a pixel are refracted like its middle one, and land aside in proportion to
their place.  And the pixel's footprint is a parallelogram.

Convention and source: as `trace`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from moireid.simulate.analytic.trace import FrameView, TracedBoard, field_part, half_footprint, strip_at, turned
from moireid.simulate.analytic.traced_sheet import TracedSheet
from moireid.simulate.compiled import njit

F, INT, UINT = np.float32, np.int32, np.uint32


@njit(inline="always")
def grating_pixel(
    grating: int,
    tx: float,
    ty: float,
    turning: Any,
    centre: Any,
    shift: Any,
    view: FrameView,
    sheet: Any,
    cells: Any,
    board: Any,
    near: Any,
    landed: Any,
) -> int:
    """Number of a pixel's rays that see ink; -1 where `trace` must do the pixel.

    Parameters: tx, ty: tangents of the pixel's middle; turning: how they change for one pixel right (x, y), then for
    one pixel down; centre: the camera's, mm; shift: moves all of the pixel's rays right and down, px; near (4, N)
        and landed (2, R): room for the lines of the cells around and for where the rays land.
    """
    frame, pitch, fall = cells.frames[grating], sheet.pitch, -(centre[2] + sheet.height)
    x, y = centre[0] + fall * tx, centre[1] + fall * ty
    depth = fall - view.shown[2]
    even, field_x, field_y = _field_of_pixel(tx, ty, turning, centre, board)
    across, along = turned(x, y, frame)
    tx, ty = turned(
        (x - centre[0] - view.shown[0]) / depth - field_x, (y - centre[1] - view.shown[1]) / depth - field_y, frame
    )
    offset, cosine, sine = frame[6], frame[7], frame[8]
    tan_x, tan_y = tx * cosine + ty * sine, ty * cosine - tx * sine
    if not even or abs(tan_x) > sheet.steepest:
        return -1
    # How the place on the lens plane moves, across and along, for one pixel right, then for one pixel down.
    right, down = (
        turned(fall * turning[0], fall * turning[1], frame),
        turned(fall * turning[2], fall * turning[3], frame),
    )
    # The sheet's own frame, counted across from the axis of the lens that is nearest to the pixel's middle.
    x, y = across * cosine + along * sine - offset, along * cosine - across * sine
    axis = math.floor(x / pitch + 0.5) * pitch
    steps = (
        right[0] * cosine + right[1] * sine,
        down[0] * cosine + down[1] * sine,
        right[1] * cosine - right[0] * sine,
        down[1] * cosine - down[0] * sine,
    )
    x += shift[0] * steps[0] + shift[1] * steps[1]
    move = (F(x - axis), F(steps[0]), F(steps[1]), F(steps[2]), F(steps[3]))
    # From the sheet's frame into the print's: turned by the twist, then sheared where the print is.
    turn = cosine + frame[4] * sine, frame[4] * cosine - sine, sine + frame[5] * cosine, cosine - frame[5] * sine
    page_x, page_y = (axis + offset) * turn[0] + y * turn[1], (axis + offset) * turn[2] + y * turn[3]
    # Through the top of a lens a ray goes as through a flat slab.
    across2 = tan_x * tan_x + tan_y * tan_y
    n2 = sheet.refraction * sheet.refraction
    inside2 = n2 * (1.0 + across2) - across2
    straight = sheet.gap / math.sqrt(inside2)
    # A ray 1 mm off the pixel's middle is a little more slanted, so it lands this much further.
    lean = straight * (1.0 - tan_x * tan_x * (n2 - 1.0) / inside2) / depth
    shift_x, shift_y = straight * tan_x, straight * tan_y
    middle = page_x + shift_x * turn[0] + shift_y * turn[1], page_y + shift_x * turn[2] + shift_y * turn[3]
    room_x = (abs(right[0]) + abs(down[0])) / 2 + 1.1 * pitch + view.spread
    room_y = (abs(right[1]) + abs(down[1])) / 2 + (abs(sine) + abs(frame[5])) * pitch + view.spread
    around = _cells_around(grating, page_x, page_y, middle, room_x, room_y, cells, near)
    if not around[0]:
        return -1
    to_page = F(turn[0]), F(turn[1]), F(turn[2]), F(turn[3])
    if sheet.radius == 0.0:
        _land_behind_mask(landed, view.points, move, F(shift_x), F(shift_y), F(lean), to_page, sheet)
    else:
        _land_behind_lens(landed, view.points, move, F(tan_x), F(tan_y), F(lean), to_page, sheet)
    return _inked(landed, around, near)


@njit(inline="always")
def _field_of_pixel(tx: float, ty: float, turning: Any, centre: Any, board: TracedBoard) -> tuple[bool, float, float]:
    """Whether all of a pixel lies in one part of the forged field; and that part's parallax."""
    if board.field.size <= 2:
        return True, 0.0, 0.0
    page_x, page_y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    half_x, half_y = half_footprint(centre, turning)
    i, j = field_part(page_x - half_x, page_y - half_y, board)
    below, beyond = field_part(page_x + half_x, page_y + half_y, board)
    for k in range(2):
        value = board.field[i, j, k]
        if value != board.field[i, beyond, k] or value != board.field[below, j, k]:
            return False, 0.0, 0.0
        if value != board.field[below, beyond, k]:
            return False, 0.0, 0.0
    return True, board.field[i, j, 0], board.field[i, j, 1]


@njit(inline="always")
def _cells_around(
    grating: int, page_x: float, page_y: float, middle: Any, room_x: float, room_y: float, cells: Any, near: Any
) -> Any:
    """Whether the cells within `room` of `middle` fit `near`, which their lines are then written into, row by row; and
    how a place's cell is found: the first cut and strips to the millimetre across, then along; strips across, along.

    Convention: cuts and lines count from (page_x, page_y).
    Source: a place is in the strip floor((place - cut) / width) + 1, counted from the strip before the cut.  Of two
        strips any width gives the right one; more must be even.
    """
    cuts_x, cuts_y, widths = cells.cuts[grating, 0], cells.cuts[grating, 1], cells.widths[grating]
    left, top = strip_at(middle[0] - room_x, cuts_x), strip_at(middle[1] - room_y, cuts_y)
    right, bottom = strip_at(middle[0] + room_x, cuts_x), strip_at(middle[1] + room_y, cuts_y)
    across, along = right - left + 1, bottom - top + 1
    fit = (across <= 2 or widths[0] > 0.0) and (along <= 2 or widths[1] > 0.0) and across * along <= near.shape[1]
    if fit:
        for row in range(along):
            for column in range(across):
                own = _lines(cells.grid[grating, top + row, left + column], page_x, page_y, cells)
                for k in range(4):
                    near[k, row * across + column] = own[k]
    # Beyond the last cut is infinity, which a lone strip has no use for.
    cut_x, cut_y = F(cuts_x[left] - page_x if across > 1 else 0.0), F(cuts_y[top] - page_y if along > 1 else 0.0)
    per_x = F(1.0 / widths[0] if widths[0] > 0.0 else 1.0)
    per_y = F(1.0 / widths[1] if widths[1] > 0.0 else 1.0)
    return fit, cut_x, per_x, cut_y, per_y, INT(across), INT(along)


@njit(inline="always")
def _lines(cell: int, page_x: float, page_y: float, cells: Any) -> tuple[Any, Any, Any, Any]:
    """Lines of a cell as seen from a place of the page: where in its pitch that place is, lines per mm, duty, slant."""
    if cell < 0:
        return F(0.0), F(0.0), F(0.0), F(0.0)
    own = cells.lines[cell]
    place = (page_x - own[0]) * own[1] + page_y * own[3]
    return F(place - math.floor(place)), F(own[1]), F(own[2]), F(own[3])


@njit()
def _land_behind_lens(
    landed: Any, points: Any, move: Any, tx: Any, ty: Any, lean: Any, turn: Any, sheet: TracedSheet
) -> None:
    """Fill landed (2, R) with where a pixel's rays meet the page; see `grating_pixel`, whose inner loop this is."""
    half, one = F(0.5), F(1.0)
    pitch, per_pitch, gap, radius = F(sheet.pitch), F(1.0 / sheet.pitch), F(sheet.gap), F(sheet.radius)
    per_radius, per_n = F(1.0 / sheet.radius), F(1.0 / sheet.refraction)
    a = one + tx * tx
    per_length = one / np.sqrt(a + ty * ty)
    wx, wy, wz = tx * per_length * per_n, ty * per_length * per_n, per_length * per_n
    # How far a ray moves across while it falls from the lenses' tops to the valleys between them.
    fall = tx * F(sheet.sag)
    for ray in range(points.shape[1]):
        x = move[0] + move[1] * points[0, ray] + move[2] * points[1, ray]
        y = move[3] * points[0, ray] + move[4] * points[1, ray]
        axis = np.floor((x + fall) * per_pitch + half) * pitch
        offset = x - axis
        b = offset * tx - radius
        c = offset * offset
        depth = c / (np.sqrt(b * b - a * c) - b)
        hit = offset + tx * depth
        nx, nz = hit * per_radius, depth * per_radius - one
        cosine = -(tx * nx + nz) * per_length
        bend = cosine * per_n - np.sqrt(one - (one - cosine * cosine) * (per_n * per_n))
        run = (gap - depth) / (wz + bend * nz)
        lx, ly = axis + hit + (wx + bend * nx) * run + lean * (x - move[0]), y + ty * depth + wy * run
        landed[0, ray], landed[1, ray] = lx * turn[0] + ly * turn[1], lx * turn[2] + ly * turn[3]


@njit()
def _land_behind_mask(
    landed: Any, points: Any, move: Any, shift_x: Any, shift_y: Any, lean: Any, turn: Any, sheet: TracedSheet
) -> None:
    """As `_land_behind_lens`, through a line mask; NaN where a ray ends on one of the mask's own bars."""
    per_pitch, half, open_half = F(1.0 / sheet.pitch), F(0.5), F(sheet.open_fraction / 2)
    for ray in range(points.shape[1]):
        x = move[0] + move[1] * points[0, ray] + move[2] * points[1, ray]
        y = move[3] * points[0, ray] + move[4] * points[1, ray]
        place = x * per_pitch
        shut = abs(place - np.floor(place + half)) > open_half
        lx, ly = x + shift_x + lean * (x - move[0]), y + shift_y
        landed[0, ray] = F(np.nan) if shut else lx * turn[0] + ly * turn[1]
        landed[1, ray] = lx * turn[2] + ly * turn[3]


@njit()
def _inked(landed: Any, around: Any, near: Any) -> int:
    """How many of a pixel's rays see ink; the bars of a mask count as ink."""
    _, cut_x, per_x, cut_y, per_y, across, along = around
    inked = 0
    for ray in range(landed.shape[1]):
        x, y = landed[0, ray], landed[1, ray]
        if math.isnan(x):
            inked += 1
            continue
        column = min(max(INT(np.floor((x - cut_x) * per_x)) + INT(1), INT(0)), across - INT(1))
        row = min(max(INT(np.floor((y - cut_y) * per_y)) + INT(1), INT(0)), along - INT(1))
        cell = UINT(row * across + column)
        place = near[0, cell] + x * near[1, cell] + y * near[3, cell]
        inked += 1 if place - np.floor(place) < near[2, cell] else 0
    return inked
