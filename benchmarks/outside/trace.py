"""One frame in linear light: rays of each pixel of the badge to the lens, through it, and to the print.

Convention: frames as in the package's docstring.  Knots of poses lie evenly over a frame's time; a sample has a moment
of its own within its row's exposure, and takes the pose between two knots.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtri

from outside.bend import in_space, onto_plane, plane_under, slopes_on
from outside.lens import through_cylinder, through_cylinders

#: Samples of a pixel on a sheet, of one that shows less than `NEAR` of a lens, and of one on plain paper.
LENS_SAMPLES, NEAR_SAMPLES, NEAR, PAPER_SAMPLES = 12, 8, 0.7, 12
#: Light of the room that surfaces mirror, over that of white card.
ROOM = 0.5
#: Irrational steps of a sequence that fills squares and times evenly (Roberts' R sequences, three dimensions).
R1, R2, R3 = 0.8191725133961645, 0.6710436067037893, 0.5497004779019703
#: Sets of samples, of which each pixel takes one by chance.
PATTERNS = 1024


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _lookup(raster, x, y):
    """Brightness between pixels, 0 to 255; x, y: pixel places, whose corner is (0, 0)."""
    x -= 0.5
    y -= 0.5
    x = min(max(x, 0.0), raster.shape[1] - 1.001)
    y = min(max(y, 0.0), raster.shape[0] - 1.001)
    i, j = int(x), int(y)
    a, b = x - i, y - j
    top = raster[j, i] + a * (np.float64(raster[j, i + 1]) - raster[j, i])
    low = raster[j + 1, i] + a * (np.float64(raster[j + 1, i + 1]) - raster[j + 1, i])
    return top + b * (low - top)


def offsets(count: int, blur_px: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """`PATTERNS` sets of samples, (P, 3, count): places about a pixel's centre in px, moments in an exposure, 0 to 1.

    A pixel's square and the optics' blur are one bell about its centre; each set fills it evenly, shifted by chance.
    """
    steps = (np.arange(count)[:, None] + 0.5) * np.array([R1, R2, R3])
    even = (rng.random((PATTERNS, 1, 3)) + steps) % 1.0
    even[..., :2] = blur_px * ndtri(np.clip(even[..., :2], 1e-3, 1 - 1e-3))
    return np.ascontiguousarray(even.transpose(0, 2, 1).astype(np.float32))


@njit(cache=True, fastmath=True, error_model="numpy")
def seen_through(x, y, ex, ey, sheets, k, lens, raster, size):
    """Light from the sheet at (x, y) of its crown plane, along a ray of slopes ex = dx/dz, ey = dy/dz.

    lens: of `Lens.figures`; raster: the page, transposed, as rays through one lens land along its lines;
    size: pixels in a built mm along x and y, and the board's half size.
    """
    c, s = sheets[k, 2], sheets[k, 3]
    dx, dy = x - sheets[k, 0], y - sheets[k, 1]
    across, along = dx * c + dy * s, dy * c - dx * s
    ds, dt = ex * c + ey * s, ey * c - ex * s
    across, off, share = through_cylinder(
        across, ds, dt, sheets[k, 6], sheets[k, 7], lens[2], lens[0], lens[1], lens[3], lens[4]
    )
    along += off
    x, y = sheets[k, 0] + across * c - along * s, sheets[k, 1] + across * s + along * c
    return share * _lookup(raster, (y + size[3]) * size[1], (x + size[2]) * size[0]) / 255.0 + (1.0 - share) * ROOM


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _sheet_at(x, y, sheets, spare):
    """Which sheet covers the place, -1 if none; spare: mm around it that count as covered."""
    for k in range(sheets.shape[0]):
        dx, dy = x - sheets[k, 0], y - sheets[k, 1]
        across = dx * sheets[k, 2] + dy * sheets[k, 3]
        along = dy * sheets[k, 2] - dx * sheets[k, 3]
        if abs(across) < sheets[k, 4] + spare and abs(along) < sheets[k, 5] + spare:
            return k
    return -1


@njit(cache=True, fastmath=True, error_model="numpy")
def trace(
    light, box, rays, camera, places, turns, sheets, lens, fine, coarse, size, sets, eyes, lie, patches, seed, bend, air
):  # fmt: skip
    """Draw the badge into `light`, within `box` (left, top, right, bottom).

    camera: focal px, knots in a row's exposure, knots to the last row; places, turns: (K, 3), (K, 3, 3); fine, coarse:
    the page, the fine one transposed; size: pixels in a built mm along x and y of the fine one, and the built board's
    half size; sets: samples of a pixel on a sheet and on paper, of `offsets`; eyes: (K, 3), from where the lens region
    is pictured in a forgery; lie: on, then rows of amplitude, k_x, k_y, phase; patches: where it is true; bend: of
    `Bend.figures`; air: a map of the air beneath the sheets, mm, or nothing.
    """
    focal, height, last = camera[0], light.shape[0], places.shape[0] - 1.0
    half_x, half_y = size[2], size[3]
    lens_set, paper_set = sets
    a, b, work = np.empty(12), np.empty(12), np.empty((7, max(lens_set.shape[2], paper_set.shape[2])))
    x, y, ex, ey = work[0], work[1], work[2], work[3]
    lens = lens.copy()
    state = np.uint32(seed * 7919 + 1)
    for row in range(box[1], box[3]):
        # Poses at the begin and the end of the row's exposure give each pixel's ray and its change.
        at = camera[2] * row / height
        _pose(places, turns, at, a)
        _pose(places, turns, min(at + camera[1], last), b)
        b -= a
        for column in range(box[0], box[2]):
            state = np.uint32(state * np.uint32(1664525) + np.uint32(1013904223))
            rx, ry = rays[row, column, 0], rays[row, column, 1]
            hx, hy, wide = _footprint(rx, ry, a, b, focal)
            if len(bend) > 0:
                plane = plane_under(hx, hy, (hx - a[0]) / -a[2], (hy - a[1]) / -a[2], bend)
                hx, hy = plane[6], plane[7]
            if abs(hx) > half_x + wide or abs(hy) > half_y + wide:
                continue
            # A ray at an angle meets the crowns, which are in front of the page, elsewhere.
            covered = _sheet_at(hx, hy, sheets, wide + lens[0])
            chosen = lens_set if covered >= 0 else paper_set
            above = lens[0] if covered >= 0 else 0.0
            pattern = int(state >> np.uint32(22)) % PATTERNS
            _spread(rx, ry, chosen[pattern], a, b, focal, above, x, y, ex, ey)
            count = chosen.shape[2]
            if len(bend) > 0:
                for k in range(count):
                    x[k], y[k], ex[k], ey[k] = onto_plane(x[k], y[k], ex[k], ey[k], above, bend, plane)
            if len(air) > 0:
                at_x, at_y = (hx / half_x + 1.0) / 2.0 * air.shape[1], (hy / half_y + 1.0) / 2.0 * air.shape[0]
                lens[3] = _lookup(air, at_x, at_y)
            if lie[0, 0] > 0 and covered >= 0:
                for k in range(count):
                    if _sheet_at(x[k], y[k], sheets, 0.0) >= 0:
                        place = x[k], y[k], ex[k], ey[k], lens[0]
                        ex[k], ey[k] = _false_slopes(*place, eyes, at, lie, patches, size, bend)
            if covered >= 0 and _sheet_at(hx, hy, sheets, -wide - lens[0]) == covered:
                total = _seen_through_all(count, work, sheets, covered, lens, fine, size)
            else:
                total = _seen(count, work, covered, above, sheets, lens, fine, coarse, size, light[row, column])
            light[row, column] = total / count


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _footprint(rx, ry, a, b, focal):
    """Where the ray of tangents (rx, ry) meets the page, and how far about it the pixel sees, mm.

    a: place and rows of the turn, (12,); b: how much they change during the exposure.
    """
    dx, dy, dz = a[3] * rx + a[4] * ry + a[5], a[6] * rx + a[7] * ry + a[8], a[9] * rx + a[10] * ry + a[11]
    vx, vy, vz = b[3] * rx + b[4] * ry + b[5], b[6] * rx + b[7] * ry + b[8], b[9] * rx + b[10] * ry + b[11]
    far = -a[2] / dz
    hx, hy = a[0] + far * dx, a[1] + far * dy
    moved = abs(b[0] + far * vx) + abs(b[1] + far * vy) + abs(hx * vz) + abs(hy * vz)
    return hx, hy, 3.0 * far / focal + moved


@njit(cache=True, fastmath=True, error_model="numpy")
def _spread(rx, ry, chosen, a, b, focal, above, x, y, ex, ey):
    """Slopes of a pixel's samples, and where they meet the plane `above` the page, into x to ey."""
    dx, dy, dz = a[3] * rx + a[4] * ry + a[5], a[6] * rx + a[7] * ry + a[8], a[9] * rx + a[10] * ry + a[11]
    vx, vy, vz = b[3] * rx + b[4] * ry + b[5], b[6] * rx + b[7] * ry + b[8], b[9] * rx + b[10] * ry + b[11]
    jx, jy, tau = chosen[0], chosen[1], chosen[2]
    for k in range(chosen.shape[1]):
        ju, jv = jx[k] / focal, jy[k] / focal
        inverse = 1.0 / (dz + tau[k] * vz + ju * a[9] + jv * a[10])
        ex[k] = (dx + tau[k] * vx + ju * a[3] + jv * a[4]) * inverse
        ey[k] = (dy + tau[k] * vy + ju * a[6] + jv * a[7]) * inverse
        depth = -above - a[2] - tau[k] * b[2]
        x[k] = a[0] + tau[k] * b[0] + depth * ex[k]
        y[k] = a[1] + tau[k] * b[1] + depth * ey[k]


