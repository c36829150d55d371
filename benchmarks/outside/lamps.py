"""Lamps: one to the side of the badge, and one that the lenses mirror.

A lamp to the side lights by the square of distance and the cosine of incidence (Lambert), so that light falls off
across the page and changes as the badge turns.  A lens mirrors a lamp where half way between the directions to lamp and
camera there is a normal of its surface.  The normals of a cylinder fan out across it; so lenses side by side each show
the lamp, and it becomes a bright band across the lenses, at the place along them where the mirror's law holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from outside.bend import in_space, onto, slopes_on
from outside.motion import Course
from outside.page import PAPER
from outside.trace import _pose, _sheet_at

#: Half the lamp's width as an angle, with the roughness of lenses, over both directions' sum (standard deviation).
LAMP_WIDE = 0.03
#: How far the lamps are, mm, and the directions in which they are: to the side from the front, and across the lenses.
SIDE_MM, SIDE_RAD, GLARE_MM, GLARE_RAD = (450.0, 550.0), (0.6, 0.85), 2000.0, (0.2, 0.5)


@dataclass(frozen=True)
class Lamps:
    """side: share of the light that a lamp at side_mm gives; glare: light that lenses mirror at most of the lamp at
    glare_mm, over that of white card.  Places in the world, mm."""

    side: float
    side_mm: tuple[float, float, float]
    glare: float
    glare_mm: tuple[float, float, float]


def lamps_about(course: Course, seconds: float, side: float, glare: float, rng: np.random.Generator) -> Lamps:
    """Lamps of that strength; lenses that run upright mirror theirs in the badge's middle at some time of the film."""
    angle, lift = rng.choice([-1, 1]) * rng.uniform(*SIDE_RAD), rng.uniform(-0.4, 0.1)
    far = rng.uniform(*SIDE_MM)
    lit = far * np.array([math.sin(angle), lift, -math.cos(angle)])
    time = np.array([rng.uniform(0.2, 0.8) * seconds])
    view = course.views(time)[0][0]
    across = rng.choice([-1, 1]) * rng.uniform(*GLARE_RAD)
    normal = np.array([math.sin(across), 0.0, -math.cos(across)])
    mirrored = 2 * (normal @ view) * normal - view
    shown = course.in_world(mirrored / np.linalg.norm(mirrored) * GLARE_MM, time)[0]
    return Lamps(side, tuple(lit.tolist()), glare, tuple(shown.tolist()))


def relight(
    light: NDArray[np.float32], box: tuple[int, int, int, int], rays: NDArray[np.float32], camera: tuple[float, ...],
    places: NDArray[np.float64], turns: NDArray[np.float64], badge: tuple[NDArray[np.float64], ...], lamps: Lamps,
    seen: NDArray[np.float64],
) -> None:  # fmt: skip
    """Change the light of a traced frame; arguments as of `trace.trace`.

    badge: sheets, the built board's size, its bend; seen: places of the two lamps in the badge's frame, (2, 3).
    """
    # As bright as by the room alone in the middle of a badge that faces the camera.
    full = float(np.linalg.norm(lamps.side_mm)) ** 3 / -lamps.side_mm[2]
    strengths = np.array([lamps.side, full, PAPER * lamps.glare])
    _relight(light, box, rays, camera, places, turns, *badge, strengths, seen)


@njit(cache=True, fastmath=True, error_model="numpy")
def _relight(light, box, rays, camera, places, turns, sheets, size, bend, strengths, seen):
    """`relight` in plain numbers."""
    a = np.empty(12)
    for row in range(box[1], box[3]):
        _pose(places, turns, min(camera[2] * row / light.shape[0] + camera[1] / 2, places.shape[0] - 1.0), a)
        for column in range(box[0], box[2]):
            rx, ry = rays[row, column, 0], rays[row, column, 1]
            dz = a[9] * rx + a[10] * ry + a[11]
            ex, ey = (a[3] * rx + a[4] * ry + a[5]) / dz, (a[6] * rx + a[7] * ry + a[8]) / dz
            x, y = a[0] - a[2] * ex, a[1] - a[2] * ey
            if len(bend) > 0:
                x, y, ex, ey = onto(x, y, ex, ey, 0.0, bend)
            mm = -a[2] / dz / camera[0]
            # The share of the pixel that is on the badge.
            cover = min(max((size[2] - abs(x)) / mm + 0.5, 0.0), 1.0)
            cover *= min(max((size[3] - abs(y)) / mm + 0.5, 0.0), 1.0)
            if cover == 0.0:
                continue
            light[row, column] *= 1.0 + cover * strengths[0] * (lambert(x, y, bend, seen[0]) * strengths[1] - 1.0)
            k = _sheet_at(x, y, sheets, 0.0)
            if k >= 0 and strengths[2] > 0.0:
                light[row, column] += strengths[2] * mirrored(x, y, ex, ey, sheets[k, 2], sheets[k, 3], bend, seen[1])


@njit(cache=True, fastmath=True, error_model="numpy")
def _from(lamp, x, y, bend):
    """Slopes of the lamp's ray that meets the badge at a place, against the normal there, and its length, mm."""
    if len(bend) > 0:
        plane, there = in_space(x, y, 0.0, bend)
        lx, ly, far = _slopes(there, lamp)
        lx, ly = slopes_on(plane, lx, ly, bend)
        return lx, ly, far
    return _slopes((x, y, 0.0), lamp)


@njit(cache=True, fastmath=True, error_model="numpy")
def _slopes(place, lamp):
    """As `_from`, against the flat badge's normal."""
    dx, dy, dz = place[0] - lamp[0], place[1] - lamp[1], place[2] - lamp[2]
    # A lamp behind the badge lights nothing.
    deep = max(dz, 1e-6)
    return dx / deep, dy / deep, math.sqrt(dx * dx + dy * dy + dz * dz)


@njit(cache=True, fastmath=True, error_model="numpy")
def lambert(x, y, bend, lamp):
    """Light of a lamp on a place of the badge: cosine of incidence over the square of distance, 1 / mm^2."""
    lx, ly, far = _from(lamp, x, y, bend)
    return 1.0 / math.sqrt(1.0 + lx * lx + ly * ly) / (far * far)


@njit(cache=True, fastmath=True, error_model="numpy")
def mirrored(x, y, ex, ey, cosine, sine, bend, lamp):
    """Share of the lamp's mirrored light that reaches the camera from a place of a sheet; ex, ey: slopes of the view.

    cosine, sine: of the direction across the lenses.
    """
    lx, ly, _ = _from(lamp, x, y, bend)
    view, shine = 1.0 / math.sqrt(1.0 + ex * ex + ey * ey), 1.0 / math.sqrt(1.0 + lx * lx + ly * ly)
    half_x, half_y, half_z = ex * view + lx * shine, ey * view + ly * shine, view + shine
    across, along = half_x * cosine + half_y * sine, half_y * cosine - half_x * sine
    # Seen at an angle, the part of a lens that mirrors is narrower.
    return math.exp(-0.5 * (along / LAMP_WIDE) ** 2) * half_z / math.sqrt(half_z * half_z + across * across)
