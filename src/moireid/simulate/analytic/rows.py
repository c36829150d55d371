"""The loop over a frame's pixels: what each one sees, and which of the two tracers it needs."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np

from moireid.simulate import cameras as camera
from moireid.simulate.analytic import light_kernels, quick, trace
from moireid.simulate.analytic.quick import grating_pixel
from moireid.simulate.analytic.trace import TracedBoard, TracedSheet, careful_ray, field_part, turned
from moireid.simulate.cameras import undistorted
from moireid.simulate.compiled import njit, prange

#: What a pixel is on, apart from a grating (its number): plain page, or a border.
PAGE, BORDER = -1, -2
#: Multiples of the golden ratio fill a span more evenly than any other's.
GOLDEN = (math.sqrt(5) - 1) / 2


def _compiled(stamps: tuple[int, ...]) -> Any:
    """The loop over rows in parallel, compiled anew when a file with a part of it has changed.

    Numba looks for changes in the outer function's own file only.  But it also compares the values that the function
    encloses; here these are the time stamps of the other files.
    """

    @njit(cache=True, parallel=True, error_model="numpy")
    def trace_rows(
        radiance: Any,
        coverage: Any,
        corner: tuple[float, float],
        first: tuple[int, int],
        focal: float,
        centres: Any,
        turns: Any,
        shown: Any,
        points: Any,
        spread: float,
        sheet: TracedSheet,
        cells: Any,
        board: TracedBoard,
        distortion: Any,
    ) -> int:  # pragma: no cover
        for row in prange(radiance.shape[0]):
            _row(
                row,
                radiance,
                coverage,
                corner,
                first,
                focal,
                centres,
                turns,
                shown,
                points,
                spread,
                sheet,
                cells,
                board,
                distortion,
            )
        return len(stamps)

    return trace_rows


@njit(inline="always", error_model="numpy")
def _row(
    row: int,
    radiance: Any,
    coverage: Any,
    corner: tuple[float, float],
    first: tuple[int, int],
    focal: float,
    centres: Any,
    turns: Any,
    shown: Any,
    points: Any,
    spread: float,
    sheet: TracedSheet,
    cells: Any,
    board: TracedBoard,
    distortion: Any,
) -> None:  # pragma: no cover
    """Fill one row of radiance (mean over the rays that meet the board) and of coverage (their share).

    Parameters: corner: the first pixel's middle, from the principal point; first: its number across and down, counted
    from the board's own corner, so that a pixel has the same rays in every crop; centres (rows, 3), turns (rows, 3, 3):
    the camera's place and its rotation board -> camera while each row was exposed; distortion: of `camera`; the others
    as in `quick` and `trace`.
    """
    per_focal, per_ray = 1.0 / focal, 1.0 / points.shape[1]
    bent = np.any(distortion != 0.0)
    centre, turn = centres[row], turns[row]
    # Rows that look through the same lenses would all have the same error, so each row moves its rays a little.
    shift_x = ((row + first[1]) * GOLDEN % 1.0 - 0.5) * per_ray
    for column in range(radiance.shape[1]):
        u, v = (column + corner[0]) * per_focal, (row + corner[1]) * per_focal
        shift = (shift_x, ((column + first[0]) * GOLDEN % 1.0 - 0.5) * per_ray)
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
            radiance[row, column] = _page_pixel(tx, ty, turning, centre, points, board)
            coverage[row, column] = 1.0
            continue
        if kind >= 0:
            inked = _grating_pixel(kind, tx, ty, turning, centre, shown, points, shift, spread, sheet, cells, board)
            if inked >= 0:
                share = inked * per_ray
                radiance[row, column] = board.paper + share * (board.ink - board.paper)
                coverage[row, column] = 1.0
                continue
        total, count = 0.0, 0
        for ray in range(points.shape[1]):
            u_ray = (column + corner[0] + points[0, ray] + shift[0]) * per_focal
            v_ray = (row + corner[1] + points[1, ray] + shift[1]) * per_focal
            if bent:
                u_ray, v_ray = undistorted(u_ray, v_ray, distortion)
            dz = turn[0, 2] * u_ray + turn[1, 2] * v_ray + turn[2, 2]
            if dz <= 1e-9:
                continue
            value = careful_ray(
                (turn[0, 0] * u_ray + turn[1, 0] * v_ray + turn[2, 0]) / dz,
                (turn[0, 1] * u_ray + turn[1, 1] * v_ray + turn[2, 1]) / dz,
                centre,
                shown,
                sheet,
                cells,
                board,
            )
            if value >= 0.0:
                total += value
                count += 1
        if count > 0:
            radiance[row, column] = total / count
            coverage[row, column] = count * per_ray


@njit(inline="always", error_model="numpy")
def _kind(tx: float, ty: float, turning: Any, centre: Any, sheet: TracedSheet, cells: Any, board: TracedBoard) -> int:
    """What a pixel is on: the number of a grating, PAGE or BORDER."""  # pragma: no cover
    x, y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
    half_x, half_y = _half_footprint(centre, turning)
    if sheet.curvature != 0.0:
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


@njit(inline="always", error_model="numpy")
def _half_footprint(centre: Any, turning: Any) -> tuple[float, float]:  # pragma: no cover
    """Half the width and height that a pixel covers on the page, mm, with a little to spare."""
    reach = 0.51 * abs(centre[2])
    return reach * (abs(turning[0]) + abs(turning[2])), reach * (abs(turning[1]) + abs(turning[3]))


@njit(inline="always", error_model="numpy")
def _grating_pixel(
    grating: int,
    tx: float,
    ty: float,
    turning: Any,
    centre: Any,
    shown: Any,
    points: Any,
    shift: Any,
    spread: float,
    sheet: TracedSheet,
    cells: Any,
    board: TracedBoard,
) -> int:  # pragma: no cover
    """Number of a grating pixel's rays that see ink by `quick`, -1 for a pixel that needs `trace`."""
    fall = -(centre[2] + sheet.height)
    x, y = centre[0] + fall * tx, centre[1] + fall * ty
    steps = (fall * turning[0], fall * turning[1], fall * turning[2], fall * turning[3])
    depth = fall - shown[2]
    fx, fy = (x - centre[0] - shown[0]) / depth, (y - centre[1] - shown[1]) / depth
    if board.field.size > 2:
        page_x, page_y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
        half_x, half_y = _half_footprint(centre, turning)
        i, j = field_part(page_x - half_x, page_y - half_y, board)
        below, right = field_part(page_x + half_x, page_y + half_y, board)
        for k in range(2):
            value = board.field[i, j, k]
            if value != board.field[i, right, k] or value != board.field[below, j, k]:
                return -1
            if value != board.field[below, right, k]:
                return -1
        fx -= board.field[i, j, 0]
        fy -= board.field[i, j, 1]
    frame = cells.frames[grating]
    across, along = turned(x, y, frame)
    tan_across, tan_along = turned(fx, fy, frame)
    one, other = turned(steps[0], steps[1], frame), turned(steps[2], steps[3], frame)
    steps = (one[0], one[1], other[0], other[1])
    return grating_pixel(
        grating, across, along, steps, tan_across, tan_along, depth, spread, points, shift, sheet, cells
    )


@njit(inline="always", error_model="numpy")
def _page_pixel(
    tx: float, ty: float, turning: Any, centre: Any, points: Any, board: TracedBoard
) -> float:  # pragma: no cover
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
        total += board.texture[
            min(max(int(row + ru * points[0, ray] + rv * points[1, ray]), 0), board.texture.shape[0] - 1),
            min(max(int(column + cu * points[0, ray] + cv * points[1, ray]), 0), board.texture.shape[1] - 1),
        ]
    mean: float = total / points.shape[1]
    return mean


@njit(inline="always", error_model="numpy")
def _even(column: float, row: float, board: TracedBoard) -> float:  # pragma: no cover
    """The one value of the page's picture around one of its pixels, NaN where it has several."""
    per_block = 1.0 / board.block
    value: float = board.even[
        min(int(row * per_block), board.even.shape[0] - 1), min(int(column * per_block), board.even.shape[1] - 1)
    ]
    return value


#: Fills radiance and coverage of a frame; parameters as `_row`.
trace_rows = _compiled(tuple(os.stat(str(part.__file__)).st_mtime_ns for part in (quick, trace, camera, light_kernels)))
