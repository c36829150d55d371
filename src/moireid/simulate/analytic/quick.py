"""Many sight lines at a time, in float32: the pixels that lie wholly on a grating or wholly on plain page.

This is the fast half of the analytic renderer.  The loop that lands a pixel's rays has no branch and no table, so the
compiler runs eight or sixteen rays at once.  Float32 is enough because places count from the pixel's own lens, found in
float64 once for each pixel; on the page, some 100 mm wide, they are rounded by 1e-5 mm, 1e-4 rad of a line.

Three things are simplified.  All rays of a pixel are refracted like its middle one at the middle of the exposure, and
land aside in proportion to their place and to what their tangents change.  The pixel's footprint is a parallelogram,
which keeps its shape while it is exposed.  And it moves by a polynomial of the time (`trace.NO_SWEEP`).

Convention and source: as `trace`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from moireid.simulate.analytic.trace import (
    NO_SWEEP,
    FrameView,
    TracedBoard,
    bins_of,
    field_part,
    half_footprint,
    is_inked,
    moved,
    page_value,
    turned,
)
from moireid.simulate.analytic.traced_sheet import TracedSheet
from moireid.simulate.compiled import njit

F, INT, UINT = np.float32, np.int32, np.uint32


@njit(inline="always")
def land_rays(
    grating: int, pixel: Any, centres: Any, view: FrameView, sheet: Any, cells: Any, board: Any, landed: Any
) -> bool:
    """Fill landed (2, R) with the places of the print that a pixel's rays see; False where `trace` must do the pixel.

    Parameters: pixel: tangents of its middle; how they change for one pixel right (x, y), then for one pixel down;
    `trace.NO_SWEEP`; what moves all of its rays right and down, px, and in time; centres (5, 3): the camera's, mm.
    """
    tx, ty, turning, sweep, shift = pixel
    frame, pitch, fall = cells.frames[grating], sheet.pitch, -(centres[0, 2] + sheet.height)
    x, y = centres[0, 0] + fall * tx, centres[0, 1] + fall * ty
    even, field_x, field_y = _field_of_pixel(tx, ty, turning, sweep, centres[0], board)
    across, along = turned(x, y, frame)
    depth, shown_x, shown_y = _shown_along(0, x, y, centres, view, sheet)
    tx, ty = turned(shown_x - field_x, shown_y - field_y, frame)
    offset, cosine, sine = frame[6], frame[7], frame[8]
    tan_x, tan_y = tx * cosine + ty * sine, ty * cosine - tx * sine
    if not even or abs(tan_x) > sheet.steepest:
        return False
    # How the place on the lens plane moves, across and along, for one pixel right, then for one pixel down.
    right, down = (
        turned(fall * turning[0], fall * turning[1], frame),
        turned(fall * turning[2], fall * turning[3], frame),
    )
    # The sheet's own frame, counted across from the axis of the lens that is nearest to the pixel's middle.
    at_x, at_y = across * cosine + along * sine - offset, along * cosine - across * sine
    axis = math.floor(at_x / pitch + 0.5) * pitch
    steps = (
        right[0] * cosine + right[1] * sine,
        down[0] * cosine + down[1] * sine,
        right[1] * cosine - right[0] * sine,
        down[1] * cosine - down[0] * sine,
    )
    at_x += shift[0] * steps[0] + shift[1] * steps[1]
    # From the sheet's frame into the print's: turned by the twist, then sheared where the print is.
    turn = cosine + frame[4] * sine, frame[4] * cosine - sine, sine + frame[5] * cosine, cosine - frame[5] * sine
    page = F((axis + offset) * turn[0] + at_y * turn[1]), F((axis + offset) * turn[2] + at_y * turn[3])
    # Through the top of a lens a ray goes as through a flat slab.
    across2 = tan_x * tan_x + tan_y * tan_y
    n2 = sheet.refraction * sheet.refraction
    inside2 = n2 * (1.0 + across2) - across2
    straight = sheet.gap / math.sqrt(inside2)
    # A ray that is more slanted by 1 lands this much further; 1 mm off the pixel's middle it is so by 1 / depth.
    per_tangent = straight * (1.0 - tan_x * tan_x * (n2 - 1.0) / inside2)
    drift = NO_SWEEP
    if view.moving:
        drift = _drift(x, y, shown_x, shown_y, sweep, centres, view, sheet, frame, per_tangent)
    move = (F(at_x - axis), F(steps[0]), F(steps[1]), F(steps[2]), F(steps[3]))
    sweeps = (
        F(drift[0]),
        F(drift[1]),
        F(drift[2]),
        F(drift[3]),
        F(drift[4]),
        F(drift[5]),
        F(drift[6]),
        F(drift[7]),
        F(drift[8]),
        F(drift[9]),
    )
    to_page = F(turn[0]), F(turn[1]), F(turn[2]), F(turn[3])
    lean = F(per_tangent / depth)
    if sheet.radius == 0.0:
        shifts = F(straight * tan_x), F(straight * tan_y)
        _land_behind_mask(landed, view.points, move, sweeps, F(shift[2]), shifts, lean, page, to_page, sheet)
    else:
        _land_behind_lens(
            landed, view.points, move, sweeps, F(shift[2]), F(tan_x), F(tan_y), lean, page, to_page, sheet
        )
    return True


@njit(inline="always")
def _shown_along(
    k: int, x: float, y: float, centres: Any, view: FrameView, sheet: TracedSheet
) -> tuple[float, float, float]:
    """How far the lens plane is from the place from which pose k shows its place (x, y), and the tangents there."""
    depth = -(centres[k, 2] + view.shown[k, 2]) - sheet.height
    return depth, (x - centres[k, 0] - view.shown[k, 0]) / depth, (y - centres[k, 1] - view.shown[k, 1]) / depth


@njit(inline="always")
def _drift(
    x: float,
    y: float,
    tx: float,
    ty: float,
    sweep: Any,
    centres: Any,
    view: FrameView,
    sheet: TracedSheet,
    frame: Any,
    per_tangent: float,
) -> Any:
    """How a pixel's place on the lens plane moves while it is exposed, across and along, and where its rays land.

    Convention: as `trace.NO_SWEEP`, mm, across and along the lenses; in place of the tangents, how much further rays
        land across (a, b), and 0.
    """
    height = sheet.height
    ax, bx, cx, dx = sweep[0] - height * sweep[8], sweep[1] - height * sweep[9], sweep[2], sweep[3]
    ay, by, cy, dy = sweep[4] - height * sweep[10], sweep[5] - height * sweep[11], sweep[6], sweep[7]
    _, begin_x, begin_y = _shown_along(
        1, x + moved(-0.5, ax, bx, cx, dx), y + moved(-0.5, ay, by, cy, dy), centres, view, sheet
    )
    _, end_x, end_y = _shown_along(
        2, x + moved(0.5, ax, bx, cx, dx), y + moved(0.5, ay, by, cy, dy), centres, view, sheet
    )
    a, b = _across(ax, ay, frame), _across(bx, by, frame)
    c, d = _across(cx, cy, frame), _across(dx, dy, frame)
    slope = _across(end_x - begin_x, end_y - begin_y, frame)
    bow = _across(2.0 * (begin_x + end_x - 2.0 * tx), 2.0 * (begin_y + end_y - 2.0 * ty), frame)
    return (a[0], b[0], c[0], d[0], a[1], b[1], c[1], d[1], per_tangent * slope[0], per_tangent * bow[0], 0.0, 0.0)


@njit(inline="always")
def _across(x: float, y: float, frame: Any) -> tuple[float, float]:
    """A vector of the page across and along the lenses of the twisted sheet."""
    a, b = turned(x, y, frame)
    return a * frame[7] + b * frame[8], b * frame[7] - a * frame[8]


@njit(inline="always")
def _field_of_pixel(
    tx: float, ty: float, turning: Any, sweep: Any, centre: Any, board: TracedBoard
) -> tuple[bool, float, float]:
    """Whether all of a pixel lies in one part of the forged field; and that part's parallax."""
    if board.field.size <= 2:
        return True, 0.0, 0.0
    page_x, page_y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    half_x, half_y = half_footprint(centre, turning, sweep)
    i, j = field_part(page_x - half_x, page_y - half_y, board)
    below, beyond = field_part(page_x + half_x, page_y + half_y, board)
    for k in range(2):
        value = board.field[i, j, k]
        if value != board.field[i, beyond, k] or value != board.field[below, j, k]:
            return False, 0.0, 0.0
        if value != board.field[below, beyond, k]:
            return False, 0.0, 0.0
    return True, board.field[i, j, 0], board.field[i, j, 1]


