"""A badge that is not flat: sheet and page bent together to a cylinder, twisted to a saddle, or both.

Convention: the badge frame, in which a flat badge is the plane z = 0 and touches the bent one in the middle.  Places on
the badge are those of the flat one: lengths across a cylinder are kept as arcs, and sheet and page are glued, so that
what was above a place of the page stays above it, along the surface's normal.  A saddle stretches by the square of its
slope, 0.001 at most here, lenses and page alike.
Source: differential geometry of a graph z(x, y); Newton's method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

#: Steps from the flat plane to the surface; a fourth would change a place under a radius of 0.3 m by less than 1e-6 mm.
STEPS = 3
#: A cylinder ends where its surface is this steep (sine), which no badge reaches.
STEEPEST = 0.95
#: Points along an edge that show how far a bent badge reaches.
EDGE_POINTS = 9


@dataclass(frozen=True)
class Bend:
    """curvature_per_mm: 1 / radius, positive where edges recede from the camera; axis_rad: the cylinder's axis in the
    page, from x to y; twist_per_mm: z = twist x y."""

    curvature_per_mm: float = 0.0
    axis_rad: float = math.pi / 2
    twist_per_mm: float = 0.0

    @property
    def figures(self) -> NDArray[np.float64]:
        """As `onto` reads: curvature, the direction across the axis, twist; none for a flat badge."""
        if self == Bend(0.0, self.axis_rad, 0.0):
            return np.zeros(0)
        across = math.sin(self.axis_rad), -math.cos(self.axis_rad)
        return np.array([self.curvature_per_mm, *across, self.twist_per_mm])


def outline(half_x: float, half_y: float, bend: Bend) -> NDArray[np.float64]:
    """Points (n, 3) in the badge frame around a board of that half size: corners of a flat one, edges of a bent one."""
    sides = np.linspace(-1, 1, 2 if len(bend.figures) == 0 else EDGE_POINTS)
    x, y = (part.ravel() for part in np.meshgrid(sides * half_x, sides * half_y))
    if len(bend.figures) == 0:
        return np.column_stack([x, y, np.zeros(len(x))])
    return np.array([in_space(*place, 0.0, bend.figures)[1] for place in zip(x, y, strict=True)])


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _graph(x, y, bend):
    """Depth z over (x, y), its slopes along x and y, the place across the cylinder, and the sine of its slope."""
    across = bend[1] * x + bend[2] * y
    sine = min(max(bend[0] * across, -STEEPEST), STEEPEST)
    cosine = math.sqrt(1.0 - sine * sine)
    z = sine * across / (1.0 + cosine) + bend[3] * x * y
    steep = sine / cosine
    return z, bend[1] * steep + bend[3] * y, bend[2] * steep + bend[3] * x, across, sine


@njit(cache=True, fastmath=True, error_model="numpy")
def plane_at(x, y, bend):
    """The plane that touches the badge at (x, y) of the badge frame, as `onto_plane` reads.

    Returns: x, y, z; slopes of z along x and y; length of the normal (-p, -q, 1); the place on the flat badge; how much
    longer an arc is than its x and y show.
    """
    z, p, q, across, sine = _graph(x, y, bend)
    longer = math.asin(sine) / bend[0] - across if bend[0] != 0.0 else 0.0
    stretch = 1.0 / math.sqrt(1.0 - sine * sine) - 1.0
    return x, y, z, p, q, math.sqrt(1.0 + p * p + q * q), x + bend[1] * longer, y + bend[2] * longer, stretch


@njit(cache=True, fastmath=True, error_model="numpy")
def slopes_on(plane, ex, ey, bend):
    """Slopes of a ray against the normal of that plane, along the badge's own x and y."""
    _, _, _, p, q, length, _, _, stretch = plane
    # The ray less its part along the normal, over that part.
    deep = (1.0 - p * ex - q * ey) / length
    ex, ey = ex / deep + p / length, ey / deep + q / length
    arc = (bend[1] * ex + bend[2] * ey) * stretch
    return ex + bend[1] * arc, ey + bend[2] * arc


@njit(cache=True, fastmath=True, error_model="numpy")
def plane_under(x, y, ex, ey, bend):
    """The plane that touches the badge where it is met by the ray that crosses z = 0 at (x, y)."""
    z = 0.0
    for _ in range(STEPS):
        depth, p, q, _, _ = _graph(x + z * ex, y + z * ey, bend)
        z -= (z - depth) / (1.0 - p * ex - q * ey)
    return plane_at(x + z * ex, y + z * ey, bend)


@njit(cache=True, fastmath=True, error_model="numpy")
def onto_plane(x, y, ex, ey, above, bend, plane):
    """The ray that crosses z = -above at (x, y) with slopes ex = dx/dz, ey = dy/dz, as the bent badge has it nearby.

    Returns: where it meets the surface `above` the page, as a place of the flat badge, and its slopes there.  Within a
    pixel the badge is its plane: 1 mm away, a radius of 0.35 m is 1.4 um off it.
    """
    px, py, pz, p, q, _, u, v, stretch = plane
    dx, dy = x + above * ex - px, y + above * ey - py
    z = (pz + p * dx + q * dy) / (1.0 - p * ex - q * ey)
    dx += z * ex
    dy += z * ey
    arc = (bend[1] * dx + bend[2] * dy) * stretch
    ex, ey = slopes_on(plane, ex, ey, bend)
    return u + dx + bend[1] * arc - above * ex, v + dy + bend[2] * arc - above * ey, ex, ey


@njit(cache=True, fastmath=True, error_model="numpy")
def onto(x, y, ex, ey, above, bend):
    """As `onto_plane`, of the plane where the ray meets the page."""
    plane = plane_under(x + above * ex, y + above * ey, ex, ey, bend)
    return onto_plane(x, y, ex, ey, above, bend, plane)


@njit(cache=True, fastmath=True, error_model="numpy")
def in_space(x, y, above, bend):
    """The plane that touches the badge at a place of the flat badge, and that place in the badge frame, `above` it."""
    arc = bend[1] * x + bend[2] * y
    longer = math.sin(bend[0] * arc) / bend[0] - arc if bend[0] != 0.0 else 0.0
    plane = plane_at(x + bend[1] * longer, y + bend[2] * longer, bend)
    px, py, pz, p, q, length, _, _, _ = plane
    return plane, (px + above * p / length, py + above * q / length, pz - above / length)
