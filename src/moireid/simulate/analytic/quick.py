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

from moireid.simulate.analytic.trace import TracedSheet, strip_at
from moireid.simulate.compiled import njit

F = np.float32


@njit(inline="always", error_model="numpy")
def grating_pixel(
    grating: int,
    across: float,
    along: float,
    steps: Any,
    tx: float,
    ty: float,
    depth: float,
    spread: float,
    points: Any,
    shift: Any,
    sheet: TracedSheet,
    cells: Any,
) -> int:  # pragma: no cover
    """Number of a pixel's rays that see ink; -1 where `trace` must do the pixel.

    Parameters: across, along: the pixel's middle on the lens plane; steps: how that place moves, across and along, for
    one pixel right, then for one pixel down; tx, ty: view tangents across and along; depth: from which they are seen,
    mm; spread: how far from the middle ray of a lens its others land at most, mm; points: (2, R) float32 places in a
    pixel, -1/2 to 1/2; shift: moves all of them right and down, px.
    """
    frame, pitch = cells.frames[grating], sheet.pitch
    offset, cosine, sine = frame[6], frame[7], frame[8]
    tan_x, tan_y = tx * cosine + ty * sine, ty * cosine - tx * sine
    if abs(tan_x) > sheet.steepest:
        return -1
    # The sheet's own frame, counted across from the axis of the lens that is nearest to the pixel's middle.
    x, y = across * cosine + along * sine - offset, along * cosine - across * sine
    axis = math.floor(x / pitch + 0.5) * pitch
    x += shift[0] * (steps[0] * cosine + steps[1] * sine) + shift[1] * (steps[2] * cosine + steps[3] * sine)
    move = (
        F(x - axis),
        F(steps[0] * cosine + steps[1] * sine),
        F(steps[2] * cosine + steps[3] * sine),
        F(steps[1] * cosine - steps[0] * sine),
        F(steps[3] * cosine - steps[2] * sine),
    )
    # The page's place on that axis, and the interval around the middle ray's landing that holds all landings.
    corner_x, corner_y = axis + offset, y
    # From the sheet's frame into the print's: turned by the twist, then sheared where the print is.
    to_page = (
        cosine + frame[4] * sine,
        frame[4] * cosine - sine,
        sine + frame[5] * cosine,
        cosine - frame[5] * sine,
    )
    page_x = corner_x * to_page[0] + corner_y * to_page[1]
    page_y = corner_x * to_page[2] + corner_y * to_page[3]
    # Through the top of a lens a ray goes as through a flat slab.
    across2 = tan_x * tan_x + tan_y * tan_y
    n2 = sheet.refraction * sheet.refraction
    inside2 = n2 * (1.0 + across2) - across2
    straight = sheet.gap / math.sqrt(inside2)
    # A ray 1 mm off the pixel's middle is a little more slanted, so it lands this much further.
    lean = straight * (1.0 - tan_x * tan_x * (n2 - 1.0) / inside2) / depth
    shift_x, shift_y = straight * tan_x, straight * tan_y
    middle_x = page_x + shift_x * to_page[0] + shift_y * to_page[1]
    middle_y = page_y + shift_x * to_page[2] + shift_y * to_page[3]
    room_x = (abs(steps[0]) + abs(steps[2])) / 2 + 1.1 * pitch + spread
    room_y = (abs(steps[1]) + abs(steps[3])) / 2 + (abs(sine) + abs(frame[5])) * pitch + spread
    bins_x, bins_y = cells.bins[grating, 0], cells.bins[grating, 1]
    left, top = strip_at(middle_x - room_x, bins_x, cells), strip_at(middle_y - room_y, bins_y, cells)
    right, bottom = strip_at(middle_x + room_x, bins_x, cells), strip_at(middle_y + room_y, bins_y, cells)
    if right > left + 1 or bottom > top + 1:
        return -1
    cut_x, cut_y = F(cells.cuts[left + int(bins_x[4])] - page_x), F(cells.cuts[top + int(bins_y[4])] - page_y)
    first = _lines(cells.grid[grating, top, left], page_x, cells)
    second, third, fourth = first, first, first
    if right > left or bottom > top:
        second = _lines(cells.grid[grating, top, right], page_x, cells)
        third = _lines(cells.grid[grating, bottom, left], page_x, cells)
        fourth = _lines(cells.grid[grating, bottom, right], page_x, cells)
    around = (first, second, third, fourth)
    turn = (F(to_page[0]), F(to_page[1]), F(to_page[2]), F(to_page[3]))
    if sheet.radius == 0.0:
        return _inked_behind_mask(points, move, F(shift_x), F(shift_y), F(lean), turn, cut_x, cut_y, around, sheet)
    return _inked_behind_lens(points, move, F(tan_x), F(tan_y), F(lean), turn, cut_x, cut_y, around, sheet)