@njit()
def _land_behind_lens(
    landed: Any,
    points: Any,
    move: Any,
    sweep: Any,
    late: Any,
    tx: Any,
    ty: Any,
    lean: Any,
    page: Any,
    turn: Any,
    sheet: TracedSheet,
) -> None:
    """Fill landed (2, R) with where a pixel's rays meet the page; see `land_rays`, whose inner loop this is."""
    half, one = F(0.5), F(1.0)
    pitch, per_pitch, gap, radius = F(sheet.pitch), F(1.0 / sheet.pitch), F(sheet.gap), F(sheet.radius)
    per_radius, per_n = F(1.0 / sheet.radius), F(1.0 / sheet.refraction)
    a = one + tx * tx
    per_length = one / np.sqrt(a + ty * ty)
    wx, wy, wz = tx * per_length * per_n, ty * per_length * per_n, per_length * per_n
    # How far a ray moves across while it falls from the lenses' tops to the valleys between them.
    fall = tx * F(sheet.sag)
    for ray in range(points.shape[1]):
        time = points[2, ray] + late
        aside = move[1] * points[0, ray] + move[2] * points[1, ray]
        x = move[0] + aside + moved(time, sweep[0], sweep[1], sweep[2], sweep[3])
        y = move[3] * points[0, ray] + move[4] * points[1, ray] + moved(time, sweep[4], sweep[5], sweep[6], sweep[7])
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
        further = lean * aside + (sweep[8] + sweep[9] * time) * time
        lx, ly = axis + hit + (wx + bend * nx) * run + further, y + ty * depth + wy * run
        landed[0, ray] = page[0] + (lx * turn[0] + ly * turn[1])
        landed[1, ray] = page[1] + (lx * turn[2] + ly * turn[3])


