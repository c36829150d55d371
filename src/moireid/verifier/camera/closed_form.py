"""Optical axis, focal length and pixel aspect in closed form, from homographies alone.

A film may be a crop, or a tile of a recorded call, so that its optical axis meets the picture far from the middle or
outside of it; or it may be stretched.  A search from the middle does not find that, and need not: each homography of a
plane gives two linear equations of the image of the absolute conic.

Convention: lengths are in long sides of the picture, the axis from the picture's middle, x right, y down; aspect is the
focal length along x over that along y, 1 for square pixels, below 1 in a picture that was squeezed.  Axis and focal
length are those of the picture once its pixels are square.
Source: Zhang, A flexible new technique for camera calibration, 2000, section 3.1; frames that fit
    badly, as some are shaken, get Geman and McClure's weight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROUNDS = 4


@dataclass(frozen=True)
class ClosedForm:
    """axis (2,), focal and aspect, in the unit and convention of this module."""

    axis: Array
    focal: float
    aspect: float


def closed_form(points: Array, plane: Array, *, square: bool) -> ClosedForm | None:
    """The camera that explains a film's homographies; None where they do not tell it.

    Parameters: points (T, N, 2): pictures of the plane's points, from the picture's middle, in long sides; plane
        (N, 2): any unit; square: whether pixels are known to be square.
    """
    homographies = _homographies(points, plane)
    rows = np.concatenate([_row(homographies, 0, 1), _row(homographies, 0, 0) - _row(homographies, 1, 1)])
    if square:
        rows = np.column_stack([rows[:, 0] + rows[:, 1], rows[:, 2:]])
    weight = np.ones(len(rows))
    for _ in range(ROUNDS):
        conic = np.linalg.svd(rows * weight[:, None], full_matrices=False)[2][-1]
        left = np.abs(rows @ conic)
        weight = 1 / (1.0 + (left / (2 * np.median(left) + 1e-15)) ** 2)
    along, across = (conic[0], conic[0]) if square else conic[:2]
    both_x, both_y, rest = conic[-3:]
    if along * across <= 0:
        return None
    axis = np.array([-both_x / along, -both_y / across])
    power = (rest - both_x**2 / along - both_y**2 / across) / across
    if not power > 0:
        return None
    aspect = float(np.sqrt(across / along))
    return ClosedForm(axis / [aspect, 1.0], float(np.sqrt(power)), aspect)


def _homographies(points: Array, plane: Array) -> Array:
    """Plane -> picture of each frame, (T, 3, 3), of norm 1.

    Source: direct linear transform (Hartley and Zisserman, Multiple View Geometry, 4.1).
    """
    local = (plane - plane.mean(axis=0)) / np.abs(plane - plane.mean(axis=0)).max()
    flat = np.column_stack([local, np.ones(len(local))])
    flat = np.broadcast_to(flat, (len(points), *flat.shape))
    none = np.zeros_like(flat)
    upper = np.concatenate([flat, none, -points[..., :1] * flat], axis=-1)
    lower = np.concatenate([none, flat, -points[..., 1:] * flat], axis=-1)
    rows = np.concatenate([upper, lower], axis=1)
    # Four places make eight rows, whose null vector only the full matrices hold.
    turned = np.linalg.svd(rows, full_matrices=rows.shape[1] < rows.shape[2])[2]
    return np.asarray(turned[:, -1].reshape(-1, 3, 3))


def _row(homographies: Array, i: int, j: int) -> Array:
    """Coefficients (T, 5) of h_i' B h_j, for B11, B22, B13, B23, B33 and no skew."""
    a, b = homographies[:, :, i], homographies[:, :, j]
    return np.column_stack(
        [
            a[:, 0] * b[:, 0],
            a[:, 1] * b[:, 1],
            a[:, 2] * b[:, 0] + a[:, 0] * b[:, 2],
            a[:, 2] * b[:, 1] + a[:, 1] * b[:, 2],
            a[:, 2] * b[:, 2],
        ]
    )
