"""The lens sheet as built, and one ray through it.

Convention: the sheet's own frame, mm: x across the lenses from the axis of lens 0, y along them, z into the page; the
plane of the lenses' tops (apex plane) is z = 0, view tangents are dx/dz and dy/dz.
Source: circle intersection and Snell's law in three dimensions; the same physics as `moireid.lenticule`, written
again for one ray at a time because a compiled loop shares nothing with arrays.  No fast-math flag is set: what it would
allow moves rays that just miss.
"""

from __future__ import annotations

import cmath
import math
from typing import NamedTuple

from moireid.errors import SpecError
from moireid.simulate.compiled import njit
from moireid.simulate.scene import Scene

#: A slanted ray may pass over the nearest lenticule and meet another one: at 80 degrees the third.
TRIES = 8


class TracedSheet(NamedTuple):
    """The lens sheet as built, mm; radius is 0 for a line mask.

    gap: thickness of the sheet; height: from the page to the lenses' tops; air: between sheet and page; curvature,
    bent_x, bent_y, twist: as `Scene.bend`; conic: the lenses' conic constant;
    sag: how much deeper the valleys between lenses lie than their tops; steepest: tangent across the lenses up to which
    `quick` finds the first lens that a ray meets.
    """

    pitch: float
    gap: float
    height: float
    air: float
    curvature: float
    bent_x: float
    bent_y: float
    twist: float
    refraction: float
    radius: float
    conic: float
    open_fraction: float
    sag: float
    steepest: float


def sheet_as_built(scene: Scene) -> TracedSheet:
    """The sheet of a scene.  Raises: SpecError where its lenses do not meet."""
    lens, build = scene.lens, scene.build
    pitch, radius = lens.pitch_mm * build.lens_scale, lens.radius_mm or 0.0
    if radius and pitch > 2 * radius:
        raise SpecError(f"lens_scale={build.lens_scale:g} spreads the lenses beyond their diameter; give less")
    left2 = radius**2 - (1 + build.conic) * pitch**2 / 4
    if radius and left2 <= 0:
        raise SpecError(
            f"ellipses of conic constant {build.conic:g} are narrower than a lens; give less, or 0 for circles"
        )
    # Of a circle this is r - sqrt(r^2 - p^2/4), written so that it also holds for a parabola.
    sag = pitch**2 / 4 / (radius + math.sqrt(left2)) if build.conic else radius - math.sqrt(left2) if radius else 0.0
    return TracedSheet(
        pitch,
        lens.thickness_mm,
        scene.height_mm,
        build.air_gap_mm,
        *scene.bend,
        lens.refractive_index,
        radius,
        build.conic,
        lens.open_fraction or 0.0,
        sag,
        # A ray less slanted than the lens's flank is steeper than the surface everywhere.  So it meets the lens over
        # which it crosses the depth of the valleys.
        math.sqrt(left2) / (pitch / 2) if radius else math.inf,
    )


@njit()
def meet(x: float, tx: float, sheet: TracedSheet) -> tuple[float, float, float, bool]:
    """The lens that a ray through the apex plane at x meets: its axis, the place from it, the depth; False for none."""
    pitch, radius = sheet.pitch, sheet.radius
    axis = math.floor(x / pitch + 0.5) * pitch
    way = 1.0 if tx >= 0 else -1.0
    a = 1.0 + tx * tx + sheet.conic
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
    x: float, y: float, depth: float, tx: float, ty: float, nx: float, ny: float, air: float, sheet: TracedSheet
) -> tuple[float, float, bool]:
    """Where a ray lands that meets a lens's surface at (x, y), `depth` under its top; False where the back keeps it.

    nx, ny: the surface's normal, which for a circle is how far that point is from the lens's axis, in radii; a cylinder
    has ny = 0; air: between sheet and page there.
    """
    n = sheet.refraction
    nz = (depth - sheet.radius) / sheet.radius if sheet.conic == 0.0 else -math.sqrt(1.0 - nx * nx - ny * ny)
    length = math.sqrt(1.0 + tx * tx + ty * ty)
    cosine = -(tx * nx + ty * ny + nz) / length
    bend = cosine / n - math.sqrt(1.0 - (1.0 - cosine * cosine) / (n * n))
    vx, vy, vz = tx / length / n + bend * nx, ty / length / n + bend * ny, 1.0 / length / n + bend * nz
    x, y = x + vx / vz * (sheet.gap - depth), y + vy / vz * (sheet.gap - depth)
    if air > 0.0:
        # The flat back bends the ray out again, or keeps it.
        leaving2 = 1.0 - n * n * (vx * vx + vy * vy)
        if leaving2 <= 0.0:
            return 0.0, 0.0, False
        run = air * n / math.sqrt(leaving2)
        x, y = x + vx * run, y + vy * run
    return x, y, True


@njit(inline="always")
def tilt(hit: float, depth: float, sheet: TracedSheet) -> float:
    """Normal across the lenses at a place of a lens, from its axis; source: the gradient of the conic."""
    if sheet.conic == 0.0:
        return hit / sheet.radius
    down = sheet.radius - (1.0 + sheet.conic) * depth
    return hit / math.sqrt(hit * hit + down * down)


@njit()
def land(x: float, y: float, tx: float, ty: float, air: float, sheet: TracedSheet) -> tuple[float, float, bool]:
    """Where a ray that crosses the apex plane at (x, y), across and along the lenses, lands; False if stopped.

    air: between sheet and page there.
    """
    if sheet.radius == 0.0:
        # A line mask: the openings are centred where a sheet would have its axes.
        if abs(x / sheet.pitch - math.floor(x / sheet.pitch + 0.5)) > sheet.open_fraction / 2:
            return 0.0, 0.0, False
        n = sheet.refraction
        inside = sheet.gap / math.sqrt(n * n * (1.0 + tx * tx + ty * ty) - tx * tx - ty * ty) + air
        return x + inside * tx, y + inside * ty, True
    axis, hit, depth, met = meet(x, tx, sheet)
    if not met:
        return 0.0, 0.0, False
    return through(axis + hit, y + ty * depth, depth, tx, ty, tilt(hit, depth, sheet), 0.0, air, sheet)


#: Rays across a lens, and the view tangent, of `traced_gap_mm`.
GAP_RAYS, NEAR = 512, 0.05


def traced_gap_mm(sheet: TracedSheet, rear_pitch_mm: float) -> float:
    """Slope of the law near the axis as a length, of a sheet of any lenses.

    Convention: as `moireid.sheets.effective_gap_mm`, but every ray counts alike.
    Source: mean of exp(2 pi i s / p_r) over the rays of one lens, s where each lands, at the tangent `NEAR`; from the
        other side it is the conjugate.
    """
    mean = 0j
    for ray in range(GAP_RAYS):
        start = ((ray + 0.5) / GAP_RAYS - 0.5) * sheet.pitch
        landed, _, seen = land(start, 0.0, NEAR, 0.0, sheet.air, sheet)
        if seen:
            mean += cmath.exp(2j * math.pi * landed / rear_pitch_mm)
    return cmath.phase(mean**2) * rear_pitch_mm / (4 * math.pi * NEAR)
