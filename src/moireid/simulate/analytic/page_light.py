"""What changes a badge's brightness from place to place: bands of the print, haze of the sheet, light from one side.

All three are smooth over a pixel, so they are applied once to each pixel of a traced picture; a badge without them
takes no time.

Convention: maps over the board as printed, `MAP_PX_PER_MM` to the millimetre, from its top left.
Source: haze scatters a share of the light in the sheet, so that it comes from places of the page all around.  These
cover several lines, so what they add does not depend on the view: it takes (1 - haze) of the fringes' contrast.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.trace import FrameView, on_page
from moireid.simulate.analytic.traced_page import TEXTURE_PX_PER_MM, page_texture
from moireid.simulate.analytic.traced_sheet import TracedSheet
from moireid.simulate.build import BAND_MM, HAZE_MM
from moireid.simulate.cameras import undistorted
from moireid.simulate.compiled import njit, prange
from moireid.simulate.scene import Scene

Map = NDArray[np.float32]
MAP_PX_PER_MM = 2.0
#: Weights of an exposure's middle, begin and end.
SIMPSON = (2 / 3, 1 / 6, 1 / 6)
#: Numbers that keep the chances of one badge apart.
BAND = 0xBA2D


class PageLight(NamedTuple):
    """factor: of a place's brightness; mixed: share of it that comes from all around; around: how bright that is."""

    factor: Map
    mixed: Map
    around: Map
    half_x: float
    half_y: float


def page_light(scene: Scene) -> PageLight | None:
    """The maps of a scene, None where the build changes no brightness."""
    build = scene.build
    if not (build.banding or build.haze or build.side_light):
        return None
    (half_x, half_y), (wide, high) = scene.printed_half_mm, scene.board_half_mm
    shape = (math.ceil(2 * high * MAP_PX_PER_MM), math.ceil(2 * wide * MAP_PX_PER_MM))
    rows, columns = (np.arange(count) + 0.5 for count in shape)
    turn = 2 * math.pi * np.random.default_rng([BAND, build.seed]).uniform()
    band = 1 + build.banding * np.sin(2 * math.pi * rows / MAP_PX_PER_MM / BAND_MM + turn)
    # The brightest edge is as bright as without, as exposure follows the light.
    side = (1 + build.side_light * (2 * columns / shape[1] - 1)) / (1 + abs(build.side_light))
    factor = np.outer(band, side).astype(np.float32)
    sheets, around = _haze(scene, shape)
    return PageLight(factor, np.float32(build.haze) * sheets, around, half_x, half_y)


def _haze(scene: Scene, shape: tuple[int, int]) -> tuple[Map, Map]:
    """Where there is a sheet, 0 to 1; and the page's brightness about each place, the lines by their mean."""
    page = page_texture(scene)
    sheets = np.zeros_like(page)
    x0, y0 = scene.badge.outline_mm[:2]
    for grating in scene.badge.gratings:
        frame = scene.badge.frame_of(grating)
        for cell in grating.cells:
            low, begin, high, end = cell.rect_mm
            corners = frame.vectors(np.array([[low, begin], [high, begin], [high, end], [low, end]]))
            outline = [np.rint((corners - (x0, y0)) * TEXTURE_PX_PER_MM).astype(np.int32)]
            duty = scene.printed_line(cell)[1]
            cv2.fillPoly(page, outline, scene.paper + duty * (scene.ink - scene.paper))
            cv2.fillPoly(sheets, outline, 1.0)
    soft = cv2.GaussianBlur(page, (0, 0), HAZE_MM / 2 * TEXTURE_PX_PER_MM)
    size = shape[::-1]
    return tuple(np.asarray(cv2.resize(one, size, interpolation=cv2.INTER_AREA)) for one in (sheets, soft))  # type: ignore[return-value]


@njit(cache=True, parallel=True)
def light_rows(radiance: Any, view: FrameView, sheet: TracedSheet, light: PageLight) -> None:
    """Change the radiance (rows, columns) of a traced picture by the maps, at the middle of each pixel.

    Source: Simpson's rule over the exposure.
    """
    for row in prange(radiance.shape[0]):
        _row(row, radiance[row], view, sheet, light)


@njit(inline="always")
def _row(row: int, radiance: Any, view: FrameView, sheet: TracedSheet, light: PageLight) -> None:
    """One row of `light_rows`."""
    per_focal, centres, turns = 1.0 / view.focal, view.centres[row], view.turns[row]
    bent = np.any(view.distortion != 0.0)
    per_mm_x, per_mm_y = light.factor.shape[1] / (2 * light.half_x), light.factor.shape[0] / (2 * light.half_y)
    for column in range(radiance.shape[0]):
        u, v = (column + view.corner_x) * per_focal, (row + view.corner_y) * per_focal
        if bent:
            u, v = undistorted(u, v, view.distortion)
        kept, added = 0.0, 0.0
        for k in range(len(SIMPSON) if view.moving else 1):
            turn, share = turns[k], SIMPSON[k] if view.moving else 1.0
            dz = max(turn[0, 2] * u + turn[1, 2] * v + turn[2, 2], 1e-9)
            tx = (turn[0, 0] * u + turn[1, 0] * v + turn[2, 0]) / dz
            ty = (turn[0, 1] * u + turn[1, 1] * v + turn[2, 1]) / dz
            place = on_page(tx, ty, centres[k], sheet)
            i = int(min(max((place[3] + light.half_y) * per_mm_y, 0.0), light.factor.shape[0] - 1.0))
            j = int(min(max((place[2] + light.half_x) * per_mm_x, 0.0), light.factor.shape[1] - 1.0))
            kept += share * light.factor[i, j] * (1.0 - light.mixed[i, j])
            added += share * light.factor[i, j] * light.mixed[i, j] * light.around[i, j]
        radiance[column] = kept * radiance[column] + added