@njit()
def _land_behind_mask(
    landed: Any,
    points: Any,
    move: Any,
    sweep: Any,
    late: Any,
    shifts: Any,
    lean: Any,
    page: Any,
    turn: Any,
    sheet: TracedSheet,
) -> None:
    """As `_land_behind_lens`, through a line mask; NaN where a ray ends on one of the mask's own bars."""
    per_pitch, half, open_half = F(1.0 / sheet.pitch), F(0.5), F(sheet.open_fraction / 2)
    for ray in range(points.shape[1]):
        time = points[2, ray] + late
        aside = move[1] * points[0, ray] + move[2] * points[1, ray]
        x = move[0] + aside + moved(time, sweep[0], sweep[1], sweep[2], sweep[3])
        y = move[3] * points[0, ray] + move[4] * points[1, ray] + moved(time, sweep[4], sweep[5], sweep[6], sweep[7])
        place = x * per_pitch
        shut = abs(place - np.floor(place + half)) > open_half
        lx, ly = x + shifts[0] + lean * aside + (sweep[8] + sweep[9] * time) * time, y + shifts[1]
        landed[0, ray] = F(np.nan) if shut else page[0] + (lx * turn[0] + ly * turn[1])
        landed[1, ray] = page[1] + (lx * turn[2] + ly * turn[3])


