"""The fast renderer: rays traced in closed form through true cylinder lenses, only where the board is.

Each pixel averages rays over its area.  A ray that meets the sheet is refracted at its lenticule (or a neighbour, at
steep angles), lands on the page, and finds ink or paper from the printed lines' own formula, so no texture limits the
page's sharpness.  `quick` traces most pixels in float32, many rays at once; `trace` traces the rest, and all pixels
where float64 is asked for or the scene has a light.  Without a light, Fresnel losses and glare are left out.

Convention: board frame of `motion`, mm; the lens apex plane is z = -g; grating axes as in the badge.
Source: `trace`, `quick`; the rays of a pixel are a sheared grid, so that no two share a column or a row.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.analytic.light_kernels import lamp_figures
from moireid.simulate.analytic.page_light import light_rows, page_light
from moireid.simulate.analytic.rows import PLASTIC, trace_rows
from moireid.simulate.analytic.trace import TIMES, FrameView, TracedBoard
from moireid.simulate.analytic.traced_page import BLOCK_PX, TEXTURE_PX_PER_MM, cell_table, even_blocks, page_texture
from moireid.simulate.analytic.traced_sheet import sheet_as_built
from moireid.simulate.analytic.uneven_sheet import air_waves, lens_asides, lens_walk
from moireid.simulate.light import turned_light
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
#: Left, top, right, bottom of a part of the picture, px; right and bottom are not in it.
Crop = tuple[int, int, int, int]
#: Rays of a pixel, as a grid across and down it.
RAYS = (16, 1)
MOST_RAYS = 1 << 16
#: A moving pixel has so many times the rays, down it, as they are also spread over its exposure: with less, errors grow
#: fast, and with more they fall slowly (0.003 rad for 1/30 s by a moving hand).
EXPOSED = 3
#: No forged field: a badge seen from one place.  And unknown values for the blocks of a picture.
NO_FIELD, _UNEVEN = np.zeros((1, 1, 2)), np.full((1, 1), np.nan, np.float32)
#: Multiples of the golden ratio spread the rays of a row evenly over its height.
_GOLDEN = (math.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class BoardRadiance:
    """Linear radiance of the pixels that see the board, the share of each pixel that it covers, and their corner."""

    radiance: NDArray[np.float32]
    coverage: NDArray[np.float32]
    left: int
    top: int


class AnalyticRenderer:
    """Renders frames of one scene; tables and texture are made once.

    Parameters: rays: across and down a pixel, the cost is their product; times: as many more of a pixel that
        moves while it is exposed; precision: "float32" for the fast way,
        "float64" to trace every ray with care.
    Raises: SpecError where there are no rays, or a sheet's lenses do not meet.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        rays: tuple[int, int] = RAYS,
        times: int = EXPOSED,
        precision: Literal["float32", "float64"] = "float32",
    ) -> None:
        if min(rays) < 1 or math.prod(rays) > MOST_RAYS:
            raise SpecError(f"rays={rays} of a pixel cannot be traced; give 1 to {MOST_RAYS} in all")
        self.scene, self.rays, self.precision = scene, rays, precision
        self._points, self._exposed_points = (exposed_rays(*rays, count) for count in (1, times))
        self._sheet = sheet_as_built(scene)
        self._cells = cell_table(scene)
        cx, cy = scene.board_centre_mm
        covered = scene.hidden_mm or (math.inf,) * 4
        scale = scene.build.print_scales
        hidden = (np.array(covered) - (cx, cy, cx, cy)) * np.tile(scale, 2)
        half, texture = scene.printed_half_mm, page_texture(scene)
        lamps, lights = _lights(scene, math.prod(rays))
        self._board = TracedBoard(
            *half,
            hidden=hidden,
            ink=scene.ink,
            paper=scene.paper,
            texture=texture,
            even=even_blocks(texture),
            columns_per_mm=TEXTURE_PX_PER_MM / scale[0],
            rows_per_mm=TEXTURE_PX_PER_MM / scale[1],
            block=BLOCK_PX,
            lamps=lamps,
            lights=lights,
            field=NO_FIELD,
            places=lens_walk(scene),
            asides=lens_asides(scene),
            waves=air_waves(scene),
        )
        self._light = page_light(scene)

    def render(self, instant: Instant, *, crop: Crop | None = None) -> BoardRadiance | None:
        """Render one frame; None where no pixel sees the board.

        Parameters: crop: left, top, right, bottom of the pixels to trace, None for all that may see the board.
        """
        camera = self.scene.camera
        box = crop or board_box(self.scene, instant.first, instant.last)
        if box is None:
            return None
        left, top, right, bottom = box
        whole = board_box(self.scene, instant.first, instant.last) or box
        rows = (np.arange(top, bottom) - (camera.height - 1) / 2) / camera.height + 0.5
        centres, turns = (
            np.multiply.outer(1 - rows, at_exposure(first)) + np.multiply.outer(rows, at_exposure(last))
            for first, last in (
                (instant.first.camera_mm, instant.last.camera_mm),
                (instant.first.rotation, instant.last.rotation),
            )
        )
        shown = at_exposure(instant.shown_from_mm - (instant.first.camera_mm + instant.last.camera_mm) / 2)
        moving = len(instant.first.camera_mm) > 1
        cells, board = self._cells, self._board
        picture = instant.picture
        if picture is not None:
            per_mm = picture.shape[1] / (2 * self.scene.printed_half_mm[0])
            cells = cells._replace(gratings=cells.gratings[:0])
            board = board._replace(texture=picture, even=_UNEVEN, columns_per_mm=per_mm, rows_per_mm=per_mm)
        if instant.field is not None:
            board = board._replace(field=instant.field)
        view = FrameView(
            corner_x=left - camera.matrix[0, 2],
            corner_y=top - camera.matrix[1, 2],
            first_column=left - whole[0],
            first_row=top - whole[1],
            focal=camera.focal_px,
            centres=centres,
            turns=turns,
            distortion=np.array(camera.distortion, float),
            shown=shown,
            points=self._exposed_points if moving else self._points,
            moving=moving,
            quick=self._is_quick,
        )
        radiance, coverage = np.zeros((2, bottom - top, right - left), np.float32)
        trace_rows(radiance, coverage, view, self._sheet, cells, board)
        if self._light is not None and instant.picture is None:
            light_rows(radiance, view, self._sheet, self._light)
        return BoardRadiance(radiance, coverage, left, top)

    @property
    def _is_quick(self) -> bool:
        """Whether pixels need no `trace` for what the sheet and the light are."""
        build = self.scene.build
        careful = build.air_gap_mm > 0 or build.conic != 0 or build.is_uneven or build.is_bent
        return self.precision == "float32" and self.scene.light is None and not careful


