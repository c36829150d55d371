"""Surfaces as grids of points, and the soft cloth of a chest.

Convention: board frame of `motion`, mm: x right, y down, z into the board.  A grid (rows, columns, 3) is a surface that
joins neighbouring points; where it is closed, its last row or column repeats the first.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]
#: Points on a quarter of a circle.
QUARTER = 8


def rounded_outline(half_mm: tuple[float, float], radius_mm: float) -> Array:
    """The closed outline (N, 2) of a rectangle with rounded corners about the origin, mm."""
    turn = np.linspace(0, math.pi / 2, QUARTER + 1)
    corner = radius_mm * np.column_stack([np.cos(turn), np.sin(turn)])
    parts = []
    for k, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[k]
        middle = np.array([x * (half_mm[0] - radius_mm), y * (half_mm[1] - radius_mm)])
        parts.append(corner @ np.array([[cos, sin], [-sin, cos]]) + middle)
    outline = np.concatenate(parts)
    return np.vstack([outline, outline[:1]])


def rings(half_mm: tuple[float, float], radius_mm: float, profile: list[tuple[float, float]]) -> Array:
    """A surface through rounded rectangles, each wider by an offset and at a depth.

    Parameters
    ----------
    half_mm : (float, float)
        Half of the width and of the height at offset 0.
    radius_mm : float
        Of the corners at offset 0.
    profile : list of (offset, depth)
        mm, one entry a ring.

    Returns
    -------
    array (rings, points, 3)
    """
    made = []
    for offset, depth in profile:
        half = half_mm[0] + offset, half_mm[1] + offset
        outline = rounded_outline(half, min(max(radius_mm + offset, 0.05), *half))
        made.append(np.column_stack([outline, np.full(len(outline), depth)]))
    return np.stack(made)


def plate(half_mm: tuple[float, float], radius_mm: float, front: float, back: float, *, middle_y: float = 0.0) -> Array:
    """A plate with rounded corners and edges, its front and its back at two depths; middle_y: its place, mm."""
    profile = [(-0.98 * min(half_mm), front), (-0.6, front), (-0.2, front + 0.2), (0.0, front + 0.6), (0.0, back)]
    made = rings(half_mm, radius_mm, profile)
    made[..., 1] += middle_y
    return made


def tube(path: Array, radius_mm: float, *, closed: bool = False) -> Array:
    """A tube (points of the path, around, 3) about a path (N, 3); closed: its end joins its beginning."""
    path = np.vstack([path, path[:1]]) if closed else path
    if closed:
        way = np.roll(path[:-1], -1, axis=0) - np.roll(path[:-1], 1, axis=0)
        way = np.vstack([way, way[:1]])
    else:
        way = np.gradient(path, axis=0)
    way = way / np.linalg.norm(way, axis=1, keepdims=True)
    # No part of a hook or a ring runs along this direction.
    aside = np.cross(way, np.array([0.31, 0.17, 0.94]))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    other = np.cross(way, aside)
    turn = np.linspace(0, 2 * math.pi, 4 * QUARTER + 1)
    around = np.cos(turn)[None, :, None] * aside[:, None] + np.sin(turn)[None, :, None] * other[:, None]
    return np.asarray(path[:, None] + radius_mm * around)


def ribbon(path: Array, width_mm: float) -> Array:
    """A flat ribbon (points of the path, 3 across, 3) that follows a path (N, 3), its face towards the camera."""
    way = np.gradient(path, axis=0)
    across = np.column_stack([-way[:, 1], way[:, 0], np.zeros(len(way))])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    side = np.array([-0.5, 0.0, 0.5])[None, :, None] * width_mm * across[:, None]
    # Its edges bend back a little, so that they catch the light.
    side[..., 2] += np.array([0.5, 0.0, 0.5])
    return np.asarray(path[:, None] + side)


class Cloth:
    """A chest under a knitted jumper.

    Parameters
    ----------
    half_mm : (float, float)
        Half of the width and of the height that the cloth covers.
    depth_mm : float
        Of its nearest part, behind the page.
    seed : int
        Of its folds.
    """

    def __init__(self, half_mm: tuple[float, float], depth_mm: float, seed: int) -> None:
        self._x = np.arange(-half_mm[0], half_mm[0] + 1.0, 1.5)
        self._y = np.arange(-half_mm[1], half_mm[1] + 1.0, 1.5)
        x, y = np.meshgrid(self._x, self._y)
        # A torso is rounder across than along; it falls back towards the shoulders.
        body = 165.0 * (1 - np.sqrt(np.clip(1 - (x / 230.0) ** 2, 0.05, 1))) + 0.0006 * np.minimum(y + 40, 0) ** 2
        rng = np.random.default_rng(seed)
        folds = np.zeros_like(body)
        for along, across, height in ((70.0, 15.0, 5.0), (110.0, 30.0, 9.0), (20.0, 20.0, 1.2)):
            noise = gaussian_filter(rng.standard_normal(body.shape), (along / 1.5, across / 1.5))
            folds += height * noise / noise.std()
        # Folds hang from the shoulders: they run down and outwards.
        self._depth = depth_mm + body + np.abs(folds) * 0.8 + 0.2 * folds
        self._depth -= max(0.0, depth_mm - self._depth.min())

    def grid(self) -> Array:
        """The cloth (rows, columns, 3), mm."""
        x, y = np.meshgrid(self._x, self._y)
        return np.stack([x, y, self._depth], axis=-1)

    def depth_mm(self, places: Array) -> Array:
        """Depth (N,) of the cloth at places (N, 2), mm; beyond its edge that of the edge."""
        from scipy.interpolate import RegularGridInterpolator

        at = RegularGridInterpolator((self._y, self._x), self._depth)
        x, y = np.clip(places[:, 0], self._x[0], self._x[-1]), np.clip(places[:, 1], self._y[0], self._y[-1])
        return np.asarray(at(np.column_stack([y, x])))


def knit(half_mm: tuple[float, float], stitch_mm: tuple[float, float] = (2.6, 2.0)) -> Array:
    """Height of knitted stitches, 0 to 1, (rows, columns) over a rectangle at five pixels a millimetre."""
    per_mm = 5
    x, y = np.meshgrid(np.arange(2 * half_mm[0] * per_mm) / per_mm, np.arange(2 * half_mm[1] * per_mm) / per_mm)
    # Each stitch is a V: two slanting strands that meet in the middle of a column.
    across = np.abs((x / stitch_mm[0]) % 1.0 - 0.5) * 2
    along = (y / stitch_mm[1] + 0.9 * (1 - across)) % 1.0
    strand = np.sin(math.pi * along) ** 0.7 * np.sin(math.pi * np.clip(across * 0.9 + 0.05, 0, 1)) ** 0.5
    return np.asarray(strand)
