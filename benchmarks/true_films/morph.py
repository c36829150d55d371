"""Stills of a badge, morphed into each other by optical flow, put where another trajectory asks for their views.

The forger knows nothing of the law but that fringes move with the camera.  Each column of a field (each row, where it
senses y) shows the mix of two neighbouring stills that its own parallax asks for: u = (C_x - x) / C_z, C being the
camera's place, mm, and x the column's.  So the fringes' spacing follows the distance, too.

Convention: mix 0 is the first still, 1 the second; a pixel that goes by f from the first to the second is at mix a of
    the way where it has gone by a f.
Source: optical flow of dense inverse search (Kroeger et al. 2016), as OpenCV has it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Grating
from moireid.simulate.forgeries.rear_layer import ShownViews
from moireid.simulate.motion import Motion, Poses
from moireid.simulate.scene import Scene
from true_films.clip import FPS, Array, Clip, Picture, filmed_clip
from true_films.paths import aimed
from true_films.replay import RIM_MM, along, box_px, page_mm

Box = tuple[slice, slice]


def stills(scene: Scene, views: Array, seed: int) -> Clip:
    """Stills of a true film, one from each of these views (N, 3)."""
    places = views[:, 2:] * np.column_stack([views[:, :2], -np.ones(len(views))])

    def motion(times_s: Array) -> Poses:
        number = np.clip(np.rint(np.asarray(times_s) * FPS).astype(int), 0, len(places) - 1)
        return aimed(places[number], np.zeros((len(number), 3)))

    return filmed_clip(scene, motion, len(places), seed)


@dataclass(frozen=True)
class Morph:
    """How stills are shown.  alone: each cell of the badge is morphed by itself, so that none drags its neighbours."""

    stills: Clip
    alone: bool = False

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """What shows it in a film, as `simulate.filming.film` takes it."""
        drawn = self.drawn(scene)
        return ShownViews(camera_mm, camera_mm, picture=lambda frame: drawn(camera_mm[frame]))

    def drawn(self, scene: Scene) -> Callable[[Array], Picture]:
        """What draws the board, as light, for a camera at (3,) in the badge's frame, mm."""
        pieces = [
            _Piece(scene, grating, box, self.stills)
            for grating in scene.badge.gratings
            for box in self._boxes(scene, grating)
        ]
        blank = self.stills.picture(0)

        def picture(place_mm: Array) -> Picture:
            made = blank.copy()
            for piece in pieces:
                made[piece.box] = piece.at(place_mm)
            return np.square(made)

        return picture

    def _boxes(self, scene: Scene, grating: Grating) -> Sequence[Box]:
        if self.alone:
            return [box_px(scene.badge, cell.rect_mm) for cell in grating.cells]
        return [box_px(scene.badge, grating.rect_mm, RIM_MM)]


class _Piece:
    """A part of the badge, in each frame of the forged film."""

    def __init__(self, scene: Scene, grating: Grating, box: Box, stills: Clip) -> None:
        badge, self._axis, self.box = scene.badge, along(grating), box
        left, top, right, bottom = badge.outline_mm
        middle = ((left + right) / 2, (top + bottom) / 2)[self._axis]
        self._along_mm = page_mm(badge, box)[self._axis] - middle
        order = np.argsort(stills.views[:, self._axis])
        views = stills.views[order]
        self._seen = [stills.pictures[k][box] for k in order.tolist()]
        self._still_u = views[:, self._axis, None] - self._along_mm / views[:, 2, None]
        flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        self._flows = [_flow(flow, *pair) for pair in zip(self._seen, self._seen[1:], strict=False)]
        rows, columns = self._seen[0].shape
        self._grid = np.meshgrid(np.arange(columns, dtype=np.float32), np.arange(rows, dtype=np.float32))

    def at(self, camera_mm: Array) -> Picture:
        """Its picture, of a camera at (3,), in coded brightness, 0 to 1."""
        wanted = (camera_mm[self._axis] - self._along_mm) / abs(camera_mm[2])
        middle = len(wanted) // 2
        later = int(np.searchsorted(self._still_u[:, middle], wanted[middle]))
        pair = min(max(later - 1, 0), len(self._flows) - 1)
        before, after = self._still_u[pair : pair + 2]
        mix = ((wanted - before) / (after - before)).astype(np.float32)
        mix = mix[None, :] if self._axis == 0 else mix[:, None]
        first = self._moved(pair, mix, self._flows[pair])
        second = self._moved(pair + 1, mix - 1, self._flows[pair])
        return np.asarray(np.clip(((1 - mix) * first + mix * second) / 255, 0, 1), np.float32)

    def _moved(self, still: int, gone: NDArray[np.float32], flow: NDArray[np.float32]) -> Picture:
        """A still whose pixels have gone so much of the way."""
        x, y = (at - gone * flow[..., k] for k, at in enumerate(self._grid))
        picture = self._seen[still].astype(np.float32)
        return np.asarray(cv2.remap(picture, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.float32)


def _flow(flow: cv2.DISOpticalFlow, first: NDArray[np.uint8], second: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Where each pixel of the first picture is in the second, less where it is in the first, px, (rows, columns, 2)."""
    # A cell is smaller than the patches that are searched for.
    rim = 16
    wide = [cv2.copyMakeBorder(one, rim, rim, rim, rim, cv2.BORDER_REPLICATE) for one in (first, second)]
    return np.asarray(flow.calc(*wide, None)[rim:-rim, rim:-rim], np.float32)
