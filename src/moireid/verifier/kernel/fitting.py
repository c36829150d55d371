"""Poses of a plane, and prints that moved while they were exposed, by the kernel, for NumPy arrays."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.library import address, library

Array = NDArray[np.float64]
Single = NDArray[np.float32]


def refined_poses(
    plane: Array,
    seen: Array,
    slack: Array | None,
    rotation: Array,
    translation: Array,
    *,
    steps: int,
    damping: float,
    most_turn: float,
) -> tuple[Array, Array, Array]:
    """Rotations (T, S, 3, 3) and translations (T, S, 3) after so many steps of Gauss-Newton, and what is left (T, S).

    Parameters: plane (N, 3); seen (T, N, 2): normalised picture coordinates; slack (T, N): as `plane_pose`; damping:
        share of the normal matrix's diagonal that is added to it; most_turn: largest rotation in one step, rad.
    Returns: what is left is a root mean square over the points, infinite where a point is behind the camera or the
        equations have no solution.
    """
    frames, sides, points = *rotation.shape[:2], len(plane)
    plane, seen = (np.ascontiguousarray(part, np.float64) for part in (plane, seen))
    rotation, translation = (np.array(part, np.float64, order="C") for part in (rotation, translation))
    slack = None if slack is None else np.ascontiguousarray(slack, np.float64)
    left = np.empty((frames, sides))
    library().kernel_poses(
        ctypes.c_void_p(address(plane, np.float64, 3 * points)),
        ctypes.c_void_p(address(seen, np.float64, 2 * frames * points)),
        ctypes.c_void_p(None if slack is None else address(slack, np.float64, frames * points)),
        *(ctypes.c_int32(number) for number in (frames, sides, points, steps)),
        *(ctypes.c_double(number) for number in (damping, most_turn)),
        ctypes.c_void_p(address(rotation, np.float64, 9 * frames * sides)),
        ctypes.c_void_p(address(translation, np.float64, 3 * frames * sides)),
        ctypes.c_void_p(address(left, np.float64)),
    )
    return rotation, translation, np.where(left >= 0, left, np.inf)


def smeared_means(
    phases: Single, corner: tuple[int, int], shape: tuple[int, int], motion: tuple[float, float], steps: int
) -> Single:
    """Mean of a drawing over a motion, (rows * columns,).

    Parameters: phases (2, 2, height, width): the drawing at whole and at half samples down and across; corner: the row
        and the column of its first whole sample that is asked, and shape: how many rows and columns are; motion: right
        and down, in samples.
    Convention: a motion out of the drawing ends at its border.
    """
    (top, left), (rows, columns) = corner, shape
    height, width = phases.shape[-2:]
    if min(top, left) < 0 or min(shape) < 1 or top + rows >= height or left + columns >= width:
        raise ValueError(f"{rows} x {columns} samples from {top}, {left} on are not within {height} x {width} less one")
    if steps < 1:
        raise ValueError(f"{steps} steps; one or more are needed")
    means = np.empty(rows * columns, np.float32)
    library().kernel_smeared(
        ctypes.c_void_p(address(phases, np.float32, 4 * height * width)),
        *(ctypes.c_int32(size) for size in (width, height, left, top, rows, columns)),
        *(ctypes.c_double(part) for part in motion),
        ctypes.c_int32(steps),
        ctypes.c_void_p(address(means, np.float32)),
    )
    return means
