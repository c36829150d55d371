"""The fast renderer: rays traced in closed form through true cylinder lenses, only where the board is.

Each pixel averages rays over its area.  A ray that meets the sheet is refracted at its lenticule (or a neighbour, at
steep angles), lands on the page, and finds ink or paper from the printed lines' own formula, so no texture limits the
page's sharpness.  Left out: Fresnel losses, glare, and the direction of the light.

Convention: board frame of `motion`, mm; the lens apex plane is z = -g; grating axes as in the badge.
Source: circle intersection and Snell's law in three dimensions; the same physics as `moireid.lenticule`, written
again for one ray at a time because a compiled loop shares nothing with arrays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MissingExtraError
from moireid.simulate.light import turned_light
from moireid.simulate.light_kernels import lamp_figures, lit
from moireid.simulate.scene import Instant, Scene

try:
    from numba import njit, prange
except ImportError as missing:  # pragma: no cover
    raise MissingExtraError("simulating needs numba; install it with: pip install 'moireid[simulate]'") from missing

Array = NDArray[np.float64]
#: Rays across and along a pixel.  The lens pitch is about a pixel, so it is the axis across the lenses that counts.
RAYS = (8, 2)
#: The page away from the gratings (markers) as a texture, pixels to the millimetre.
TEXTURE_PX_PER_MM = 12.0
#: What covers a part of the board: a hand, say.
HIDDEN_RADIANCE = 0.35


@dataclass(frozen=True)
class Rendered:
    """Linear radiance of the pixels that see the board, the share of each pixel that it covers, and their corner."""

    radiance: NDArray[np.float32]
    coverage: NDArray[np.float32]
    left: int
    top: int


class AnalyticRenderer:
    """Renders frames of one scene; tables and texture are made once."""

    def __init__(self, scene: Scene, *, rays: tuple[int, int] = RAYS) -> None:
        self.scene = scene
        lens = scene.badge.lens
        x, y = np.meshgrid((np.arange(rays[0]) + 0.5) / rays[0] - 0.5, (np.arange(rays[1]) + 0.5) / rays[1] - 0.5)
        # Shearing the grid keeps rays of different rows from crossing the lenses at the same places.
        self._jitter = np.column_stack([(x + (y + 0.5) / rays[0] - 0.5 / rays[0]).ravel(), y.ravel()])
        self._texture = page_texture(scene)
        self._cells, self._gratings = _tables(scene)
        self._lamps, self._lights = _lights(scene, self._gratings, rays)
        cx, cy = scene.board_centre_mm
        covered = scene.hidden_mm or (cx, cy, cx, cy)
        self._hidden = (np.array(covered) - (cx, cy, cx, cy)) * scene.build.print_scale
        build = scene.build
        self._lens = np.array([
            lens.pitch_mm * build.lens_scale, lens.thickness_mm, lens.refractive_index, lens.radius_mm or 0.0,
            build.lens_offset_mm, build.twist_rad, build.print_scale, lens.open_fraction or 0.0,
        ])  # fmt: skip

    def render(self, instant: Instant) -> Rendered | None:
        """Render one frame; None where no pixel sees the board."""
        camera = self.scene.camera
        box = self._box(instant)
        if box is None:
            return None
        left, top, right, bottom = box
        rows = (np.arange(top, bottom) - (camera.height - 1) / 2) / camera.height + 0.5
        centres = instant.first.camera_mm[0] * (1 - rows[:, None]) + instant.last.camera_mm[0] * rows[:, None]
        turns = instant.first.rotation[0] * (1 - rows[:, None, None]) + instant.last.rotation[0] * rows[:, None, None]
        shown = instant.shown_from_mm - (instant.first.camera_mm[0] + instant.last.camera_mm[0]) / 2
        radiance = np.zeros((bottom - top, right - left), np.float32)
        coverage = np.zeros_like(radiance)
        _trace(
            radiance, coverage, left, top, np.ascontiguousarray(centres), np.ascontiguousarray(turns),
            shown, camera.focal_px, (camera.width - 1) / 2, (camera.height - 1) / 2, self._jitter,
            np.array(self.scene.board_half_mm), self._lens, self._gratings, self._cells, self._texture,
            TEXTURE_PX_PER_MM, self.scene.ink, self.scene.paper, self._hidden, self._lamps,
            self._lights,
        )  # fmt: skip
        return Rendered(radiance, coverage, left, top)

    def _box(self, instant: Instant) -> tuple[int, int, int, int] | None:
        """Pixels that may see the board: the bounding box of its corners at first and last row."""
        half, camera = self.scene.board_half_mm, self.scene.camera
        corners = np.array([[sx * half[0], sy * half[1], 0.0] for sx in (-1, 1) for sy in (-1, 1)])
        seen = []
        for poses in (instant.first, instant.last):
            local = (corners * self.scene.build.print_scale - poses.camera_mm[0]) @ poses.rotation[0].T
            if local[:, 2].min() <= 1.0:
                return None
            seen.append((local / local[:, 2:]) @ camera.matrix.T)
        places = np.concatenate(seen)[:, :2]
        low, high = np.floor(places.min(axis=0)).astype(int) - 1, np.ceil(places.max(axis=0)).astype(int) + 2
        left, top = max(int(low[0]), 0), max(int(low[1]), 0)
        right, bottom = min(int(high[0]), camera.width), min(int(high[1]), camera.height)
        return (left, top, right, bottom) if left < right and top < bottom else None


def page_texture(scene: Scene) -> NDArray[np.float32]:
    """The board without its gratings: paper and markers, `TEXTURE_PX_PER_MM`, area-averaged."""
    badge, scale = scene.badge, TEXTURE_PX_PER_MM
    x0, y0, x1, y1 = badge.outline_mm
    picture = np.full((math.ceil((y1 - y0) * scale), math.ceil((x1 - x0) * scale)), scene.paper, np.float32)
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, badge.markers.dictionary))
    modules = known.markerSize + 2
    place_x = (np.arange(picture.shape[1]) + 0.5) / scale + x0
    place_y = (np.arange(picture.shape[0]) + 0.5) / scale + y0
    for identity, (cx, cy) in zip(badge.markers.ids, badge.markers.centers_mm, strict=True):
        bits = np.asarray(cv2.aruco.generateImageMarker(known, identity, modules)) > 127
        half = badge.markers.size_mm / 2
        columns = np.flatnonzero(np.abs(place_x - cx) < half)
        rows = np.flatnonzero(np.abs(place_y - cy) < half)
        module_x = ((place_x[columns] - cx + half) / badge.markers.size_mm * modules).astype(int)
        module_y = ((place_y[rows] - cy + half) / badge.markers.size_mm * modules).astype(int)
        picture[np.ix_(rows, columns)] = np.where(bits[np.ix_(module_y, module_x)], scene.paper, scene.ink)
    return picture


def _tables(scene: Scene) -> tuple[Array, Array]:
    """Cells as rows (x0, y0, x1, y1, pitch, edge, duty), and gratings (x0, y0, x1, y1, axis, first, end), board mm."""
    cx, cy = scene.board_centre_mm
    cells: list[list[float]] = []
    gratings: list[list[float]] = []
    for grating in scene.badge.gratings:
        axis = 0 if grating.axis == "x" else 1
        first = len(cells)
        for cell in grating.cells:
            x0, y0, x1, y1 = cell.rect_mm
            edge = cell.edge_mm - (cx, cy)[axis]
            cells.append([x0 - cx, y0 - cy, x1 - cx, y1 - cy, cell.pitch_mm, edge, cell.duty])
        x0, y0, x1, y1 = grating.rect_mm
        gratings.append([x0 - cx, y0 - cy, x1 - cx, y1 - cy, axis, first, len(cells)])
    return np.array(cells), np.array(gratings)


def _lights(scene: Scene, gratings: Array, rays: tuple[int, int]) -> tuple[Array, Array]:
    """Figures and table of the light for each grating, as `light_kernels.lit` wants them; zeros where none is told."""
    lamps, tables = np.zeros((len(gratings), 10)), [np.zeros((3, 1)) for _ in gratings]
    if scene.light is None:
        return lamps, np.stack(tables)
    build, lens = scene.build, scene.badge.lens
    as_built = replace(lens, pitch_mm=lens.pitch_mm * build.lens_scale)
    for k, (x0, y0, x1, y1, axis, _, _) in enumerate(gratings):
        name, twist, reach = ("x", build.twist_rad, (x0, x1)) if axis == 0 else ("y", -build.twist_rad, (y0, y1))
        light = turned_light(scene.light, name, twist, build.lens_offset_mm)
        lamps[k], tables[k] = lamp_figures(as_built, light, reach, 1.0 / scene.camera.focal_px / rays[int(axis)])
    rows = max(len(table) for table in tables)
    return lamps, np.stack([np.pad(table, ((0, rows - len(table)), (0, 0)), mode="edge") for table in tables])


@njit(cache=True, fastmath=False, error_model="numpy")
def _land(x: float, y: float, tx: float, ty: float, lens: Array) -> tuple[float, float, bool]:  # pragma: no cover
    """Where a ray that crosses the apex plane at (x, y), across and along the lenses, lands; False if stopped."""
    pitch, g, n, radius = lens[0], lens[1], lens[2], lens[3]
    length2 = 1.0 + tx * tx + ty * ty
    if radius == 0.0:
        # A line mask: the openings are centred where a sheet would have its axes.
        if abs(x / pitch - math.floor(x / pitch + 0.5)) > lens[7] / 2:
            return 0.0, 0.0, False
        depth_cosine = math.sqrt(n * n * length2 - tx * tx - ty * ty)
        return x + g * tx / depth_cosine, y + g * ty / depth_cosine, True
    axis = math.floor(x / pitch + 0.5) * pitch
    way = 1.0 if tx >= 0 else -1.0
    a = 1.0 + tx * tx
    for _ in range(4):
        offset = x - axis
        b = offset * tx - radius
        c = offset * offset
        root = b * b - a * c
        if root >= 0.0:
            depth = c / (-b + math.sqrt(root))
            hit = offset + tx * depth
            if abs(hit) <= pitch * 0.5 * (1.0 + 1e-12):
                length = math.sqrt(length2)
                nx, nz = hit / radius, (depth - radius) / radius
                cosine = -(tx * nx + nz) / length
                bend = cosine / n - math.sqrt(1.0 - (1.0 - cosine * cosine) / (n * n))
                vx = tx / length / n + bend * nx
                vy = ty / length / n
                vz = 1.0 / length / n + bend * nz
                return axis + hit + vx / vz * (g - depth), y + ty * depth + vy / vz * (g - depth), True
        axis += way * pitch
    return 0.0, 0.0, False


@njit(cache=True, parallel=True, fastmath=False, error_model="numpy")
def _trace(
    radiance: Any, coverage: Any, left: int, top: int, centres: Any, turns: Any, shown: Any, focal: float, cx: float,
    cy: float, jitter: Any, half: Any, lens: Any, gratings: Any, cells: Any, texture: Any, per_mm: float, ink: float,
    paper: float, hidden: Any, lamps: Any, lights: Any,
) -> None:  # fmt: skip  # pragma: no cover
    """Fill radiance (mean over the rays that meet the board) and coverage (their share), row by row in parallel."""
    g, offset, scale = lens[1], lens[4], lens[6]
    cos_twist, sin_twist = math.cos(lens[5]), math.sin(lens[5])
    for row in prange(radiance.shape[0]):
        centre, turn, last = centres[row], turns[row], 0
        for column in range(radiance.shape[1]):
            total, count = 0.0, 0
            for ray in range(jitter.shape[0]):
                u = (left + column + jitter[ray, 0] - cx) / focal
                v = (top + row + jitter[ray, 1] - cy) / focal
                dx = turn[0, 0] * u + turn[1, 0] * v + turn[2, 0]
                dy = turn[0, 1] * u + turn[1, 1] * v + turn[2, 1]
                dz = turn[0, 2] * u + turn[1, 2] * v + turn[2, 2]
                if dz <= 1e-9:
                    continue
                tx, ty = dx / dz, dy / dz
                page_x, page_y = centre[0] - centre[2] * tx, centre[1] - centre[2] * ty
                if abs(page_x) > half[0] * scale or abs(page_y) > half[1] * scale:
                    continue
                count += 1
                if hidden[0] <= page_x < hidden[2] and hidden[1] <= page_y < hidden[3]:
                    total += HIDDEN_RADIANCE
                    continue
                lens_x, lens_y = page_x - g * tx, page_y - g * ty
                value = -1.0
                for k in range(gratings.shape[0]):
                    if not (gratings[k, 0] <= lens_x <= gratings[k, 2] and gratings[k, 1] <= lens_y <= gratings[k, 3]):
                        continue
                    # The fringes are shown as from another place where the film is forged; else `shown` is zero.
                    depth = -(centre[2] + shown[2]) - g
                    fx = (lens_x - centre[0] - shown[0]) / depth
                    fy = (lens_y - centre[1] - shown[1]) / depth
                    # Across and along change places on a grating of the other axis, and so does the sense of a twist.
                    turn_sine = sin_twist if gratings[k, 4] == 0 else -sin_twist
                    ax, ay = (lens_x, lens_y) if gratings[k, 4] == 0 else (lens_y, lens_x)
                    bx, by = (fx, fy) if gratings[k, 4] == 0 else (fy, fx)
                    sx, sy = ax * cos_twist + ay * turn_sine - offset, ay * cos_twist - ax * turn_sine
                    rx, ry = bx * cos_twist + by * turn_sine, by * cos_twist - bx * turn_sine
                    lx, ly, through = _land(sx, sy, rx, ry, lens)
                    if not through:
                        value = ink
                        break
                    landed = lx
                    lx += offset
                    across, along = lx * cos_twist - ly * turn_sine, ly * cos_twist + lx * turn_sine
                    across, along = across / scale, along / scale
                    px, py = (across, along) if gratings[k, 4] == 0 else (along, across)
                    value = paper
                    # Rays next to one another mostly land in the same cell, so the search goes on from the last one.
                    first, end = int(gratings[k, 5]), int(gratings[k, 6])
                    for step in range(end - first):
                        c = first + (last + step) % (end - first)
                        if cells[c, 0] <= px < cells[c, 2] and cells[c, 1] <= py < cells[c, 3]:
                            place = (across - cells[c, 5]) / cells[c, 4]
                            if place - math.floor(place) < cells[c, 6]:
                                value = ink
                            last = c - first
                            break
                    if lamps[k, 9] > 0.0:
                        # Across the lenses a ray stands for its share of the pixel, widened by the slant.
                        step = depth * (1.0 + rx * rx) * lamps[k, 9]
                        value = lit(value, sx, sy, rx, ry, landed, step, lens, lamps[k], lights[k])
                    break
                if value < 0.0:
                    column_t = int((page_x / scale + half[0]) * per_mm)
                    row_t = int((page_y / scale + half[1]) * per_mm)
                    column_t = min(max(column_t, 0), texture.shape[1] - 1)
                    row_t = min(max(row_t, 0), texture.shape[0] - 1)
                    value = texture[row_t, column_t]
                total += value
            if count > 0:
                radiance[row, column] = total / count
                coverage[row, column] = count / jitter.shape[0]