@njit(cache=True, fastmath=True, error_model="numpy")
def _pose(places, turns, at, out):
    """The pose at a moment in knots: place, then the rows of the turn, into `out` (12,)."""
    k = min(int(at), places.shape[0] - 2)
    w = at - k
    for i in range(3):
        out[i] = (1.0 - w) * places[k, i] + w * places[k + 1, i]
        for j in range(3):
            out[3 + 3 * i + j] = (1.0 - w) * turns[k, i, j] + w * turns[k + 1, i, j]


@njit(cache=True, fastmath=True, error_model="numpy")
def _seen(count, work, covered, above, sheets, lens, fine, coarse, size, behind):
    """The sum over samples on a sheet, on paper or outside the badge, where they see what is behind."""
    x, y, ex, ey = work[0], work[1], work[2], work[3]
    half_x, half_y = size[2], size[3]
    fx, fy = size[0] * coarse.shape[1] / fine.shape[0], size[1] * coarse.shape[0] / fine.shape[1]
    total = 0.0
    for k in range(count):
        found = _sheet_at(x[k], y[k], sheets, 0.0) if covered >= 0 else -1
        if found >= 0:
            total += seen_through(x[k], y[k], ex[k], ey[k], sheets, found, lens, fine, size)
            continue
        px, py = x[k] + above * ex[k], y[k] + above * ey[k]
        if abs(px) > half_x or abs(py) > half_y:
            total += behind
        else:
            total += _lookup(coarse, (px + half_x) * fx, (py + half_y) * fy) / 255.0
    return total


