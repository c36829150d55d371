"""An independent reference for the renderers: a plain tracer in NumPy float64 that shares no code with `simulate`.

It has no pixels, rows or tables.  A ray is a point and a unit vector in space; every cylinder lens near it is
intersected by the general formula for a cylinder about any axis, the nearest hit on a lens's own cap counts, Snell's
law is applied in vector form, and the ink under the ray is looked up by asking each printed cell in turn,
and where lines bend by their numbers.  Slow on purpose: about a million rays in a second or two.

Left out, as in the analytic renderer: Fresnel losses, the light's direction, and rays inside the sheet that leave it
through a neighbouring lens; `TracedRadiance.escaped` counts these rays and so shows where they matter.

Convention: board frame, mm, origin at the board's centre, x right, y down, z into the page; apexes at z = -g, page at
z = 0.  The sheet is turned about z from x towards y, the print is scaled along x and y about the origin.
Source: vector refraction as in any text on ray tracing, r = eta d + (eta c - sqrt(1 - eta^2 (1 - c^2))) n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.frames import own_rect
from moireid.layers import is_smooth
from moireid.smooth_lines import LineField

Array = NDArray[np.float64]
#: Sight lines of a pixel: a Fibonacci number, for which the golden lattice is even in both directions.
SAMPLES = 377
#: Rays traced at a time; it bounds the memory.
PIECE_RAYS = 400_000
_GOLDEN = (math.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class Setup:
    """What is where: the badge, how its sheet and print lie, and radiances of ink and paper."""

    badge: Badge
    lens_offset_mm: float = 0.0
    twist_rad: float = 0.0
    print_scales: tuple[float, float] = (1.0, 1.0)
    lens_scale: float = 1.0
    ink: float = 0.06
    paper: float = 0.85


@dataclass(frozen=True)
class TracedRadiance:
    """Radiance of the pixels (N,), NaN where any sight line misses the gratings; and the share of rays that would have
    left the sheet through another lens."""

    radiance: Array
    escaped: float


def trace_pixels(
    setup: Setup,
    camera_matrix: Array,
    camera_mm: Array,
    rotation: Array,
    columns: NDArray[np.intp],
    rows: NDArray[np.intp],
    *,
    samples: int = SAMPLES,
) -> TracedRadiance:
    """Trace some pixels of a picture, all of which must lie on a grating.

    Parameters: camera_matrix (3, 3) px, pixel centres are whole numbers; camera_mm (3,) the camera's centre; rotation
        (3, 3) board -> camera; columns, rows (N,): the pixels; samples: sight lines of each, spread over its area by a
        golden lattice.
    Convention: module docstring.  Source: module docstring.
    """
    place = np.stack([(np.arange(samples) + 0.5) / samples - 0.5, np.arange(samples) * _GOLDEN % 1.0 - 0.5])
    radiance, escaped = np.empty(len(columns)), 0.0
    step = max(1, PIECE_RAYS // samples)
    to_board = np.linalg.inv(np.asarray(camera_matrix) @ np.asarray(rotation))
    for begin in range(0, len(columns), step):
        pixels = slice(begin, begin + step)
        u, v = columns[pixels, None] + place[0], rows[pixels, None] + place[1]
        way = np.stack([u, v, np.ones_like(u)], axis=-1) @ to_board.T
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        seen, out = see(setup, np.asarray(camera_mm, float), way.reshape(-1, 3))
        radiance[pixels] = seen.reshape(u.shape).mean(axis=1)
        escaped += float(out.sum())
    return TracedRadiance(radiance, escaped / (len(columns) * samples))


def see(setup: Setup, origin: Array, way: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Radiance along rays from one origin, unit vectors (N, 3), NaN off the gratings; and which ones escape."""
    radiance, escaped = np.full(len(way), np.nan), np.zeros(len(way), bool)
    thickness = setup.badge.lens.thickness_mm
    with np.errstate(divide="ignore", invalid="ignore"):
        top = origin + way * ((-thickness - origin[2]) / way[:, 2])[:, None]
    x0, y0, x1, y1 = setup.badge.outline_mm
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    for grating in setup.badge.gratings:
        rect = np.array(own_rect(grating.axis, grating.rect_mm))
        place = setup.badge.frame_of(grating).places(top[:, :2] + middle)
        on = (way[:, 2] > 0) & np.all((place >= rect[:2]) & (place <= rect[2:]), axis=1)
        if not on.any():
            continue
        landed, out = _through_sheet(setup, grating, top[on], way[on])
        radiance[on] = _ink_or_paper(setup, grating, middle, landed)
        escaped[on] = out
    return radiance, escaped


