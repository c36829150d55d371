"""The camera's pictures, each made once when it is asked for: rendered, exposed, and changed by every effect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.analytic_renderer import BoardRadiance
from moireid.simulate.effects.effect import Step, Take
from moireid.simulate.forgeries.rear_layer import ShownViews
from moireid.simulate.motion import Motion, Poses
from moireid.simulate.recording.sensor import Sensor, opened
from moireid.simulate.scene import Instant, Scene
from moireid.simulate.settings.painting import Painter, chroma_of, light_of
from moireid.simulate.truth import Stages

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
Render = Callable[[Instant], BoardRadiance | None]
#: A finished picture changed: frame, picture (height, width), homography page mm -> px of the middle row.
Edit = Callable[[int, Luma, Array], Luma]
#: A frame of the file is mixed of this many of the camera's frames at most.
KEPT = 5


class Shot(NamedTuple):
    """One picture of the camera, (height, width), the pose of its middle row, the forged field, and its colours."""

    luma: Luma
    pose: Poses
    field: Array | None
    chroma: tuple[Luma, Luma] | None = None


@dataclass
class Shots:
    """The camera's pictures by number, at `fps`, to be asked for in order; those asked for last are kept.

    longest_s: a row's exposure at most; painter: of what is around the badge, None for clouds.  Colours are the
    painter's, where nothing changes the pictures afterwards.
    """

    scene: Scene
    motion: Motion
    shown: ShownViews
    fps: float
    longest_s: float
    render: Render
    sensor: Sensor
    steps: Sequence[Step]
    edit: Edit | None
    stages: Stages
    painter: Painter | None = None

    def __post_init__(self) -> None:
        self._kept: dict[int, Shot] = {}

    def at(self, number: int) -> Shot:
        """The picture of this number."""
        if number not in self._kept:
            self._kept[number] = self._made(number)
            if len(self._kept) > KEPT:
                del self._kept[min(self._kept)]
        return self._kept[number]

    def mixed(self, parts: Sequence[tuple[int, float]]) -> tuple[Luma, int, Shot]:
        """Several pictures mixed by their weights; and number and picture of the one that weighs most."""
        shots = {number: self.at(number) for number, _ in parts}
        heaviest = max(parts, key=lambda part: part[1])[0]
        if len(parts) == 1:
            return shots[heaviest].luma, heaviest, shots[heaviest]
        total = sum(np.float32(weight) * shots[number].luma for number, weight in parts)
        return np.asarray(np.rint(total), np.uint8), heaviest, shots[heaviest]

    def _made(self, number: int) -> Shot:
        time_s = number / self.fps
        self.stages.begin()
        pose, opening = opened(self.motion, self.scene.camera, self.scene.board_half_mm, time_s, 1 / self.longest_s)
        instant = self.shown.instant(number, opening)
        board = self.render(instant)
        self.stages.end("render")
        behind, chroma = None, None
        if self.painter:
            first, _, last = opening
            around = self.painter.paint(*(one.one(len(one.camera_mm) // 2) for one in (first, last)))
            behind = light_of(around)
            if not self.steps and not self.edit:
                chroma = chroma_of(around, mirror=self.scene.camera.mirror)
        luma = self.sensor.expose(board, pose.rotation[0], time_s, behind)
        if self.edit:
            luma = self.edit(number, luma, page_homographies(self.scene, pose)[0])
        for step in self.steps:
            luma = step(number, luma)
        self.stages.end("sensor")
        return Shot(luma, pose, instant.field, chroma)


def page_homographies(scene: Scene, poses: Poses) -> Array:
    """Page mm -> px of each pose, (T, 3, 3), by the camera without distortion, not mirrored."""
    (cx, cy), (x, y) = scene.board_centre_mm, scene.build.print_scales
    board = np.array([[x, 0, -x * cx], [0, y, -y * cy], [0, 0, 1.0]])
    away = -np.einsum("tij,tj->ti", poses.rotation, poses.camera_mm)
    local = np.stack([poses.rotation[:, :, 0], poses.rotation[:, :, 1], away], axis=-1)
    return np.asarray(scene.camera.matrix @ local @ board)


def take_of(scene: Scene, poses: Poses, fps: float, seed: int) -> Take:
    """What effects may know of a film, before any of them."""
    camera = scene.camera
    rects = np.array([scene.badge.bounds_of(grating) for grating in scene.badge.gratings])
    (x0, y0), (x1, y1) = rects[:, :2].min(axis=0), rects[:, 2:].max(axis=0)
    pages = page_homographies(scene, poses)
    if camera.mirror:
        pages = np.array([[-1.0, 0, camera.width - 1], [0, 1, 0], [0, 0, 1]]) @ pages
    middle = (float(x0 + x1) / 2, float(y0 + y1) / 2)
    return Take(pages, poses, camera.focal_px, middle, scene.badge.outline_mm, (camera.width, camera.height), fps, seed)