@njit(cache=True, fastmath=True, error_model="numpy")
def _seen_through_all(count, work, sheets, k, lens, raster, size):
    """The sum of `seen_through` over samples that all lie on one sheet of cylinders; `work` is spent."""
    x, y, ex, ey, s, t, share = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    cosine, sine, cx, cy = sheets[k, 2], sheets[k, 3], sheets[k, 0], sheets[k, 1]
    for i in range(count):
        u, v = x[i] - cx, y[i] - cy
        s[i], t[i] = u * cosine + v * sine, v * cosine - u * sine
        u, v = ex[i], ey[i]
        ex[i], ey[i] = u * cosine + v * sine, v * cosine - u * sine
    edge, pitch, radius = sheets[k, 6], sheets[k, 7], lens[2]
    if lens[4] == 0.0:
        through_cylinders(count, s, t, ex, ey, share, edge, pitch, radius, lens[0], lens[1], lens[3])
    else:
        through_cylinders(count, s, t, ex, ey, share, edge, pitch, radius, lens[0], lens[1], lens[3], lens[4])
    total = 0.0
    for i in range(count):
        px = (cx + s[i] * cosine - t[i] * sine + size[2]) * size[0]
        py = (cy + s[i] * sine + t[i] * cosine + size[3]) * size[1]
        total += share[i] * _lookup(raster, py, px) / 255.0 + (1.0 - share[i]) * ROOM
    return total


@njit(cache=True, fastmath=True, error_model="numpy")
def _false_slopes(x, y, ex, ey, thickness, eyes, at, lie, patches, size, bend):
    """Slopes of the ray by which a forger's picture shows the place (x, y) of the crowns."""
    half_x, half_y = size[2], size[3]
    j = min(max(int((x + half_x) / (2 * half_x) * patches.shape[1]), 0), patches.shape[1] - 1)
    i = min(max(int((y + half_y) / (2 * half_y) * patches.shape[0]), 0), patches.shape[0] - 1)
    if patches[i, j]:
        return ex, ey
    k = min(int(at), eyes.shape[0] - 2)
    w = at - k
    cx = (1 - w) * eyes[k, 0] + w * eyes[k + 1, 0]
    cy = (1 - w) * eyes[k, 1] + w * eyes[k + 1, 1]
    cz = (1 - w) * eyes[k, 2] + w * eyes[k + 1, 2]
    if len(bend) > 0:
        plane, there = in_space(x, y, thickness, bend)
        deep = there[2] - cz
        ex, ey = slopes_on(plane, (there[0] - cx) / deep, (there[1] - cy) / deep, bend)
    else:
        depth = -thickness - cz
        ex, ey = (x - cx) / depth, (y - cy) / depth
    for n in range(1, lie.shape[0]):
        ex += lie[n, 0] * math.sin(lie[n, 1] * x + lie[n, 2] * y + lie[n, 3])
    return ex, ey
