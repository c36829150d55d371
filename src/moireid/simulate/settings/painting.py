"""Flat pictures at their depths, as the camera sees them, every row from its own pose.

Convention: board frame of `motion`, mm; pictures are coded as a camera's, by the square root of the light.
Source: a sight line meets a plane of constant depth in one place; so near layers move more than far ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.cameras import Camera, undistorted
from moireid.simulate.compiled import njit, prange
from moireid.simulate.motion import Poses
from moireid.simulate.settings.drawn_layers import Layer

Array = NDArray[np.float64]
Chroma = NDArray[np.uint8]


class Painter:
    """Paints what is around the badge, for one camera."""

    def __init__(self, layers: Sequence[Layer], camera: Camera) -> None:
        # Near ones first: a pixel is done as soon as nothing behind can be seen.
        self._layers = sorted(layers, key=lambda layer: layer.depth_mm)
        self._colours = np.concatenate([layer.picture.reshape(-1, 4) for layer in self._layers])
        begins = np.cumsum([0, *(layer.picture.shape[0] * layer.picture.shape[1] for layer in self._layers)])
        self._sizes = np.array([[b, *layer.picture.shape[:2]] for b, layer in zip(begins, self._layers, strict=False)])
        self._places = np.array([[one.depth_mm, *one.corner_mm, one.px_per_mm, one.endless] for one in self._layers])
        self._camera = camera
        self._picture = np.zeros((camera.height, camera.width, 3), np.uint8)
        self._slopes = np.empty((camera.height, camera.width, 2), np.float32)
        matrix = camera.matrix
        _fill_slopes(self._slopes, camera.focal_px, matrix[0, 2], matrix[1, 2], np.array(camera.distortion, float))

    def paint(self, first: Poses, last: Poses) -> NDArray[np.uint8]:
        """The picture (rows, columns, 3), blue, green, red, from the poses of its first and last row (one each)."""
        camera = self._camera
        share = ((np.arange(camera.height) - (camera.height - 1) / 2) / camera.height + 0.5)[:, None]
        centres = first.camera_mm[0] * (1 - share) + last.camera_mm[0] * share
        turns = first.rotation[0] * (1 - share[..., None]) + last.rotation[0] * share[..., None]
        boxes = np.array([self._box(layer, first, last) for layer in self._layers])
        flat = self._colours, self._sizes, self._places, boxes
        _paint_rows(self._picture, *flat, self._slopes, centres, turns)
        return self._picture

    def _box(self, layer: Layer, *views: Poses) -> tuple[int, int, int, int]:
        """Left, top, right and bottom of the pixels that may see a layer; all where it is endless or partly behind."""
        camera = self._camera
        whole = 0, 0, camera.width, camera.height
        (left, top), (high, wide) = layer.corner_mm, layer.picture.shape[:2]
        x, y = np.meshgrid(np.linspace(0, wide, 9) / layer.px_per_mm, np.linspace(0, high, 9) / layer.px_per_mm)
        points = np.column_stack([left + x.ravel(), top + y.ravel(), np.full(x.size, layer.depth_mm)])
        local = np.concatenate([(points - view.camera_mm[0]) @ view.rotation[0].T for view in views])
        if layer.endless or local[:, 2].min() <= 1.0:
            return whole
        seen = camera.project(local)
        low, far = np.floor(seen.min(axis=0)) - 3, np.ceil(seen.max(axis=0)) + 4
        limits = [(low[0], whole[2]), (low[1], whole[3]), (far[0], whole[2]), (far[1], whole[3])]
        return tuple(int(min(max(place, 0), most)) for place, most in limits)  # type: ignore[return-value]


def light_of(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Radiance (rows, columns) of a coloured picture."""
    grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.float32) / np.float32(255)
    return grey * grey


