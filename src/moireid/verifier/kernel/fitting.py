"""Poses of a plane, and prints that moved while they were exposed, by the kernel, for NumPy arrays."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

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


def smeared_means(planes: Sequence[Single], places: Single, motion: tuple[float, float], steps: int) -> list[Single]:
    """Mean of each plane (rows, columns) at places (2, N) over a motion, both in samples of the planes.

    Convention: column and row are counted from the middle of the first sample; beyond a plane its border goes on.
    """
    height, width = planes[0].shape
    if min(height, width) < 2 or steps < 1:
        raise ValueError(f"planes of {width} x {height} and {steps} steps; two or more and one or more are needed")
    count, means = places.shape[1], np.empty((len(planes), places.shape[1]), np.float32)
    start = address(places, np.float32, 2 * count)
    library().kernel_smeared(
        (ctypes.c_void_p * len(planes))(*(address(plane, np.float32, height * width) for plane in planes)),
        *(ctypes.c_int32(number) for number in (len(planes), width, height)),
        ctypes.c_void_p(start),
        ctypes.c_void_p(start + 4 * count),
        ctypes.c_int32(count),
        *(ctypes.c_double(part) for part in motion),
        ctypes.c_int32(steps),
        ctypes.c_void_p(address(means, np.float32)),
    )
    return list(means)
