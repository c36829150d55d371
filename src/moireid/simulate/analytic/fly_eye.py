"""A board under an array of round lenses, as a camera sees it: a picture, one brightness a lens.

Each lens is traced by itself: a square of rays through its aperture lands on the page, and the share that finds light
between the crossed lines is the lens's brightness.  A camera's pixel sees several lenses or a part of one, so what a
lens shows within itself is left out.  Glare, a light's own bands, a bow and uneven lenses are left out too.

Convention: board frame of `motion`, mm; the picture is on the page's plane, (rows, columns) radiance over the whole
board, as `scene.Instant.picture`.  The array is mounted as one sheet: offset along x, twist from x towards y.
Source: sphere intersection and Snell's law in three dimensions, as `moireid.lenticule`, written again for one ray at a
time because a compiled loop shares nothing with arrays.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.analytic.trace import cell_at
from moireid.simulate.analytic.traced_page import cell_table, page_texture
from moireid.simulate.compiled import njit
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
Picture = NDArray[np.float32]
#: Rays across one lens, each way; twice as many change no brightness by more than a count.
RAYS = 8
#: Lenses that are traced beyond the field, so that its border has neighbours.
MORE = 2


class FlyEye:
    """Pictures of the scene's board, `per_mm` pixels to the printed millimetre."""

    def __init__(self, scene: Scene, per_mm: float) -> None:
        """Prepare the page.  Raises: SpecError for what this renderer leaves out."""
        if scene.light is not None or scene.build.pitch_jitter or math.isfinite(scene.build.bow_radius_m):
            raise SpecError("a lens array is rendered flat, even and in even light; leave light, bow and jitter out")
        self._scene, self._cells = scene, cell_table(scene)
        half = scene.printed_half_mm
        columns = max(round(2 * half[0] * per_mm), 2)
        self._per_mm = columns / (2 * half[0])
        size = (columns, math.ceil(2 * half[1] * self._per_mm))
        self._page = cv2.resize(page_texture(scene), size, interpolation=cv2.INTER_AREA)
        place_x, place_y = (
            (np.arange(count) + 0.5) / self._per_mm - side for count, side in zip(size, half, strict=True)
        )
        x0, y0, x1, y1 = (
            value - scene.board_centre_mm[k % 2] for k, value in enumerate(scene.badge.gratings[0].rect_mm)
        )
        columns_in, rows_in = (
            np.flatnonzero((place_x > x0) & (place_x < x1)),
            np.flatnonzero((place_y > y0) & (place_y < y1)),
        )
        self._inside = np.ix_(rows_in, columns_in)
        self._places = np.meshgrid(place_x[columns_in], place_y[rows_in])
        pitch = scene.lens.pitch_mm * scene.build.lens_scale
        reach = math.ceil(math.hypot(max(-x0, x1), max(-y0, y1)) / pitch) + MORE
        wide, high = (math.ceil(max(-low, high) / pitch) + MORE for low, high in ((x0, x1), (y0, y1)))
        # A twist turns the array's corners out of the upright rectangle, and a bigger one does no harm.
        self._count = (min(wide + MORE, reach), min(high + MORE, reach))

    def picture(self, camera_mm: Array) -> Picture:
        """The board as seen from `camera_mm` (3,), straightened on the page's plane."""
        scene, (wide, high) = self._scene, self._count
        lens, build = scene.lens, scene.build
        assert lens.radius_mm is not None
        pitch = lens.pitch_mm * build.lens_scale
        turn = np.array([build.lens_offset_mm, math.cos(build.twist_rad), math.sin(build.twist_rad)])
        figures = np.array([pitch, lens.thickness_mm, lens.refractive_index, lens.radius_mm, build.air_gap_mm])
        camera = np.asarray(camera_mm, float)
        lit = np.empty((2 * high + 1, 2 * wide + 1), np.float32)
        _lenses(lit, camera, abs(camera[2]) - scene.height_mm, figures, turn, self._cells, RAYS)
        # The sight line through a place of the page crosses the lenses before it.
        x, y = (
            place - scene.height_mm * (place - centre) / abs(camera[2])
            for place, centre in zip(self._places, camera[:2], strict=True)
        )
        across, along = x * turn[1] + y * turn[2] - turn[0], y * turn[1] - x * turn[2]
        seen = cv2.remap(
            lit,
            (across / pitch + wide).astype(np.float32),
            (along / pitch + high).astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        picture = self._page.copy()
        picture[self._inside] = scene.ink + (scene.paper - scene.ink) * seen
        return np.asarray(picture, np.float32)


@njit(error_model="numpy")
def _lenses(
    lit: Any, camera: Any, depth: float, figures: Any, turn: Any, cells: Any, rays: int
) -> None:  # pragma: no cover
    """Share of light in each lens (rows, columns), lens (0, 0) in the middle, seen from `depth` in front."""
    pitch, gap, n, radius, air = figures
    offset, cosine, sine = turn
    rows, columns = lit.shape
    for row in range(rows):
        for column in range(columns):
            x, y = (column - columns // 2) * pitch, (row - rows // 2) * pitch
            # The tangents from the camera to this lens, along the array's own directions.
            tan_x = ((x + offset) * cosine - y * sine - camera[0]) / depth
            tan_y = (y * cosine + (x + offset) * sine - camera[1]) / depth
            tx, ty = tan_x * cosine + tan_y * sine, tan_y * cosine - tan_x * sine
            found, light = 0, 0
            for i in range(rays):
                for j in range(rays):
                    dx, dy, through = _landed(
                        ((i + 0.5) / rays - 0.5) * pitch,
                        ((j + 0.5) / rays - 0.5) * pitch,
                        tx,
                        ty,
                        pitch,
                        gap,
                        n,
                        radius,
                        air,
                    )
                    if not through:
                        continue
                    found += 1
                    own_x, own_y = x + dx + offset, y + dy
                    light += _light(own_x * cosine - own_y * sine, own_y * cosine + own_x * sine, cells)
            lit[row, column] = light / max(found, 1)


@njit(inline="always", error_model="numpy")
def _light(x: float, y: float, cells: Any) -> int:  # pragma: no cover
    """Whether a place of the page is free of the lines of both gratings."""
    for grating in range(2):
        across, along = (x, y) if grating == 0 else (y, x)
        cell = cell_at(grating, across, along, cells)
        if cell >= 0:
            place = (across - cells.lines[cell, 0]) * cells.lines[cell, 1]
            if place - math.floor(place) < cells.lines[cell, 2]:
                return 0
    return 1


@njit(inline="always", error_model="numpy")
def _landed(
    x: float, y: float, tx: float, ty: float, pitch: float, gap: float, n: float, radius: float, air: float
) -> tuple[float, float, bool]:  # pragma: no cover
    """Where a ray that crosses the apex plane at (x, y) from a lens's axis lands, from that axis; False if stopped."""
    axis_x, axis_y = 0.0, 0.0
    a = 1.0 + tx * tx + ty * ty
    for _ in range(4):
        off_x, off_y = x - axis_x, y - axis_y
        b, c = off_x * tx + off_y * ty - radius, off_x * off_x + off_y * off_y
        root = b * b - a * c
        if root < 0.0:
            return 0.0, 0.0, False
        depth = c / (-b + math.sqrt(root))
        hit_x, hit_y = off_x + tx * depth, off_y + ty * depth
        if abs(hit_x) > pitch * 0.5 or abs(hit_y) > pitch * 0.5:
            # A ray that has left its own square meets the neighbour on that side.
            if abs(hit_x) > pitch * 0.5:
                axis_x += pitch if hit_x > 0 else -pitch
            if abs(hit_y) > pitch * 0.5:
                axis_y += pitch if hit_y > 0 else -pitch
            continue
        nx, ny, nz = hit_x / radius, hit_y / radius, (depth - radius) / radius
        length = math.sqrt(a)
        cosine = -(tx * nx + ty * ny + nz) / length
        if cosine <= 0.0:
            return 0.0, 0.0, False
        bend = cosine / n - math.sqrt(1.0 - (1.0 - cosine * cosine) / (n * n))
        vx, vy, vz = tx / length / n + bend * nx, ty / length / n + bend * ny, 1.0 / length / n + bend * nz
        landed_x, landed_y = axis_x + hit_x + vx / vz * (gap - depth), axis_y + hit_y + vy / vz * (gap - depth)
        if air > 0.0:
            leaving2 = 1.0 - n * n * (vx * vx + vy * vy)
            if leaving2 <= 0.0:
                return 0.0, 0.0, False
            run = air * n / math.sqrt(leaving2)
            landed_x, landed_y = landed_x + vx * run, landed_y + vy * run
        return landed_x, landed_y, True
    return 0.0, 0.0, False