def at_exposure(values: Array) -> Array:
    """Figures at instants evenly over an exposure (T, ...), as at its `TIMES` (5, ...).

    Source: a polynomial of fourth order or less through them, by least squares.
    """
    count = len(values)
    order = min(count, len(TIMES))
    fitted = np.vander(TIMES, order) @ np.linalg.pinv(np.vander((np.arange(count) + 0.5) / count - 0.5, order))
    return np.asarray(np.tensordot(fitted, values, axes=1))


def board_box(scene: Scene, *views: Poses) -> Crop | None:
    """Pixels that may see the board from any of some poses (one each); None where none does.

    Convention: one pixel to spare on each side, cut to the picture.
    Source: the board's outline, as the camera projects it.
    """
    camera, half = scene.camera, scene.printed_half_mm
    # Distortion bends the edges outwards between the corners, so points along the edges are projected too.
    way = np.linspace(-1, 1, 9)
    outline = np.array([[s * half[0], e * half[1], 0.0] for s in way for e in way if {s, e} & {-1.0, 1.0}])
    if scene.build.is_bent:
        # Seen at an angle, a bent board reaches beyond the flat one, and its middle beyond its bent edges.
        sunk = outline + np.column_stack([np.zeros((len(outline), 2)), scene.sunk_mm(*outline[:, :2].T)])
        outline = np.concatenate([outline, sunk])
    local = np.concatenate(
        [
            (outline - centre) @ turn.T
            for view in views
            for centre, turn in zip(view.camera_mm, view.rotation, strict=True)
        ]
    )
    if local[:, 2].min() <= 1.0:
        return None
    places = camera.project(local)
    low, high = np.floor(places.min(axis=0)).astype(int) - 1, np.ceil(places.max(axis=0)).astype(int) + 2
    left, top = max(int(low[0]), 0), max(int(low[1]), 0)
    right, bottom = min(int(high[0]), camera.width), min(int(high[1]), camera.height)
    return (left, top, right, bottom) if left < right and top < bottom else None


def _lights(scene: Scene, rays: int) -> tuple[Array, Array]:
    """Figures and table of the light for each grating, for `light_kernels.lit`; zeros in a scene without a light."""
    gratings = scene.badge.gratings
    lamps, tables = np.zeros((len(gratings), 10)), [np.zeros((3, 1)) for _ in gratings]
    if scene.light is None:
        return lamps, np.stack(tables)
    as_built = replace(scene.lens, pitch_mm=scene.lens.pitch_mm * scene.build.lens_scale)
    for k, grating in enumerate(gratings):
        low, _, high, _ = scene.own_rect_mm(grating, grating.rect_mm)
        frame, build = scene.badge.frame_of(grating), scene.build
        light = turned_light(scene.light, frame, build.twist_rad, build.lens_offset_mm)
        lamps[k], tables[k] = lamp_figures(as_built, light, (low, high), 1.0 / scene.camera.focal_px / rays)
    rows = max(len(table) for table in tables)
    return lamps, np.stack([np.pad(table, ((0, rows - len(table)), (0, 0)), mode="edge") for table in tables])


def exposed_rays(across: int, down: int, times: int) -> NDArray[np.float32]:
    """Places of a pixel's rays in it, and their times in its exposure: (3, across * down * times), -1/2 to 1/2.

    Parameters: times: so many times the rays down the pixel, and as many times; 1 for an instant, in the middle.
    Convention: x to the right, y down.  The rays make a grid of across by down; within its
    field each is moved so that all x differ by even steps, all y, and all times.
    """
    down *= times
    column, row = (number.ravel() for number in np.meshgrid(np.arange(across), np.arange(down)))
    x = (column + (row + 0.5) / down) / across - 0.5
    y = (row + (_rank(np.arange(across) * _GOLDEN)[column] + 0.5) / across) / down - 0.5
    time = (_rank(_rank(x + 0.5) * PLASTIC) + 0.5) / len(x) - 0.5 if times > 1 else np.zeros_like(x)
    return np.ascontiguousarray([x, y, time], np.float32)


def _rank(turns: NDArray[Any]) -> NDArray[np.int64]:
    """Rank of each number's fraction among all fractions."""
    return np.argsort(np.argsort(turns % 1.0))