@njit()
def count_inked(grating: int, landed: Any, cells: Any) -> int:
    """How many of a pixel's rays see ink; the bars of a mask count as ink."""
    inked, bins = 0, bins_of(grating, cells)
    for ray in range(landed.shape[1]):
        inked += 1 if is_inked(landed[0, ray], landed[1, ray], grating, bins, cells) else 0
    return inked


@njit(inline="always")
def place_rays(grating: int, pixel: Any, centre: Any, view: FrameView, sheet: Any, cells: Any, placed: Any) -> None:
    """Fill placed (4, R): where a pixel's rays meet the page, x and y, and a grating's lens plane, across and along.

    Parameters: as `land_rays`.
    """
    tx, ty, turning, sweep, shift = pixel
    away, height, frame = -centre[2], sheet.height, cells.frames[grating]
    starts = F(centre[0] + away * tx), F(centre[1] + away * ty), F(height * tx), F(height * ty)
    tilts = F(turning[0]), F(turning[1]), F(turning[2]), F(turning[3])
    places = (
        F(sweep[0]),
        F(sweep[1]),
        F(sweep[2]),
        F(sweep[3]),
        F(sweep[4]),
        F(sweep[5]),
        F(sweep[6]),
        F(sweep[7]),
    )
    tangents = F(height * sweep[8]), F(height * sweep[9]), F(height * sweep[10]), F(height * sweep[11])
    _place_rays(
        placed,
        view.points,
        starts,
        (F(away), F(height)),
        tilts,
        places,
        tangents,
        (F(shift[0]), F(shift[1]), F(shift[2])),
        (F(frame[0]), F(frame[1]), F(frame[2]), F(frame[3])),
    )


@njit()
def _place_rays(
    placed: Any,
    points: Any,
    start: Any,
    fall: Any,
    tilt: Any,
    sweep: Any,
    slope: Any,
    shift: Any,
    frame: Any,
) -> None:
    """The inner loop of `place_rays`."""
    for ray in range(points.shape[1]):
        right, down, time = points[0, ray] + shift[0], points[1, ray] + shift[1], points[2, ray] + shift[2]
        more_x, more_y = tilt[0] * right + tilt[2] * down, tilt[1] * right + tilt[3] * down
        x = start[0] + fall[0] * more_x + moved(time, sweep[0], sweep[1], sweep[2], sweep[3])
        y = start[1] + fall[0] * more_y + moved(time, sweep[4], sweep[5], sweep[6], sweep[7])
        lens_x = x - start[2] - fall[1] * more_x - (slope[0] + slope[1] * time) * time
        lens_y = y - start[3] - fall[1] * more_y - (slope[2] + slope[3] * time) * time
        placed[0, ray], placed[1, ray] = x, y
        placed[2, ray] = frame[0] * lens_x + frame[1] * lens_y
        placed[3, ray] = frame[2] * lens_x + frame[3] * lens_y


@njit(inline="always")
def mixed_pixel(grating: int, landed: Any, placed: Any, cells: Any, board: TracedBoard) -> tuple[float, int]:
    """Sum of the radiances of a pixel's rays that meet the board, and their number.

    Parameters: grating: -1 for none; landed, placed: of `land_rays` and `place_rays`.
    """
    total, count = 0.0, 0
    rect = cells.gratings[max(grating, 0)]
    bins = bins_of(max(grating, 0), cells)
    for ray in range(placed.shape[1]):
        x, y, across, along = placed[0, ray], placed[1, ray], placed[2, ray], placed[3, ray]
        if abs(x) > board.half_x or abs(y) > board.half_y:
            continue
        count += 1
        if grating >= 0 and rect[0] <= across <= rect[2] and rect[1] <= along <= rect[3]:
            total += board.ink if is_inked(landed[0, ray], landed[1, ray], grating, bins, cells) else board.paper
            continue
        total += page_value((y + board.half_y) * board.rows_per_mm, (x + board.half_x) * board.columns_per_mm, board)
    return total, count
