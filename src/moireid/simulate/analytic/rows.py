"""The loop over a frame's pixels: what each one sees, and which of the two tracers it needs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from moireid.simulate.analytic.quick import count_inked, land_rays, mixed_pixel, place_rays
from moireid.simulate.analytic.trace import (
    NO_SWEEP,
    FrameView,
    TracedBoard,
    careful_ray,
    half_footprint,
    moved,
    page_value,
    turned,
)
from moireid.simulate.analytic.traced_sheet import TracedSheet
from moireid.simulate.cameras import undistorted
from moireid.simulate.compiled import njit, prange

#: What a pixel is on: one grating alone, plain page alone, page and board's rim and at most one grating, more, or none.
GRATING, PAGE, MIXED, CAREFUL, OFF = 0, 1, 2, 3, 4
#: Multiples of the golden ratio fill a span more evenly than any other's; those of the plastic one and its square, with
#: them, a square.
GOLDEN, PLASTIC = (math.sqrt(5) - 1) / 2, 0.7548776662466927


@njit(cache=True, parallel=True)
def trace_rows(
    radiance: Any, coverage: Any, view: FrameView, sheet: TracedSheet, cells: Any, board: TracedBoard
) -> None:
    """Fill radiance (mean over the rays that meet the board) and coverage (their share), both (rows, columns)."""
    for row in prange(radiance.shape[0]):
        _row(row, radiance[row], coverage[row], view, sheet, cells, board)


@njit(inline="always")
def _row(
    row: int, radiance: Any, coverage: Any, view: FrameView, sheet: TracedSheet, cells: Any, board: TracedBoard
) -> None:
    """One row of `trace_rows`."""
    points, distortion = view.points, view.distortion
    per_focal, per_ray = 1.0 / view.focal, 1.0 / points.shape[1]
    bent = np.any(distortion != 0.0)
    centres, turns = view.centres[row], view.turns[row]
    centre, turn = centres[0], turns[0]
    landed, placed = np.empty((2, points.shape[1]), np.float32), np.empty((4, points.shape[1]), np.float32)
    # Rows that look through the same lenses would all have the same error, so each row moves its rays a little.
    shift_x = ((row + view.first_row) * GOLDEN % 1.0 - 0.5) * per_ray
    row_time = (row + view.first_row) * PLASTIC * PLASTIC
    for column in range(radiance.shape[0]):
        u, v = (column + view.corner_x) * per_focal, (row + view.corner_y) * per_focal
        place = column + view.first_column
        shift = (shift_x, (place * GOLDEN % 1.0 - 0.5) * per_ray, 0.0)
        # Slopes of the sight line, and how they change for a pixel right and for one down.
        right, down = (per_focal, 0.0), (0.0, per_focal)
        if bent:
            neighbours = undistorted(u + per_focal, v, distortion), undistorted(u, v + per_focal, distortion)
            u, v = undistorted(u, v, distortion)
            right, down = (neighbours[0][0] - u, neighbours[0][1] - v), (neighbours[1][0] - u, neighbours[1][1] - v)
        dz = turn[0, 2] * u + turn[1, 2] * v + turn[2, 2]
        if dz <= 1e-9:
            continue
        per_dz = 1.0 / dz
        tx = (turn[0, 0] * u + turn[1, 0] * v + turn[2, 0]) * per_dz
        ty = (turn[0, 1] * u + turn[1, 1] * v + turn[2, 1]) * per_dz
        # How the tangents change with the slopes, and from this pixel to the next, right and down.
        xu, xv = (turn[0, 0] - tx * turn[0, 2]) * per_dz, (turn[1, 0] - tx * turn[1, 2]) * per_dz
        yu, yv = (turn[0, 1] - ty * turn[0, 2]) * per_dz, (turn[1, 1] - ty * turn[1, 2]) * per_dz
        turning = (
            xu * right[0] + xv * right[1],
            yu * right[0] + yv * right[1],
            xu * down[0] + xv * down[1],
            yu * down[0] + yv * down[1],
        )
        sweep = NO_SWEEP
        if view.moving:
            sweep = _swept(u, v, tx, ty, centres, turns)
            # Pixels with the same times would all have the same error, too.
            shift = (shift[0], shift[1], ((place * PLASTIC + row_time) % 1.0 - 0.5) * per_ray)
        kind, grating = _kind(tx, ty, turning, sweep, centre, sheet, cells, board)
        if kind == OFF:
            continue
        if kind == PAGE:
            radiance[column] = _page_pixel(tx, ty, turning, sweep, centre, shift, points, board)
            coverage[column] = 1.0
            continue
        if kind != CAREFUL and view.quick:
            pixel = tx, ty, turning, sweep, shift
            ready = grating < 0 or land_rays(grating, pixel, centres, view, sheet, cells, board, landed)
            if ready and kind == GRATING:
                inked = count_inked(grating, landed, cells)
                radiance[column] = board.paper + inked * per_ray * (board.ink - board.paper)
                coverage[column] = 1.0
                continue
            if ready:
                place_rays(max(grating, 0), pixel, centre, view, sheet, cells, placed)
                total, count = mixed_pixel(grating, landed, placed, cells, board)
                if count > 0:
                    radiance[column] = total / count
                    coverage[column] = count * per_ray
                continue
        total, count = 0.0, 0
        for ray in range(points.shape[1]):
            u_ray = (column + view.corner_x + points[0, ray] + shift[0]) * per_focal
            v_ray = (row + view.corner_y + points[1, ray] + shift[1]) * per_focal
            if bent:
                u_ray, v_ray = undistorted(u_ray, v_ray, distortion)
            value = _careful_ray_at(points[2, ray] + shift[2], u_ray, v_ray, row, view, sheet, cells, board)
            if value >= 0.0:
                total += value
                count += 1
        if count > 0:
            radiance[column] = total / count
            coverage[column] = count * per_ray


@njit(inline="always")
def _careful_ray_at(
    time: float, u: float, v: float, row: int, view: FrameView, sheet: TracedSheet, cells: Any, board: TracedBoard
) -> float:
    """`careful_ray` of slopes (u, v) at a time of the exposure.

    Source: Lagrange's polynomials for the poses at `trace.TIMES`.
    """
    square = time * time
    rim, near = time * (square - 1 / 16) * 32 / 3, time * (square - 1 / 4) * -128 / 3
    weights = (
        (1 - 4 * square) * (1 - 16 * square),
        rim * (time - 1 / 2),
        rim * (time + 1 / 2),
        near * (time - 1 / 4),
        near * (time + 1 / 4),
    )
    x, y, z, value = 0.0, 0.0, 0.0, -1.0
    centre_x, centre_y, centre_z, shown_x, shown_y, shown_z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(weights) if view.moving else 1):
        weight = weights[k]
        x += weight * (view.turns[row, k, 0, 0] * u + view.turns[row, k, 1, 0] * v + view.turns[row, k, 2, 0])
        y += weight * (view.turns[row, k, 0, 1] * u + view.turns[row, k, 1, 1] * v + view.turns[row, k, 2, 1])
        z += weight * (view.turns[row, k, 0, 2] * u + view.turns[row, k, 1, 2] * v + view.turns[row, k, 2, 2])
        centre_x += weight * view.centres[row, k, 0]
        centre_y += weight * view.centres[row, k, 1]
        centre_z += weight * view.centres[row, k, 2]
        shown_x += weight * view.shown[k, 0]
        shown_y += weight * view.shown[k, 1]
        shown_z += weight * view.shown[k, 2]
    if z > 1e-9:
        centre, shown = (centre_x, centre_y, centre_z), (shown_x, shown_y, shown_z)
        value = careful_ray(x / z, y / z, centre, shown, sheet, cells, board)
    return value


@njit(inline="always")
def _swept(u: float, v: float, tx: float, ty: float, centres: Any, turns: Any) -> Any:
    """How a pixel of slopes (u, v), whose tangents are (tx, ty) at the middle, moves while it is exposed.

    Convention: `trace.NO_SWEEP`.
    """
    x, y = centres[0, 0] - centres[0, 2] * tx, centres[0, 1] - centres[0, 2] * ty
    bx, by, btx, bty = _place(1, u, v, centres, turns)
    ex, ey, etx, ety = _place(2, u, v, centres, turns)
    early_x, early_y, _, _ = _place(3, u, v, centres, turns)
    late_x, late_y, _, _ = _place(4, u, v, centres, turns)
    return (
        *_polynomial(x, bx, ex, early_x, late_x),
        *_polynomial(y, by, ey, early_y, late_y),
        etx - btx,
        2.0 * (btx + etx - 2.0 * tx),
        ety - bty,
        2.0 * (bty + ety - 2.0 * ty),
    )


@njit(inline="always")
def _polynomial(
    middle: float, begin: float, end: float, early: float, late: float
) -> tuple[float, float, float, float]:
    """a, b, c and d of `trace.NO_SWEEP` through the values at `trace.TIMES`."""
    odd, odd_near = (end - begin) / 2, (late - early) / 2
    even, even_near = (end + begin) / 2 - middle, (late + early) / 2 - middle
    c, d = (odd - 2 * odd_near) * 32 / 3, (even - 4 * even_near) * 64 / 3
    return 2 * odd - c / 4, 4 * even - d / 4, c, d


@njit(inline="always")
def _place(k: int, u: float, v: float, centres: Any, turns: Any) -> tuple[float, float, float, float]:
    """Where the sight line of slopes (u, v) from pose k meets the page, x and y, and its tangents."""
    per_dz = 1.0 / max(turns[k, 0, 2] * u + turns[k, 1, 2] * v + turns[k, 2, 2], 1e-9)
    tx = (turns[k, 0, 0] * u + turns[k, 1, 0] * v + turns[k, 2, 0]) * per_dz
    ty = (turns[k, 0, 1] * u + turns[k, 1, 1] * v + turns[k, 2, 1]) * per_dz
    return centres[k, 0] - centres[k, 2] * tx, centres[k, 1] - centres[k, 2] * ty, tx, ty


@njit(inline="always")
def _kind(
    tx: float, ty: float, turning: Any, sweep: Any, centre: Any, sheet: TracedSheet, cells: Any, board: TracedBoard
) -> tuple[int, int]:
    """What a pixel is on while it is exposed, and the number of its grating, -1 for none."""
    if sheet.curvature != 0.0 or sheet.twist != 0.0:
        return CAREFUL, -1
    x, y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    half_x, half_y = half_footprint(centre, turning, sweep)
    hidden = board.hidden
    if x + half_x >= hidden[0] and x - half_x < hidden[2] and y + half_y >= hidden[1] and y - half_y < hidden[3]:
        return CAREFUL, -1
    if abs(x) - half_x > board.half_x or abs(y) - half_y > board.half_y:
        return OFF, -1
    rim = abs(x) + half_x > board.half_x or abs(y) + half_y > board.half_y
    x, y = x - sheet.height * tx, y - sheet.height * ty
    touched = -1
    for k in range(cells.gratings.shape[0]):
        low, top, high, bottom = cells.gratings[k]
        frame = cells.frames[k]
        a, b = turned(x, y, frame)
        half_a = abs(frame[0]) * half_x + abs(frame[1]) * half_y
        half_b = abs(frame[2]) * half_x + abs(frame[3]) * half_y
        if a - half_a > low and a + half_a < high and b - half_b > top and b + half_b < bottom and not rim:
            return GRATING, k
        if a + half_a >= low and a - half_a <= high and b + half_b >= top and b - half_b <= bottom:
            if touched >= 0:
                return CAREFUL, -1
            touched = k
    return (MIXED, touched) if rim or touched >= 0 else (PAGE, -1)


@njit(inline="always")
def _page_pixel(
    tx: float, ty: float, turning: Any, sweep: Any, centre: Any, shift: Any, points: Any, board: TracedBoard
) -> float:
    """Mean radiance of a pixel on plain page."""
    # In pixels of the page's picture, from its corner.
    column = (centre[0] - centre[2] * tx + board.half_x) * board.columns_per_mm
    row = (centre[1] - centre[2] * ty + board.half_y) * board.rows_per_mm
    # Nearly all of the page is even paper or ink; then the four blocks around the pixel have one value.
    half_x, half_y = half_footprint(centre, turning, sweep)
    half_c, half_r = half_x * board.columns_per_mm, half_y * board.rows_per_mm
    if max(half_c, half_r) * 2.0 < board.block:
        value = _even(column - half_c, row - half_r, board)
        right, below = _even(column + half_c, row - half_r, board), _even(column - half_c, row + half_r, board)
        if value == right and value == below and value == _even(column + half_c, row + half_r, board):
            return value
    across, down = -centre[2] * board.columns_per_mm, -centre[2] * board.rows_per_mm
    cu, ru, cv, rv = turning[0] * across, turning[1] * down, turning[2] * across, turning[3] * down
    total = 0.0
    for ray in range(points.shape[1]):
        x, y, time = points[0, ray], points[1, ray], points[2, ray] + shift[2]
        along_x = moved(time, sweep[0], sweep[1], sweep[2], sweep[3]) * board.columns_per_mm
        along_y = moved(time, sweep[4], sweep[5], sweep[6], sweep[7]) * board.rows_per_mm
        total += page_value(row + ru * x + rv * y + along_y, column + cu * x + cv * y + along_x, board)
    mean: float = total / points.shape[1]
    return mean


@njit(inline="always")
def _even(column: float, row: float, board: TracedBoard) -> float:
    """The one value of the page's picture around one of its pixels, NaN where it has several."""
    per_block = 1.0 / board.block
    value: float = board.even[
        min(int(row * per_block), board.even.shape[0] - 1), min(int(column * per_block), board.even.shape[1] - 1)
    ]
    return value
