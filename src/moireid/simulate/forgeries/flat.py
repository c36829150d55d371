"""Flat forgeries: a printed photograph of the badge, and a film of the badge replayed on a screen.

In a scene with a light, the forger's picture already has its bands and glare.  When it is filmed it shines evenly, as
the page around it does, so that no light counts twice.

Both show one picture of the whole badge as seen from one place, straightened, at true size and with the true markers.
The forger is a good one: tones are exact, the picture is flat, and it has no gloss.

The screen plays a film that was straightened by its markers.  So the badge stays still on the screen, and its fringes
move with the replayed camera, whose motion has the true spread.  Each frame is held for 1/30 s.  Left out are the
screen's glow, its black level, and its pixels, which are far finer than a camera's pixel at such distances.
If the filming camera stays still, the screen shows a true film, and no law of motion can find the forgery.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.renderer import AnalyticRenderer
from moireid.simulate.cameras import Camera
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
#: Fineness of the photograph: four pixels or more to a lens, so it shows the lenses themselves.
PHOTO_PX_PER_MM = 8.0
#: Fineness of the replayed film: what a film of 2160 rows sees from 1 m.
SCREEN_PX_PER_MM = 3.0
SCREEN_FPS = 30.0


def held_frames(count: int, fps: float) -> NDArray[np.int64]:
    """Which frame the screen shows at each of a film's frames (T,): the last that came due at `SCREEN_FPS`.

    In a film with fewer frames a second than the screen, each frame shows another one of the screen.
    """
    if fps <= SCREEN_FPS:
        return np.arange(count)
    due = np.floor(np.arange(count) / fps * SCREEN_FPS + 1e-6) / SCREEN_FPS
    return np.floor(due * fps + 1e-6).astype(np.int64)


class SquaredUp:
    """Straightened pictures of the board as seen from a place: what a forger prints, or plays on a screen."""

    def __init__(self, scene: Scene, per_mm: float) -> None:
        self._scene = replace(scene, hidden_mm=None)
        half = scene.printed_half_mm
        columns = max(round(2 * half[0] * per_mm), 2)
        self._per_mm = columns / (2 * half[0])
        self._size = (math.ceil(2 * half[1] * self._per_mm), columns)
        self._renderer = AnalyticRenderer(self._scene)

    def picture(self, camera_mm: Array) -> NDArray[np.float32]:
        """Radiance (rows, columns) over the whole board as seen from `camera_mm` (3,)."""
        half = self._scene.printed_half_mm
        # A camera that faces the board squarely sees it at one scale; its place says where the view axis falls.
        axis = [(half[k] + float(camera_mm[k])) * self._per_mm - 0.5 for k in (0, 1)]
        focal = self._per_mm * abs(float(camera_mm[2]))
        camera = Camera(self._size[1], self._size[0], focal, shutter_s=0.0, principal_px=(axis[0], axis[1]))
        self._renderer.scene = replace(self._scene, camera=camera)
        pose = Poses(camera_mm[None], np.eye(3)[None])
        seen = self._renderer.render(Instant(pose, pose, camera_mm))
        picture = np.full(self._size, self._scene.paper, np.float32)
        if seen is not None:
            rows, columns = seen.radiance.shape
            picture[seen.top : seen.top + rows, seen.left : seen.left + columns] = seen.radiance
        return picture
