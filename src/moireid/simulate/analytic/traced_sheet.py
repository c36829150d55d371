"""The lens sheet as built, and one ray through it.

Convention: the sheet's own frame, mm: x across the lenses from the axis of lens 0, y along them, z into the page; the
plane of the lenses' tops (apex plane) is z = 0, view tangents are dx/dz and dy/dz.
Source: circle intersection and Snell's law in three dimensions; the same physics as `moireid.lenticule`, written
again for one ray at a time because a compiled loop shares nothing with arrays.  No fast-math flag is set: what it would
allow moves rays that just miss.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from moireid.errors import SpecError
from moireid.simulate.compiled import njit
from moireid.simulate.scene import Scene

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


def sheet_as_built(scene: Scene) -> TracedSheet:
    """The sheet of a scene.  Raises: SpecError where its lenses do not meet."""
    lens, build = scene.lens, scene.build
    pitch, radius = lens.pitch_mm * build.lens_scale, lens.radius_mm or 0.0
    if radius and pitch > 2 * radius:
        raise SpecError(f"lens_scale={build.lens_scale:g} spreads the lenses beyond their diameter; give less")
    valley = math.sqrt(radius**2 - pitch**2 / 4) if radius else 0.0
    return TracedSheet(
        pitch,
        lens.thickness_mm,
        scene.height_mm,
        build.air_gap_mm,
        1e-3 / build.bow_radius_m,
        lens.refractive_index,
        radius,
        lens.open_fraction or 0.0,
        radius - valley,
        # A ray less slanted than the lens's flank is steeper than the surface everywhere.  So it meets the lens over
        # which it crosses the depth of the valleys.
        valley / (pitch / 2) if radius else math.inf,
    )


@njit()
def meet(x: float, tx: float, sheet: TracedSheet) -> tuple[float, float, float, bool]:
    """The lens that a ray through the apex plane at x meets: its axis, the place from it, the depth; False for none."""
    pitch, radius = sheet.pitch, sheet.radius
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
                return axis, hit, depth, True
        axis += way * pitch
    return 0.0, 0.0, 0.0, False


@njit()
def through(
    x: float, y: float, depth: float, tx: float, ty: float, nx: float, ny: float, sheet: TracedSheet
) -> tuple[float, float, bool]:
    """Where a ray lands that meets a lens's surface at (x, y), `depth` under its top; False where the back keeps it.

    nx, ny: how far that point is from the lens's axis, in radii; a cylinder has ny = 0.
    """
    n, nz = sheet.refraction, (depth - sheet.radius) / sheet.radius
    length = math.sqrt(1.0 + tx * tx + ty * ty)
    cosine = -(tx * nx + ty * ny + nz) / length
    bend = cosine / n - math.sqrt(1.0 - (1.0 - cosine * cosine) / (n * n))
    vx, vy, vz = tx / length / n + bend * nx, ty / length / n + bend * ny, 1.0 / length / n + bend * nz
    x, y = x + vx / vz * (sheet.gap - depth), y + vy / vz * (sheet.gap - depth)
    if sheet.air > 0.0:
        # The flat back bends the ray out again, or keeps it.
        leaving2 = 1.0 - n * n * (vx * vx + vy * vy)
        if leaving2 <= 0.0:
            return 0.0, 0.0, False
        run = sheet.air * n / math.sqrt(leaving2)
        x, y = x + vx * run, y + vy * run
    return x, y, True


@njit()
def land(x: float, y: float, tx: float, ty: float, sheet: TracedSheet) -> tuple[float, float, bool]:
    """Where a ray that crosses the apex plane at (x, y), across and along the lenses, lands; False if stopped."""
    if sheet.radius == 0.0:
        # A line mask: the openings are centred where a sheet would have its axes.
        if abs(x / sheet.pitch - math.floor(x / sheet.pitch + 0.5)) > sheet.open_fraction / 2:
            return 0.0, 0.0, False
        n = sheet.refraction
        inside = sheet.gap / math.sqrt(n * n * (1.0 + tx * tx + ty * ty) - tx * tx - ty * ty) + sheet.air
        return x + inside * tx, y + inside * ty, True
    axis, hit, depth, met = meet(x, tx, sheet)
    if not met:
        return 0.0, 0.0, False
    return through(axis + hit, y + ty * depth, depth, tx, ty, hit / sheet.radius, 0.0, sheet)
