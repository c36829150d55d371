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

#: Steps from the flat plane to the surface; the next one would change a place under a radius of 0.3 m by less than 1e-6 mm.
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
    return np.array([in_space(*place, 0.0, bend.figures) for place in zip(x, y, strict=True)])


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _graph(x, y, bend):
    """Depth z over (x, y), its slopes along x and y, the place across the cylinder, and the cosine of its slope."""
    across = bend[1] * x + bend[2] * y
    sine = min(max(bend[0] * across, -STEEPEST), STEEPEST)
    cosine = math.sqrt(1.0 - sine * sine)
    z = sine * across / (1.0 + cosine) + bend[3] * x * y
    steep = sine / cosine
    return z, bend[1] * steep + bend[3] * y, bend[2] * steep + bend[3] * x, across, cosine


@njit(cache=True, fastmath=True, error_model="numpy")
def slopes_on(x, y, ex, ey, bend):
    """Slopes of a ray against the normal of the badge at (x, y) of the badge frame, along the badge's own x and y."""
    _, p, q, _, cosine = _graph(x, y, bend)
    length = math.sqrt(1.0 + p * p + q * q)
    # The ray less its part along the normal (-p, -q, 1), over that part.
    deep = (1.0 - p * ex - q * ey) / length
    ex, ey = ex / deep + p / length, ey / deep + q / length
    arc = (bend[1] * ex + bend[2] * ey) * (1.0 / cosine - 1.0)
    return ex + bend[1] * arc, ey + bend[2] * arc


@njit(cache=True, fastmath=True, error_model="numpy")
def onto(x, y, ex, ey, above, bend):
    """The ray that crosses the plane z = -above at (x, y) with slopes ex = dx/dz, ey = dy/dz, as the bent badge has it.

    Returns: where it meets the surface `above` the page, as a place of the flat badge, and its slopes there.
    """
    x += above * ex
    y += above * ey
    z = 0.0
    for _ in range(STEPS):
        depth, p, q, _, _ = _graph(x + z * ex, y + z * ey, bend)
        z -= (z - depth) / (1.0 - p * ex - q * ey)
    x += z * ex
    y += z * ey
    _, _, _, across, _ = _graph(x, y, bend)
    ex, ey = slopes_on(x, y, ex, ey, bend)
    sine = min(max(bend[0] * across, -STEEPEST), STEEPEST)
    longer = math.asin(sine) / bend[0] - across if bend[0] != 0.0 else 0.0
    return x + bend[1] * longer - above * ex, y + bend[2] * longer - above * ey, ex, ey


@njit(cache=True, fastmath=True, error_model="numpy")
def in_space(x, y, above, bend):
    """Where a place of the badge is in the badge frame, `above` the page along the normal, mm."""
    arc = bend[1] * x + bend[2] * y
    longer = math.sin(bend[0] * arc) / bend[0] - arc if bend[0] != 0.0 else 0.0
    x, y = x + bend[1] * longer, y + bend[2] * longer
    z, p, q, _, _ = _graph(x, y, bend)
    length = math.sqrt(1.0 + p * p + q * q)
    return x + above * p / length, y + above * q / length, z - above / length