@njit(inline="always", error_model="numpy")
def _lines(cell: int, page_x: float, cells: Any) -> tuple[Any, Any, Any]:  # pragma: no cover
    """Lines of a cell as seen from a place of the page: where in its pitch that place lies, lines per mm, duty."""
    if cell < 0:
        return F(0.0), F(0.0), F(0.0)
    place = (page_x - cells.lines[cell, 0]) * cells.lines[cell, 1]
    return F(place - math.floor(place)), F(cells.lines[cell, 1]), F(cells.lines[cell, 2])


@njit(error_model="numpy")
def _inked_behind_lens(
    points: Any,
    move: Any,
    tx: Any,
    ty: Any,
    lean: Any,
    turn: Any,
    cut_x: Any,
    cut_y: Any,
    around: Any,
    sheet: TracedSheet,
) -> int:  # pragma: no cover
    """Rays that see ink through lenses; see `grating_pixel`, whose inner loop this is."""
    half, one = F(0.5), F(1.0)
    pitch, per_pitch, gap, radius = F(sheet.pitch), F(1.0 / sheet.pitch), F(sheet.gap), F(sheet.radius)
    per_radius, per_n = F(1.0 / sheet.radius), F(1.0 / sheet.refraction)
    a = one + tx * tx
    per_length = one / np.sqrt(a + ty * ty)
    wx, wy, wz = tx * per_length * per_n, ty * per_length * per_n, per_length * per_n
    # How far a ray moves across while it falls from the lenses' tops to the valleys between them.
    fall = tx * F(sheet.sag)
    first, second, third, fourth = around
    inked = 0
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
        lx = axis + hit + (wx + bend * nx) * run + lean * (x - move[0])
        ly = y + ty * depth + wy * run
        px, py = lx * turn[0] + ly * turn[1], lx * turn[2] + ly * turn[3]
        inked += _inked(px, py, cut_x, cut_y, first, second, third, fourth)
    return inked


@njit(error_model="numpy")
def _inked_behind_mask(
    points: Any,
    move: Any,
    shift_x: Any,
    shift_y: Any,
    lean: Any,
    turn: Any,
    cut_x: Any,
    cut_y: Any,
    around: Any,
    sheet: TracedSheet,
) -> int:  # pragma: no cover
    """Rays that see ink through a line mask; the mask's own bars count as ink.  See `grating_pixel`."""
    per_pitch, half, open_half = F(1.0 / sheet.pitch), F(0.5), F(sheet.open_fraction / 2)
    first, second, third, fourth = around
    inked = 0
    for ray in range(points.shape[1]):
        x = move[0] + move[1] * points[0, ray] + move[2] * points[1, ray]
        y = move[3] * points[0, ray] + move[4] * points[1, ray]
        place = x * per_pitch
        shut = abs(place - np.floor(place + half)) > open_half
        lx, ly = x + shift_x + lean * (x - move[0]), y + shift_y
        px, py = lx * turn[0] + ly * turn[1], lx * turn[2] + ly * turn[3]
        inked += max(_inked(px, py, cut_x, cut_y, first, second, third, fourth), 1 if shut else 0)
    return inked


@njit(inline="always", error_model="numpy")
def _inked(
    px: Any, py: Any, cut_x: Any, cut_y: Any, first: Any, second: Any, third: Any, fourth: Any
) -> int:  # pragma: no cover
    """1 where a place of the page is ink: in one of the four cells that meet at the cuts."""
    left, top = px < cut_x, py < cut_y
    begin = (first[0] if left else second[0]) if top else (third[0] if left else fourth[0])
    per_mm = (first[1] if left else second[1]) if top else (third[1] if left else fourth[1])
    duty = (first[2] if left else second[2]) if top else (third[2] if left else fourth[2])
    place = begin + px * per_mm
    return 1 if place - np.floor(place) < duty else 0
