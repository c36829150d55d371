"""From light to bytes: the room behind the badge, vignetting, exposure, noise, gamma, video range."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from outside.camera import Camera

#: Noise is drawn once, and taken from another place in each frame.
POOL = 1 << 22
#: The wall behind, as a reflectance; how far away it is, over the badge's distance; size of its texture, px.
WALL, WALL_FAR, TEXTURE = 0.28, 2.2, 1024
#: Luma of video (ITU-R BT.709): black and white.
BLACK, RANGE = 16, 219
CURVE_STEPS = 4096


def video_curve() -> NDArray[np.uint8]:
    """Bytes of luma over linear light from 0 to 1, by the sRGB curve (IEC 61966-2-1)."""
    v = np.linspace(0, 1, CURVE_STEPS)
    coded = np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    return np.rint(BLACK + RANGE * coded).astype(np.uint8)


def wall(rng: np.random.Generator) -> NDArray[np.float32]:
    """A plain wall with a soft texture, which repeats."""
    grain = rng.normal(size=(TEXTURE, TEXTURE)).astype(np.float32)
    sizes = ((3, 0.02), (20, 0.03), (90, 0.05))
    soft = sum(share * _unit(gaussian_filter(grain, px, mode="wrap")) for px, share in sizes)
    return (WALL * (1 + soft)).astype(np.float32)


def _unit(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    return (picture - picture.mean()) / picture.std()


def noise_pool(rng: np.random.Generator) -> NDArray[np.float32]:
    """Normal deviates."""
    return rng.normal(size=POOL).astype(np.float32)


def falloff(camera: Camera, rays: NDArray[np.float32]) -> NDArray[np.float32]:
    """What is left of the light towards the corners."""
    return (1.0 - camera.vignetting * np.sum(rays * rays, axis=-1) * 0.8).astype(np.float32)


@njit(cache=True, fastmath=True, error_model="numpy")
def fill_wall(light, texture, a, b, x0, y0):
    """The wall in every pixel; a, b: cosine and sine of the camera's roll; x0, y0: its place."""
    height, width = light.shape
    mask = texture.shape[0] - 1
    for row in range(height):
        x = x0 - b * row + 4096.0 * 1024
        y = y0 + a * row + 4096.0 * 1024
        for column in range(width):
            light[row, column] = texture[int(y) & mask, int(x) & mask]
            x += a
            y += b


@njit(cache=True, fastmath=True, error_model="numpy")
def expose(light, shade, exposure, electrons, read, pool, start, curve, out):
    """Bytes of luma of a frame, into the first rows of `out`."""
    height, width = light.shape
    steps, zero, one = np.float32(len(curve) - 1), np.float32(0), np.float32(1)
    size = len(pool)
    gain, shot, dark = np.float32(exposure), np.float32(1.0 / electrons), np.float32(read * read)
    for row in range(height):
        # Each row begins anywhere in the pool, so that no pattern repeats from frame to frame.
        begin = (start + row * 1000003) % (size - width)
        for column in range(width):
            v = light[row, column] * shade[row, column] * gain
            v += pool[begin + column] * math.sqrt(v * shot + dark)
            out[row, column] = curve[int(min(max(v, zero), one) * steps)]
