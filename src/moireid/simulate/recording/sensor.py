"""From radiance to 8-bit pictures: background, lens blur, exposure, noise, and a phone's sharpening.

Convention: the background is at infinity and turns with the camera; it is so smooth that it needs no distortion and
no motion blur.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.renderer import Rendered
from moireid.simulate.cameras import Camera
from moireid.simulate.compiled import njit, prange
from moireid.simulate.scene import Need

#: Frequency of the exposure's drift, as automatic exposure wanders over some seconds.
DRIFT_HZ = 0.17
#: Share of the noise's variance that does not depend on the light (read noise).
READ_SHARE = 0.3
#: Standard deviation of lens and demosaicing blur, px, and of the unsharp mask, px.
BLUR_PX, SHARPEN_PX = 0.5, 1.2
#: The clouds are smooth, so they are kept, and turned, at a quarter of the size at which they are seen.
COARSE = 4
#: Radiance of the darkest and the span of the clouds; between them lies the even grey of a film without background.
DARKEST, SPAN = 0.12, 0.25


class Sensor:
    """Turns rendered boards into pictures; the random parts come from one seed."""

    def __init__(self, camera: Camera, seed: int, *, need: Need | None = None) -> None:
        self._camera, self._shows_background = camera, (need or Need()).background
        self._rng = np.random.default_rng(seed)
        self._phase = self._rng.uniform(0, 2 * np.pi)
        height, width = camera.height, camera.width
        # Coarse and fine clouds, twice the picture's size, so that turning the camera shows other parts of them.
        size = (max(2 * width // COARSE, 2), max(2 * height // COARSE, 2))
        clouds = [
            cv2.resize(self._rng.random(grains).astype(np.float32), size, interpolation=cv2.INTER_CUBIC)
            for grains in ((9, 16), (36, 64), (135, 240))
        ]
        self._world = (DARKEST + SPAN * (0.5 * clouds[0] + 0.3 * clouds[1] + 0.2 * clouds[2])).astype(np.float32)
        # One field of noise, read from a random place each frame: drawing two million numbers a frame takes longer
        # than rendering the badge.
        self._noise = self._rng.standard_normal((height + 256, width + 256)).astype(np.float32)
        self._behind = np.empty((-(-height // COARSE), -(-width // COARSE)), np.float32)
        self._scene = np.empty((height, width), np.float32)
        self._toned = np.empty((height, width), np.float32)

    def expose(self, board: Rendered | None, rotation: NDArray[np.float64], time_s: float) -> NDArray[np.uint8]:
        """One picture (height, width) uint8.

        Convention: rotation board -> camera; the background is at infinity and turns with it.
        """
        camera, scene = self._camera, self._scene
        if self._shows_background:
            self._paint(rotation)
        else:
            scene.fill(DARKEST + SPAN / 2)
        if board is not None:
            self._place(board)
        drift = 1 + camera.exposure_drift * math.sin(2 * math.pi * DRIFT_HZ * time_s + self._phase)
        place = self._rng.integers(0, 256, 2)
        field = self._noise[place[0] : place[0] + camera.height, place[1] : place[1] + camera.width]
        _tone(self._toned, scene, np.float32(camera.exposure * drift), field, np.float32(camera.noise_counts))
        if camera.sharpen:
            soft = cv2.GaussianBlur(self._toned, (0, 0), SHARPEN_PX)
            picture = cv2.addWeighted(self._toned, 1 + camera.sharpen, soft, -camera.sharpen, 0, dtype=cv2.CV_8U)
        else:
            picture = cv2.convertScaleAbs(self._toned)
        return np.asarray(cv2.flip(picture, 1) if camera.mirror else picture, dtype=np.uint8)

    def _paint(self, rotation: NDArray[np.float64]) -> None:
        """Fill the scene with the clouds as the turned camera sees them."""
        camera = self._camera
        to_world = np.array([[1, 0, camera.width / 2], [0, 1, camera.height / 2], [0, 0, COARSE]]) / COARSE
        to_world = to_world @ camera.matrix @ rotation.T @ np.linalg.inv(camera.matrix)
        # Pixel centres are whole numbers on both scales, so their origins are half a pixel apart.
        steps = camera.width / self._behind.shape[1], camera.height / self._behind.shape[0]
        spread = np.array([[steps[0], 0, steps[0] / 2 - 0.5], [0, steps[1], steps[1] / 2 - 0.5], [0, 0, 1.0]])
        _background(self._behind, self._world, to_world @ spread)
        cv2.resize(self._behind, (camera.width, camera.height), dst=self._scene, interpolation=cv2.INTER_LINEAR)

    def _place(self, board: Rendered) -> None:
        """Lay the board over the background, and blur both as the lens does."""
        scene = self._scene
        rows = slice(board.top, board.top + board.radiance.shape[0])
        columns = slice(board.left, board.left + board.radiance.shape[1])
        behind = scene[rows, columns]
        behind += board.coverage * (board.radiance - behind)
        blur = math.hypot(BLUR_PX, self._camera.focus_blur_px)
        margin = math.ceil(4 * blur) + 2
        grown = (
            slice(max(board.top - margin, 0), rows.stop + margin),
            slice(max(board.left - margin, 0), columns.stop + margin),
        )
        scene[grown] = cv2.GaussianBlur(scene[grown], (0, 0), blur)


@njit(cache=True, parallel=True, error_model="numpy")
def _background(scene: Any, world: Any, to_world: Any) -> None:  # pragma: no cover
    """Fill the scene (H, W) with the clouds as the turned camera sees them; beyond their edge they are reflected."""
    rows, columns = world.shape
    for row in prange(scene.shape[0]):
        for column in range(scene.shape[1]):
            w = to_world[2, 0] * column + to_world[2, 1] * row + to_world[2, 2]
            # Directions behind the camera have no place on the clouds; they show the clouds' rim.
            scale = 1.0 / max(w, 1e-3)
            x = abs((to_world[0, 0] * column + to_world[0, 1] * row + to_world[0, 2]) * scale)
            y = abs((to_world[1, 0] * column + to_world[1, 1] * row + to_world[1, 2]) * scale)
            x -= math.floor(x / (2 * (columns - 1))) * (2 * (columns - 1))
            y -= math.floor(y / (2 * (rows - 1))) * (2 * (rows - 1))
            x = min(x, 2 * (columns - 1) - x)
            y = min(y, 2 * (rows - 1) - y)
            i, j = min(int(y), rows - 2), min(int(x), columns - 2)
            b, a = np.float32(y - i), np.float32(x - j)
            above = world[i, j] + a * (world[i, j + 1] - world[i, j])
            below = world[i + 1, j] + a * (world[i + 1, j + 1] - world[i + 1, j])
            scene[row, column] = above + b * (below - above)


@njit(cache=True, parallel=True, error_model="numpy")
def _tone(toned: Any, scene: Any, gain: Any, noise: Any, counts: Any) -> None:  # pragma: no cover
    """Counts (H, W), 0 to 255 and not yet whole: exposed, clipped, coded by a square root, noisy, clipped again.

    The square root stands for a camera's transfer curve; noise is added after it, where it is about even.
    """
    read, shot = np.float32(READ_SHARE), np.float32(1 - READ_SHARE)
    for row in prange(scene.shape[0]):
        for column in range(scene.shape[1]):
            coded = math.sqrt(min(max(scene[row, column] * gain, np.float32(0)), np.float32(1)))
            value = np.float32(255) * coded + noise[row, column] * counts * math.sqrt(read + shot * coded)
            toned[row, column] = min(max(value, np.float32(0)), np.float32(255))
