"""Ray tracing through one lens of a fly's-eye sheet: a square array of spherical lenses over a page of dots.

Where a cylinder lens shifts the page with one parallax, a round lens shifts it with both.  So a page whose lines cross
shows crossed fringes, and each of its points depends on both parallaxes: nothing in the picture is of one direction.

Convention: as `moireid.lenticule`: the apex plane is z = 0, z into the page, lens 0 has its axis at (0, 0); a lens is
the square of one pitch around its axis.
Source: intersection with a sphere and Snell's law in three dimensions.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Lens
from moireid.optics import passed_share

Array = NDArray[np.float64]
#: Rays across one lens, each way.
RAYS = 48
#: Lenses that an oblique ray may pass over before it meets one.
TRIES = 4


def landed_mm(lens: Lens, start_x: Array, start_y: Array, tan_x: Array, tan_y: Array) -> tuple[Array, Array, Array]:
    """Where rays that cross the apex plane at the start land on the page, x and y, and the cosine of their incidence.

    Parameters: arrays that broadcast together; mm and tangents.
    Convention: module docstring; NaN for a ray that misses every lens that it may meet.
    Returns: mm, mm and cosine, each of the broadcast shape.
    Source: module docstring; the nearer root as in `lenticule.trace_mm`.
    """
    assert lens.radius_mm is not None
    x, y, tx, ty = (np.array(part, float) for part in np.broadcast_arrays(start_x, start_y, tan_x, tan_y))
    radius, pitch, n = lens.radius_mm, lens.pitch_mm, lens.refractive_index
    axis_x, axis_y = np.round(x / pitch) * pitch, np.round(y / pitch) * pitch
    a = 1.0 + tx**2 + ty**2
    for _ in range(TRIES):
        off_x, off_y = x - axis_x, y - axis_y
        b, c = off_x * tx + off_y * ty - radius, off_x**2 + off_y**2
        root = b**2 - a * c
        depth = c / (-b + np.sqrt(np.maximum(root, 0.0)))
        hit_x, hit_y = off_x + tx * depth, off_y + ty * depth
        # A ray that has left its own square meets the neighbour on that side.
        over_x, over_y = (np.sign(hit) * (np.abs(hit) > pitch / 2 * (1 + 1e-12)) for hit in (hit_x, hit_y))
        axis_x, axis_y = axis_x + over_x * pitch, axis_y + over_y * pitch
    missed = (root < 0) | (over_x != 0) | (over_y != 0)
    normal = [hit_x / radius, hit_y / radius, (depth - radius) / radius]
    length = np.sqrt(a)
    cosine = -(tx * normal[0] + ty * normal[1] + normal[2]) / length
    bend = cosine / n - np.sqrt(np.maximum(1.0 - (1.0 - cosine**2) / n**2, 0.0))
    down = (1.0 / length / n + bend * normal[2]) / (lens.thickness_mm - depth)
    landed_x = axis_x + hit_x + (tx / length / n + bend * normal[0]) / down
    landed_y = axis_y + hit_y + (ty / length / n + bend * normal[1]) / down
    return tuple(np.where(missed | (cosine <= 0), np.nan, part) for part in (landed_x, landed_y, cosine))  # type: ignore[return-value]


def array_response(lens: Lens, rear_pitch_mm: float, tan_x: Array, tan_y: Array) -> NDArray[np.complex128]:
    """Complex response of an array to lines across x of that pitch, as `lenticule.view_response`.

    Parameters: tan_x, tan_y of one shape.
    Source: average over the rays of one lens, uniform on the apex plane, weighted by `optics.passed_share`.
    """
    across = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * lens.pitch_mm
    start_x, start_y = (part.ravel() for part in np.meshgrid(across, across))
    response = np.empty(tan_x.shape, complex)
    for place in np.ndindex(tan_x.shape):
        landed, _, cosine = landed_mm(lens, start_x, start_y, tan_x[place], tan_y[place])
        seen = np.isfinite(landed)
        passed = passed_share(lens.refractive_index, cosine[seen])
        turned = np.exp(2j * math.pi * landed[seen] / rear_pitch_mm)
        response[place] = (passed * turned).sum() / passed.sum()
    return response
