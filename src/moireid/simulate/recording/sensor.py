"""From radiance to 8-bit pictures: background, lens blur, exposure, noise, and a phone's sharpening.

Convention: the background is at infinity and turns with the camera; it is so smooth that it needs no distortion and
no motion blur.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

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


NO_PATCH = np.zeros((0, 0), np.float32)


class Light(NamedTuple):
    """What falls on the sensor: the background's coarse rows at full width, the patch with the board and its place,
    px, and the exposure."""

    wide: NDArray[np.float32]
    patch: NDArray[np.float32]
    top: int
    left: int
    gain: np.float32


class Grain(NamedTuple):
    """A frame's noise: a field larger than the picture, where the picture begins in it, and its deviation, counts."""

    noise: NDArray[np.float32]
    top: int
    left: int
    counts: np.float32


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
        self._behind = np.full((-(-height // COARSE), -(-width // COARSE)), DARKEST + SPAN / 2, np.float32)

    def expose(self, board: Rendered | None, rotation: NDArray[np.float64], time_s: float) -> NDArray[np.uint8]:
        """One picture (height, width) uint8.

        Convention: rotation board -> camera; the background is at infinity and turns with it.
        """
        camera = self._camera
        if self._shows_background:
            self._paint(rotation)
        # The clouds at full width; the rows between them are interpolated as each is developed.
        wide = cv2.resize(self._behind, (camera.width, self._behind.shape[0]), interpolation=cv2.INTER_LINEAR)
        patch, top, left = NO_PATCH, 0, 0
        if board is not None:
            patch, top, left = self._with_board(board, wide)
        drift = 1 + camera.exposure_drift * math.sin(2 * math.pi * DRIFT_HZ * time_s + self._phase)
        place = self._rng.integers(0, 256, 2)
        grain = Grain(self._noise, int(place[0]), int(place[1]), np.float32(camera.noise_counts))
        light = Light(wide, patch, top, left, np.float32(camera.exposure * drift))
        picture = np.empty((camera.height, camera.width), np.float32 if camera.sharpen else np.uint8)
        _develop(picture, light, grain, not camera.sharpen)
        if camera.sharpen:
            soft = cv2.GaussianBlur(picture, (0, 0), SHARPEN_PX)
            picture = cv2.addWeighted(picture, 1 + camera.sharpen, soft, -camera.sharpen, 0, dtype=cv2.CV_8U)
        return np.asarray(cv2.flip(picture, 1) if camera.mirror else picture, dtype=np.uint8)

    def _paint(self, rotation: NDArray[np.float64]) -> None:
        """Fill the coarse picture with the clouds as the turned camera sees them."""
        camera = self._camera
        to_world = np.array([[1, 0, camera.width / 2], [0, 1, camera.height / 2], [0, 0, COARSE]]) / COARSE
        to_world = to_world @ camera.matrix @ rotation.T @ np.linalg.inv(camera.matrix)
        # Pixel centres are whole numbers on both scales, so their origins are half a pixel apart.
        steps = camera.width / self._behind.shape[1], camera.height / self._behind.shape[0]
        spread = np.array([[steps[0], 0, steps[0] / 2 - 0.5], [0, steps[1], steps[1] / 2 - 0.5], [0, 0, 1.0]])
        _background(self._behind, self._world, to_world @ spread)

    def _with_board(self, board: Rendered, wide: NDArray[np.float32]) -> tuple[NDArray[np.float32], int, int]:
        """The board laid over the background, both blurred as the lens does, with a margin; its top and left, px."""
        camera = self._camera
        blur = math.hypot(BLUR_PX, camera.focus_blur_px)
        margin = math.ceil(4 * blur) + 2
        height, width = board.radiance.shape
        top, left = max(board.top - margin, 0), max(board.left - margin, 0)
        bottom, right = min(board.top + height + margin, camera.height), min(board.left + width + margin, camera.width)
        patch = np.empty((bottom - top, right - left), np.float32)
        _between(patch, wide, top, left, camera.height)
        row, column = board.top - top, board.left - left
        behind = patch[row : row + height, column : column + width]
        behind += board.coverage * (board.radiance - behind)
        return np.asarray(cv2.GaussianBlur(patch, (0, 0), blur), np.float32), top, left


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


@njit(cache=True, error_model="numpy")
def _rows_around(row: int, height: int, wide: Any) -> tuple[int, Any]:  # pragma: no cover
    """The first of the two rows of `wide` between which a row of the picture lies, and how far from it, 0 to 1."""
    place = (row + 0.5) * wide.shape[0] / height - 0.5
    place = min(max(place, 0.0), wide.shape[0] - 1.0)
    first = min(int(place), wide.shape[0] - 2)
    return first, np.float32(place - first)


@njit(cache=True, error_model="numpy")
def _between(patch: Any, wide: Any, top: int, left: int, height: int) -> None:  # pragma: no cover
    """Fill a patch (h, w) of the picture with the background."""
    for row in range(patch.shape[0]):
        first, share = _rows_around(row + top, height, wide)
        out = patch[row]
        above, below = wide[first][left : left + out.size], wide[first + 1][left : left + out.size]
        for column in range(out.size):
            out[column] = above[column] + share * (below[column] - above[column])


@njit(inline="always", error_model="numpy")
def _count(light: Any, gain: Any, noise: Any, counts: Any) -> Any:  # pragma: no cover
    """A pixel's count, 0 to 255 and not yet whole: exposed, clipped, coded by a square root, noisy, clipped again.

    The square root stands for a camera's transfer curve; noise is added after it, where it is about even.
    """
    coded = np.sqrt(min(max(light * gain, np.float32(0)), np.float32(1)))
    read, shot = np.float32(READ_SHARE), np.float32(1 - READ_SHARE)
    value = np.float32(255) * coded + noise * counts * np.sqrt(read + shot * coded)
    return min(max(value, np.float32(0)), np.float32(255))


@njit(cache=True, error_model="numpy")
def _beside(
    out: Any, above: Any, below: Any, share: Any, gain: Any, noise: Any, counts: Any, whole: bool
) -> None:  # pragma: no cover
    """Fill part of a row with the background between two coarse rows; see `_develop`."""
    for column in range(out.size):
        light = above[column] + share * (below[column] - above[column])
        value = _count(light, gain, noise[column], counts)
        out[column] = np.rint(value) if whole else value


@njit(cache=True, error_model="numpy")
def _within(out: Any, light: Any, gain: Any, noise: Any, counts: Any, whole: bool) -> None:  # pragma: no cover
    """Fill part of a row with the patch that has the board in it; see `_develop`."""
    for column in range(out.size):
        value = _count(light[column], gain, noise[column], counts)
        out[column] = np.rint(value) if whole else value


@njit(cache=True, parallel=True, error_model="numpy")
def _develop(picture: Any, light: Light, grain: Grain, whole: bool) -> None:  # pragma: no cover
    """Fill a picture (H, W) with its counts, rounded where they are to be whole.

    Each loop is over lines without gaps, or the compiler would take one pixel at a time, 15 times as slow.
    """
    height, width = picture.shape
    bottom, right = light.top + light.patch.shape[0], light.left + light.patch.shape[1]
    for row in prange(height):
        first, share = _rows_around(row, height, light.wide)
        out, above, below = picture[row], light.wide[first], light.wide[first + 1]
        noise = grain.noise[row + grain.top][grain.left : grain.left + width]
        a, z = (light.left, right) if light.top <= row < bottom else (width, width)
        _beside(out[:a], above[:a], below[:a], share, light.gain, noise[:a], grain.counts, whole)
        if a < z:
            _within(out[a:z], light.patch[row - light.top], light.gain, noise[a:z], grain.counts, whole)
            _beside(out[z:], above[z:], below[z:], share, light.gain, noise[z:], grain.counts, whole)
