"""Where Mitsuba's camera is, which pixels it must render, and how much of each the board covers.

Convention: pixel centres are whole numbers, as in `scene.Camera`.
Source: pinhole camera; `motion` for the frames.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.analytic_renderer import Crop
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]


def coverage(scene: Scene, view: Poses, box: Crop) -> Array:
    """Share of each pixel's area that the board covers, (bottom - top, right - left).

    Convention: 0 outside the board, 1 within it.
    Source: 16 x 16 sight lines where the board's edge runs through a pixel.
    """
    at_corners = _meets_board(
        scene, view, np.arange(box[0], box[2] + 1) - 0.5, np.arange(box[1], box[3] + 1)[:, None] - 0.5
    )
    corners = np.stack([at_corners[i : i - 1 or None, j : j - 1 or None] for i in (0, 1) for j in (0, 1)])
    share = corners.all(axis=0).astype(float)
    rows, columns = np.nonzero(corners.any(axis=0) & (share < 1))
    within = (np.arange(16) + 0.5) / 16 - 0.5
    u, v = np.add.outer(columns + box[0], within)[:, None, :], np.add.outer(rows + box[1], within)[:, :, None]
    share[rows, columns] = _meets_board(scene, view, u, v).mean(axis=(1, 2))
    return share


def _meets_board(scene: Scene, view: Poses, u: NDArray[Any], v: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether the sight lines through those places of the picture, px, meet the board."""
    camera, centre, turn = scene.camera, view.camera_mm[0], view.rotation[0]
    u, v = (u - camera.matrix[0, 2]) / camera.focal_px, (v - camera.matrix[1, 2]) / camera.focal_px
    way = [turn[0, k] * u + turn[1, k] * v + turn[2, k] for k in range(3)]
    met, half = way[2] > 1e-9, scene.printed_half_mm
    for k in range(2):
        place = centre[k] - centre[2] * way[k] / np.where(met, way[2], 1.0)
        met &= np.abs(place) <= half[k]
    return np.asarray(met)


def film_box(box: Crop, kept: tuple[int, int] | None) -> tuple[int, int]:
    """Width and height of a film that holds the box, px; the kept size as long as it fits and is not far too large.

    Convention: a new film has a sixteenth to spare on each side, in steps of 16 px.
    Source: a film's size is baked into Dr.Jit's kernels, which take 0.3 s to compile, while its place is not.
    """
    need = box[2] - box[0], box[3] - box[1]
    if kept and kept[0] >= need[0] and kept[1] >= need[1] and kept[0] * kept[1] <= 2 * need[0] * need[1]:
        return kept
    width, height = (16 * math.ceil(side * 1.125 / 16) for side in need)
    return width, height