def _through_sheet(setup: Setup, grating: Grating, top: Array, way: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Where rays land on the page, (N, 2) mm, NaN where something stops them; and which leave by another lens."""
    lens = setup.badge.lens
    (x, y), _ = setup.badge.frame_of(grating).rows
    turn = setup.twist_rad + math.atan2(y, x)
    across = np.array([math.cos(turn), math.sin(turn), 0.0])
    pitch = lens.pitch_mm * setup.lens_scale
    counted = top @ across - setup.lens_offset_mm
    if lens.kind == "mask":
        assert lens.open_fraction is not None
        normal = np.broadcast_to([0.0, 0.0, -1.0], way.shape)
        inside = refract(way, normal, lens.refractive_index)
        landed = top + inside * (-top[:, 2] / inside[:, 2])[:, None]
        shut = np.abs(counted / pitch - np.round(counted / pitch)) > lens.open_fraction / 2
        return np.where(shut[:, None], np.nan, landed[:, :2]), np.zeros(len(way), bool)
    assert lens.radius_mm is not None
    hit, normal = _first_cap(setup, across, top, way, counted)
    inside = refract(way, normal, lens.refractive_index)
    landed = hit + inside * (-hit[:, 2] / inside[:, 2])[:, None]
    return landed[:, :2], _escapes(setup, across, hit, inside)


def _first_cap(setup: Setup, across: Array, top: Array, way: Array, counted: Array) -> tuple[Array, Array]:
    """First point of each ray on any lens's cap (N, 3), NaN for none, and the outward normal there."""
    lens = setup.badge.lens
    pitch, radius = lens.pitch_mm * setup.lens_scale, float(lens.radius_mm or 0.0)
    along = np.cross([0.0, 0.0, 1.0], across)
    best = np.full(len(way), np.inf)
    normal = np.full(way.shape, np.nan)
    # While it falls by the caps' height, a ray may pass over this many lenses.
    sag = radius - math.sqrt(radius**2 - (pitch / 2) ** 2)
    passed = int(np.ceil(np.max(np.abs(way @ across) / way[:, 2]) * sag / pitch)) + 1
    for step in range(-passed, passed + 1):
        number = np.round(counted / pitch) + step
        middle = np.outer(number * pitch + setup.lens_offset_mm, across)
        middle[:, 2] = -lens.thickness_mm + radius
        # A cylinder about `along`: what counts of point and direction is the part square to it.
        away = top - middle
        away -= np.outer(away @ along, along)
        flat = way - np.outer(way @ along, along)
        a, b, c = (flat * flat).sum(1), (away * flat).sum(1), (away * away).sum(1) - radius**2
        with np.errstate(invalid="ignore"):
            root = np.sqrt(b * b - a * c)
        # The point may lie on the apex plane, and so on the cylinder: a hair before it still counts.
        t = (-b - root) / a
        out = (away + t[:, None] * flat) / radius
        cap = (np.abs(out @ across) * radius <= pitch / 2 + 1e-9) & (out[:, 2] <= 0) & (t > -1e-9) & (t < best)
        best = np.where(cap, t, best)
        normal = np.where(cap[:, None], out, normal)
    return top + np.where(np.isfinite(best), best, np.nan)[:, None] * way, normal


def _escapes(setup: Setup, across: Array, hit: Array, inside: Array) -> NDArray[np.bool_]:
    """Rays inside the sheet that cross the plane of the valleys beyond the lens through which they came in."""
    lens = setup.badge.lens
    pitch, radius = lens.pitch_mm * setup.lens_scale, float(lens.radius_mm or 0.0)
    valley = -lens.thickness_mm + radius - math.sqrt(radius**2 - (pitch / 2) ** 2)
    own = np.round((hit @ across - setup.lens_offset_mm) / pitch)
    there = hit + inside * ((valley - hit[:, 2]) / inside[:, 2])[:, None]
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs((there @ across - setup.lens_offset_mm) - own * pitch) > pitch / 2 + 1e-9)


def refract(way: Array, normal: Array, index: float) -> Array:
    """Unit vectors (N, 3) after refraction from air into glass; normals point against the rays."""
    eta = 1.0 / index
    cosine = -(way * normal).sum(axis=1)
    return np.asarray(eta * way + (eta * cosine - np.sqrt(1.0 - eta**2 * (1.0 - cosine**2)))[:, None] * normal)


def _ink_or_paper(setup: Setup, grating: Grating, middle: Array, landed: Array) -> Array:
    """Radiance at places of the printed page (N, 2), board mm; what no ray reaches is dark."""
    page = landed / setup.print_scales + middle
    across, along = setup.badge.frame_of(grating).places(page).T
    radiance = np.where(np.isnan(across), setup.ink, setup.paper)
    if is_smooth(grating):
        low, top, high, bottom = own_rect(grating.axis, grating.rect_mm)
        within = (across >= low) & (across < high) & (along >= top) & (along < bottom)
        # By the definition itself; the renderers have tables of it.
        numbers = LineField(grating).numbers(across[within], along[within])
        radiance[within] = np.where(np.mod(numbers, 1.0) < grating.cells[0].duty, setup.ink, setup.paper)
        return radiance
    for cell in grating.cells:
        low, top, high, bottom = own_rect(grating.axis, cell.rect_mm)
        within = (across >= low) & (across < high) & (along >= top) & (along < bottom)
        lines = np.mod(across[within] - cell.edge_mm, cell.pitch_mm)
        radiance[within] = np.where(lines < cell.duty * cell.pitch_mm, setup.ink, setup.paper)
    return radiance
