"""From radiance to 8-bit pictures: background, lens blur, exposure, noise, and a phone's sharpening.

`opened` gives the poses of a frame whose rows open one after the other, each for as long as the exposure.  `CURVES` are
transfer curves of high dynamic range, in 10 bits, for pictures that are coded by a square root.

Convention: the background is at infinity and turns with the camera; it is so smooth that it needs no distortion and
no motion blur.  A frame's time is the middle of its middle row's exposure.  A white page under an even sky has radiance
1 and is shown as reference white, 203 cd/m2.
Source: ITU-R BT.2100 (curves), BT.2408 (reference white: 75 % of the signal in hybrid log-gamma).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.analytic_renderer import BoardRadiance
from moireid.simulate.cameras import Camera
from moireid.simulate.compiled import njit, prange
from moireid.simulate.motion import Motion, Poses

Array = NDArray[np.float64]
#: Scene light of reference white in hybrid log-gamma, and its luminance, cd/m2.
WHITE_SCENE, WHITE_CD = 0.265, 203.0
#: Codes of ITU-T H.273: primaries BT.2020, matrix BT.2020 of non-constant luminance, and the two curves.
BT2020_PRIMARIES, BT2020_MATRIX, PQ_CODE, HLG_CODE = 9, 9, 16, 18


@dataclass(frozen=True)
class Curve:
    """counts (256,): 10-bit luma in the file for 8-bit luma from 16 to 235; tags: primaries, transfer and matrix."""

    counts: NDArray[np.uint16]
    tags: tuple[int, int, int]


def hybrid_log_gamma(light: Array) -> Array:
    """The signal, 0 to 1, of scene light, 0 to 1."""
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    return np.where(light <= 1 / 12, np.sqrt(3 * light), a * np.log(np.maximum(12 * light - b, 1e-9)) + c)


def perceptual_quantiser(luminance: Array) -> Array:
    """The signal, 0 to 1, of luminance, cd/m2."""
    m1, m2, c1, c2, c3 = 2610 / 16384, 2523 / 32, 3424 / 4096, 2413 / 128, 2392 / 128
    power = (luminance / 10000) ** m1
    return np.asarray(((c1 + c2 * power) / (1 + c3 * power)) ** m2)


def _curve(signal: Array, code: int) -> Curve:
    return Curve(np.rint(64 + 876 * signal).astype(np.uint16), (BT2020_PRIMARIES, code, BT2020_MATRIX))


#: Light of each 8-bit count in a file, by the square root of `recording.sensor`.
LIGHT = (np.clip(np.arange(256) - 16.0, 0, 219) / 219) ** 2
CURVES = {
    "hlg": _curve(hybrid_log_gamma(WHITE_SCENE * LIGHT), HLG_CODE),
    "pq": _curve(perceptual_quantiser(WHITE_CD * LIGHT), PQ_CODE),
}


#: Instants that describe an exposure: steps of a pixel at most, until there are too many.
STEP_PX, MOST = 1.0, 24


def opened(
    motion: Motion, camera: Camera, half_mm: tuple[float, float], time_s: float, fps: float
) -> tuple[Poses, tuple[Poses, Poses, Poses]]:
    """The frame's own pose, and poses of first, middle and last row (T each) at instants evenly over the exposure.

    Parameters: half_mm: half the board's width and height; an exposure lasts a frame at most.
    Returns: pose at `time_s` (1,), and T of 1 where the camera opens for an instant or the badge does not move; more
        the farther it moves.
    """
    exposure = min(camera.exposure_s, 1 / fps)
    moved = _moved_px(motion(time_s + exposure * np.array([-0.5, 0.5])), camera, half_mm) if exposure else 0.0
    count = min(max(math.ceil(moved / STEP_PX), 1), MOST)
    offsets = ((np.arange(count) + 0.5) / count - 0.5) * exposure
    rows = camera.shutter_s * np.array([-0.5, 0.0, 0.5])
    poses = motion(time_s + np.append((rows[:, None] + offsets).ravel(), 0.0))
    first, middle, last = (_part(poses, slice(k * count, (k + 1) * count)) for k in range(3))
    return _part(poses, slice(-1, None)), (first, middle, last)


def _part(poses: Poses, rows: slice) -> Poses:
    return Poses(poses.camera_mm[rows], poses.rotation[rows])


def _moved_px(ends: Poses, camera: Camera, half_mm: tuple[float, float]) -> float:
    """How far a corner of the board moves in the picture between two poses, at most."""
    corners = np.array([[x * half_mm[0], y * half_mm[1], 0.0] for x in (-1, 1) for y in (-1, 1)])
    local = np.einsum("tij,tkj->tki", ends.rotation, corners - ends.camera_mm[:, None])
    if local[..., 2].min() <= 1.0:
        return 0.0
    places = camera.project(local)
    return float(np.linalg.norm(places[1] - places[0], axis=-1).max())


#: Frequency of the exposure's drift, as automatic exposure wanders over some seconds.
DRIFT_HZ = 0.17
#: Share of the noise's variance that does not depend on the light (read noise).
READ_SHARE = 0.3
#: Standard deviation of lens and demosaicing blur, px, and of the unsharp mask, px.
BLUR_PX, SHARPEN_PX = 0.5, 1.2
#: The clouds are smooth, so they are kept, and turned, at a quarter of the size at which they are seen.
COARSE = 4
#: Radiance of the darkest and the span of the clouds.
DARKEST, SPAN = 0.12, 0.25


NO_PATCH = np.zeros((0, 0), np.float32)


class SensorLight(NamedTuple):
    """What falls on the sensor: the background's coarse rows at full width; for each row of the picture the coarse one
    above it, and how far it is from that to the next, 0 to 1; the patch with the board and its place, px; and the
    exposure."""

    wide: NDArray[np.float32]
    above: NDArray[np.intp]
    share: NDArray[np.float32]
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

    def __init__(self, camera: Camera, seed: int) -> None:
        self._camera = camera
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
        coarse = len(self._behind)
        place = np.clip((np.arange(height) + 0.5) * coarse / height - 0.5, 0.0, coarse - 1.0)
        self._above = np.minimum(place.astype(np.intp), coarse - 2)
        self._share = (place - self._above).astype(np.float32)
        # Of a background at full size, each row is itself.
        above = np.minimum(np.arange(height), height - 2)
        self._each_row = above, (np.arange(height) - above).astype(np.float32)

    def expose(
        self,
        board: BoardRadiance | None,
        rotation: NDArray[np.float64],
        time_s: float,
        behind: NDArray[np.float32] | None = None,
    ) -> NDArray[np.uint8]:
        """One picture (height, width) uint8.

        Parameters: behind: radiance of all that is around the board, (height, width); None for clouds.
        Convention: rotation board -> camera; the clouds are at infinity and turn with it.
        """
        camera = self._camera
        if behind is None:
            self._paint(rotation)
            # The clouds at full width; the rows between them are interpolated as each is developed.
            wide = cv2.resize(self._behind, (camera.width, self._behind.shape[0]), interpolation=cv2.INTER_LINEAR)
            rows = self._above, self._share
        else:
            wide, rows = behind, self._each_row
        patch, top, left = NO_PATCH, 0, 0
        if board is not None:
            patch, top, left = self._with_board(board, wide, rows)
        drift = 1 + camera.exposure_drift * math.sin(2 * math.pi * DRIFT_HZ * time_s + self._phase)
        place = self._rng.integers(0, 256, 2)
        grain = Grain(self._noise, int(place[0]), int(place[1]), np.float32(camera.noise_counts))
        light = SensorLight(wide, *rows, patch, top, left, np.float32(camera.exposure * drift))
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

    def _with_board(
        self, board: BoardRadiance, wide: NDArray[np.float32], rows: tuple[NDArray[np.intp], NDArray[np.float32]]
    ) -> tuple[NDArray[np.float32], int, int]:
        """The board placed over the background, both blurred as the lens does, with a margin; its top and left, px."""
        camera = self._camera
        blur = math.hypot(BLUR_PX, camera.focus_blur_px)
        margin = math.ceil(4 * blur) + 2
        height, width = board.radiance.shape
        top, left = max(board.top - margin, 0), max(board.left - margin, 0)
        bottom, right = min(board.top + height + margin, camera.height), min(board.left + width + margin, camera.width)
        first = rows[0][top:bottom]
        above, below = wide[first, left:right], wide[first + 1, left:right]
        patch = above + rows[1][top:bottom, None] * (below - above)
        row, column = board.top - top, board.left - left
        behind = patch[row : row + height, column : column + width]
        behind += board.coverage * (board.radiance - behind)
        return np.asarray(cv2.GaussianBlur(patch, (0, 0), blur), np.float32), top, left


@njit(cache=True, parallel=True)
def _background(scene: Any, world: Any, to_world: Any) -> None:
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


@njit(inline="always")
def _count(light: Any, gain: Any, noise: Any, counts: Any) -> Any:
    """A pixel's count, 0 to 255 and not yet whole: exposed, clipped, coded by a square root, noisy, clipped again.

    The square root is a model of a camera's transfer curve; noise is added after it, where it is about even.
    """
    coded = np.sqrt(min(max(light * gain, np.float32(0)), np.float32(1)))
    read, shot = np.float32(READ_SHARE), np.float32(1 - READ_SHARE)
    value = np.float32(255) * coded + noise * counts * np.sqrt(read + shot * coded)
    return min(max(value, np.float32(0)), np.float32(255))


@njit(cache=True, parallel=True)
def _develop(picture: Any, light: SensorLight, grain: Grain, whole: bool) -> None:
    """Fill a picture (H, W) with its counts, rounded where they are to be whole.

    The inner loop is over lines without gaps, or the compiler would take one pixel at a time, 15 times as slow.
    """
    width = picture.shape[1]
    for row in prange(picture.shape[0]):
        above, below = light.wide[light.above[row]], light.wide[light.above[row] + 1]
        seen = above + light.share[row] * (below - above)
        if light.top <= row < light.top + light.patch.shape[0]:
            seen[light.left : light.left + light.patch.shape[1]] = light.patch[row - light.top]
        out, noise = picture[row], grain.noise[row + grain.top][grain.left : grain.left + width]
        for column in range(width):
            value = _count(seen[column], light.gain, noise[column], grain.counts)
            out[column] = np.rint(value) if whole else value