def chroma_of(picture: NDArray[np.uint8], *, mirror: bool = False) -> tuple[Chroma, Chroma]:
    """Both planes of colour differences, half as wide and high."""
    if mirror:
        picture = np.asarray(cv2.flip(picture, 1), np.uint8)
    half = cv2.resize(picture, (picture.shape[1] // 2, picture.shape[0] // 2), interpolation=cv2.INTER_AREA)
    parts = cv2.cvtColor(half, cv2.COLOR_BGR2YCrCb)
    # Full range to that of a video file.
    blue, red = (np.asarray(cv2.convertScaleAbs(parts[..., k], alpha=224 / 255, beta=16), np.uint8) for k in (2, 1))
    return blue, red


@njit(cache=True, parallel=True)
def _fill_slopes(slopes: Any, focal: float, middle_x: float, middle_y: float, distortion: Any) -> None:
    """Slopes of the sight line of each pixel."""
    for row in prange(slopes.shape[0]):
        for column in range(slopes.shape[1]):
            u, v = undistorted((column - middle_x) / focal, (row - middle_y) / focal, distortion)
            slopes[row, column, 0], slopes[row, column, 1] = u, v


@njit(cache=True, parallel=True)
def _paint_rows(
    picture: Any, colours: Any, sizes: Any, places: Any, boxes: Any, slopes: Any, centres: Any, turns: Any
) -> None:
    """Fill the picture (H, W, 3) with all layers, near ones first.

    Parameters: colours (N, 4): of all layers, one after the other; sizes (L, 3): where each begins, its rows and
        columns; places (L, 5): depth, left, top, px per mm, and whether it is endless; boxes (L, 4): left, top, right
        and bottom of the pixels that may see it.
    """
    for row in prange(picture.shape[0]):
        centre, turn = centres[row], turns[row]
        for column in range(picture.shape[1]):
            u, v = slopes[row, column, 0], slopes[row, column, 1]
            dz = turn[0, 2] * u + turn[1, 2] * v + turn[2, 2]
            blue, green, red, left = 0.0, 0.0, 0.0, 1.0
            if dz > 1e-6:
                way_x = (turn[0, 0] * u + turn[1, 0] * v + turn[2, 0]) / dz
                way_y = (turn[0, 1] * u + turn[1, 1] * v + turn[2, 1]) / dz
                for k in range(places.shape[0]):
                    box = boxes[k]
                    if not (box[0] <= column < box[2] and box[1] <= row < box[3]):
                        continue
                    fall = places[k, 0] - centre[2]
                    x = (centre[0] + fall * way_x - places[k, 1]) * places[k, 3] - 0.5
                    y = (centre[1] + fall * way_y - places[k, 2]) * places[k, 3] - 0.5
                    b, g, r, opaque = _between(x, y, places[k, 4] > 0, sizes[k], colours)
                    blue, green, red = blue + left * b, green + left * g, red + left * r
                    left *= 1.0 - opaque
                    if left < 0.004:
                        break
            picture[row, column, 0] = np.uint8(blue + 0.5)
            picture[row, column, 1] = np.uint8(green + 0.5)
            picture[row, column, 2] = np.uint8(red + 0.5)


@njit(inline="always")
def _between(x: float, y: float, endless: bool, size: Any, colours: Any) -> tuple[float, float, float, float]:
    """Blue, green and red of a layer times its opacity, and that, 0 to 1, between four of its pixels."""
    first, high, wide = size[0], size[1], size[2]
    if endless:
        x, y = min(max(x, 0.0), wide - 1.001), min(max(y, 0.0), high - 1.001)
    elif not (0.0 <= x < wide - 1 and 0.0 <= y < high - 1):
        return 0.0, 0.0, 0.0, 0.0
    i, j = int(y), int(x)
    b, a = y - i, x - j
    place = first + i * wide + j
    blue, green, red, opaque = 0.0, 0.0, 0.0, 0.0
    for step, weight in ((0, (1 - a) * (1 - b)), (1, a * (1 - b)), (wide, (1 - a) * b), (wide + 1, a * b)):
        colour = colours[place + step]
        share = weight * colour[3] / 255.0
        blue, green, red = blue + share * colour[0], green + share * colour[1], red + share * colour[2]
        opaque += share
    return blue, green, red, opaque
