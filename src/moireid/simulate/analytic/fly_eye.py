"""A board under an array of round lenses, as a camera sees it: a picture, one brightness a lens.

Each lens is traced by itself: a square of rays through its aperture lands on the page, and the share that finds light
between the crossed lines is the lens's brightness.  A camera's pixel sees several lenses or a part of one, so what a
lens shows within itself is left out.  Glare, a light's own bands, a bow and uneven lenses are left out too.

Convention: board frame of `motion`, mm; the picture is on the page's plane, (rows, columns) radiance over the whole
board, as `scene.Instant.picture`.  The array is mounted as one sheet: offset along x, twist from x towards y.
Source: sphere intersection; `traced_sheet` for the rest.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.analytic.trace import inked
from moireid.simulate.analytic.traced_page import cell_table, page_texture
from moireid.simulate.analytic.traced_sheet import TracedSheet, sheet_as_built, through
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
        build = scene.build
        if scene.light is not None or build.is_uneven or build.is_bent or build.conic:
            raise SpecError(
                "a lens array is rendered flat, with even round lenses and in even light; leave light, glare, bow, "
                "corner, ellipse, wander, gradient, jitter and air waves out"
            )
        self._scene, self._cells = scene, cell_table(scene)
        self._sheet = sheet_as_built(scene)
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
        pitch = self._sheet.pitch
        reach = math.ceil(math.hypot(max(-x0, x1), max(-y0, y1)) / pitch) + MORE
        wide, high = (math.ceil(max(-low, high) / pitch) + MORE for low, high in ((x0, x1), (y0, y1)))
        # A twist turns the array's corners out of the upright rectangle, and a bigger one does no harm.
        self._count = (min(wide + MORE, reach), min(high + MORE, reach))

    def picture(self, camera_mm: Array) -> Picture:
        """The board as seen from `camera_mm` (3,), straightened on the page's plane."""
        scene, (wide, high), sheet = self._scene, self._count, self._sheet
        turn = scene.build.lens_offset_mm, math.cos(scene.build.twist_rad), math.sin(scene.build.twist_rad)
        camera = np.asarray(camera_mm, float)
        lit = np.empty((2 * high + 1, 2 * wide + 1), np.float32)
        _lenses(lit, camera, abs(camera[2]) - sheet.height, sheet, turn, self._cells, RAYS)
        # The sight line through a place of the page crosses the lenses before it.
        x, y = (
            place - sheet.height * (place - centre) / abs(camera[2])
            for place, centre in zip(self._places, camera[:2], strict=True)
        )
        across, along = x * turn[1] + y * turn[2] - turn[0], y * turn[1] - x * turn[2]
        seen = cv2.remap(
            lit,
            (across / sheet.pitch + wide).astype(np.float32),
            (along / sheet.pitch + high).astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        picture = self._page.copy()
        picture[self._inside] = scene.ink + (scene.paper - scene.ink) * seen
        return np.asarray(picture, np.float32)


@njit()
def _lenses(lit: Any, camera: Any, depth: float, sheet: TracedSheet, turn: Any, cells: Any, rays: int) -> None:
    """Share of light in each lens (rows, columns), lens (0, 0) in the middle, seen from `depth` in front."""
    offset, cosine, sine = turn
    rows, columns = lit.shape
    for row in range(rows):
        for column in range(columns):
            x, y = (column - columns // 2) * sheet.pitch, (row - rows // 2) * sheet.pitch
            # The tangents from the camera to this lens, along the array's own directions.
            tan_x = ((x + offset) * cosine - y * sine - camera[0]) / depth
            tan_y = (y * cosine + (x + offset) * sine - camera[1]) / depth
            tx, ty = tan_x * cosine + tan_y * sine, tan_y * cosine - tan_x * sine
            found, light = 0, 0
            for i in range(rays):
                for j in range(rays):
                    start_x, start_y = ((i + 0.5) / rays - 0.5) * sheet.pitch, ((j + 0.5) / rays - 0.5) * sheet.pitch
                    dx, dy, seen = _landed(start_x, start_y, tx, ty, sheet)
                    if not seen:
                        continue
                    found += 1
                    own_x, own_y = x + dx + offset, y + dy
                    page_x, page_y = own_x * cosine - own_y * sine, own_y * cosine + own_x * sine
                    if not inked(0, page_x, page_y, cells) and not inked(1, page_y, page_x, cells):
                        light += 1
            lit[row, column] = light / max(found, 1)


@njit(inline="always")
def _landed(x: float, y: float, tx: float, ty: float, sheet: TracedSheet) -> tuple[float, float, bool]:
    """Where a ray that crosses the apex plane at (x, y) from a lens's axis lands, from that axis; False if stopped."""
    pitch, radius = sheet.pitch, sheet.radius
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
        if abs(hit_x) <= pitch * 0.5 and abs(hit_y) <= pitch * 0.5:
            return through(
                axis_x + hit_x, axis_y + hit_y, depth, tx, ty, hit_x / radius, hit_y / radius, sheet.air, sheet
            )
        # A ray that has left its own square meets the neighbour on that side.
        if abs(hit_x) > pitch * 0.5:
            axis_x += pitch if hit_x > 0 else -pitch
        if abs(hit_y) > pitch * 0.5:
            axis_y += pitch if hit_y > 0 else -pitch
    return 0.0, 0.0, False
