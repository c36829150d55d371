"""A frame in time: rows that open one after the other, each for as long as the exposure.

Convention: a frame's time is the middle of its middle row's exposure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.renderer import Rendered
from moireid.simulate.cameras import Camera
from moireid.simulate.motion import Motion, Poses

Array = NDArray[np.float64]
#: Instants that an exposure is made of: steps of a pixel at most, until there are too many.
STEP_PX, MOST = 1.0, 24


def opened(
    motion: Motion, camera: Camera, half_mm: tuple[float, float], time_s: float, fps: float
) -> tuple[Poses, list[Poses]]:
    """The frame's own pose, and poses at first, middle and last row (3 each) at the instants of its exposure.

    Parameters: half_mm: half the board's width and height; an exposure lasts a frame at most.
    Returns: pose at `time_s` (1,), and one triple where the camera opens for an instant or the badge stands still;
        more the farther it moves.
    """
    exposure = min(camera.exposure_s, 1 / fps)
    rows = time_s + camera.shutter_s * np.array([-0.5, 0.0, 0.5])
    if exposure == 0.0:
        poses = motion(rows)
        return _part(poses, slice(1, 2)), [poses]
    moved = _moved_px(motion(time_s + exposure * np.array([-0.5, 0.5])), camera, half_mm)
    count = min(max(math.ceil(moved / STEP_PX), 1), MOST)
    offsets = ((np.arange(count) + 0.5) / count - 0.5) * exposure
    poses = motion(np.append((offsets[:, None] + rows).ravel(), time_s))
    return _part(poses, slice(-1, None)), [_part(poses, slice(3 * k, 3 * k + 3)) for k in range(count)]


def _part(poses: Poses, rows: slice) -> Poses:
    return Poses(poses.camera_mm[rows], poses.rotation[rows])


def averaged(parts: Sequence[Rendered | None]) -> Rendered | None:
    """The light of several instants, gathered in one exposure; None where none of them sees the board."""
    if len(parts) == 1:
        return parts[0]
    seen = [part for part in parts if part is not None]
    if not seen:
        return None
    left, top = min(part.left for part in seen), min(part.top for part in seen)
    right = max(part.left + part.radiance.shape[1] for part in seen)
    bottom = max(part.top + part.radiance.shape[0] for part in seen)
    light, cover = np.zeros((2, bottom - top, right - left), np.float32)
    for part in seen:
        rows = slice(part.top - top, part.top - top + part.radiance.shape[0])
        columns = slice(part.left - left, part.left - left + part.radiance.shape[1])
        light[rows, columns] += part.coverage * part.radiance
        cover[rows, columns] += part.coverage
    radiance = np.divide(light, cover, out=np.zeros_like(light), where=cover > 0)
    return Rendered(radiance, cover / np.float32(len(parts)), left, top)


def _moved_px(ends: Poses, camera: Camera, half_mm: tuple[float, float]) -> float:
    """How far a corner of the board moves in the picture between two poses, at most."""
    corners = np.array([[x * half_mm[0], y * half_mm[1], 0.0] for x in (-1, 1) for y in (-1, 1)])
    local = np.einsum("tij,tkj->tki", ends.rotation, corners - ends.camera_mm[:, None])
    if local[..., 2].min() <= 1.0:
        return 0.0
    places = camera.project(local)
    return float(np.linalg.norm(places[1] - places[0], axis=-1).max())
