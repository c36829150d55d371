"""The loop over a frame's pixels: what each one sees, and which of the two tracers it needs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from moireid.simulate.analytic.quick import grating_pixel
from moireid.simulate.analytic.trace import FrameView, TracedBoard, careful_ray, half_footprint, page_value, turned
from moireid.simulate.analytic.traced_sheet import TracedSheet
from moireid.simulate.cameras import undistorted
from moireid.simulate.compiled import njit, prange

#: What a pixel is on, apart from a grating (its number): plain page, or a border.
PAGE, BORDER = -1, -2
#: Cells that the rays of one pixel may meet.
MOST_CELLS = 64
#: Multiples of the golden ratio fill a span more evenly than any other's.
GOLDEN = (math.sqrt(5) - 1) / 2


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
    centre, turn = view.centres[row], view.turns[row]
    near, landed = np.empty((4, MOST_CELLS), np.float32), np.empty((2, points.shape[1]), np.float32)
    # Rows that look through the same lenses would all have the same error, so each row moves its rays a little.
    shift_x = ((row + view.first_row) * GOLDEN % 1.0 - 0.5) * per_ray
    for column in range(radiance.shape[0]):
        u, v = (column + view.corner_x) * per_focal, (row + view.corner_y) * per_focal
        shift = (shift_x, ((column + view.first_column) * GOLDEN % 1.0 - 0.5) * per_ray)
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
        kind = _kind(tx, ty, turning, centre, sheet, cells, board)
        if kind == PAGE:
            radiance[column] = _page_pixel(tx, ty, turning, centre, points, board)
            coverage[column] = 1.0
            continue
        if kind >= 0 and view.spread < math.inf:
            inked = grating_pixel(kind, tx, ty, turning, centre, shift, view, sheet, cells, board, near, landed)
            if inked >= 0:
                radiance[column] = board.paper + inked * per_ray * (board.ink - board.paper)
                coverage[column] = 1.0
                continue
        total, count = 0.0, 0
        for ray in range(points.shape[1]):
            u_ray = (column + view.corner_x + points[0, ray] + shift[0]) * per_focal
            v_ray = (row + view.corner_y + points[1, ray] + shift[1]) * per_focal
            if bent:
                u_ray, v_ray = undistorted(u_ray, v_ray, distortion)
            dz = turn[0, 2] * u_ray + turn[1, 2] * v_ray + turn[2, 2]
            if dz <= 1e-9:
                continue
            x, y = (
                turn[0, 0] * u_ray + turn[1, 0] * v_ray + turn[2, 0],
                turn[0, 1] * u_ray + turn[1, 1] * v_ray + turn[2, 1],
            )
            value = careful_ray(x / dz, y / dz, centre, view, sheet, cells, board)
            if value >= 0.0:
                total += value
                count += 1
        if count > 0:
            radiance[column] = total / count
            coverage[column] = count * per_ray


@njit(inline="always")
def _kind(tx: float, ty: float, turning: Any, centre: Any, sheet: TracedSheet, cells: Any, board: TracedBoard) -> int:
    """What a pixel is on: the number of a grating, PAGE or BORDER."""
    x, y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    half_x, half_y = half_footprint(centre, turning)
    if sheet.curvature != 0.0 or sheet.twist != 0.0:
        return BORDER
    if abs(x) + half_x > board.half_x or abs(y) + half_y > board.half_y:
        return BORDER
    hidden = board.hidden
    if x + half_x >= hidden[0] and x - half_x < hidden[2] and y + half_y >= hidden[1] and y - half_y < hidden[3]:
        return BORDER
    x, y = x - sheet.height * tx, y - sheet.height * ty
    for k in range(cells.gratings.shape[0]):
        low, top, high, bottom = cells.gratings[k]
        frame = cells.frames[k]
        a, b = turned(x, y, frame)
        half_a = abs(frame[0]) * half_x + abs(frame[1]) * half_y
        half_b = abs(frame[2]) * half_x + abs(frame[3]) * half_y
        if a - half_a > low and a + half_a < high and b - half_b > top and b + half_b < bottom:
            return k
        if a + half_a >= low and a - half_a <= high and b + half_b >= top and b - half_b <= bottom:
            return BORDER
    return PAGE


@njit(inline="always")
def _page_pixel(tx: float, ty: float, turning: Any, centre: Any, points: Any, board: TracedBoard) -> float:
    """Mean radiance of a pixel on plain page."""
    # In pixels of the page's picture, from its corner.
    column = (centre[0] - centre[2] * tx + board.half_x) * board.columns_per_mm
    row = (centre[1] - centre[2] * ty + board.half_y) * board.rows_per_mm
    across, down = -centre[2] * board.columns_per_mm, -centre[2] * board.rows_per_mm
    cu, ru, cv, rv = turning[0] * across, turning[1] * down, turning[2] * across, turning[3] * down
    # Nearly all of the page is even paper or ink; then the four blocks around the pixel have one value.
    half_c, half_r = 0.51 * (abs(cu) + abs(cv)), 0.51 * (abs(ru) + abs(rv))
    if max(half_c, half_r) * 2.0 < board.block:
        value = _even(column - half_c, row - half_r, board)
        right, below = _even(column + half_c, row - half_r, board), _even(column - half_c, row + half_r, board)
        if value == right and value == below and value == _even(column + half_c, row + half_r, board):
            return value
    total = 0.0
    for ray in range(points.shape[1]):
        x, y = points[0, ray], points[1, ray]
        total += page_value(row + ru * x + rv * y, column + cu * x + cv * y, board)
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
