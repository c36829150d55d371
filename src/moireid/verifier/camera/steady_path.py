"""The misfit of a focal length if the camera moves on a steady path.

If a badge is seen from the front by a camera that shifts but does not rotate, its focal length is poorly determined.
The longer the focal length, the more freely the tilt of each frame can fit noise.  So the least misfit over free tilts
lies at a far too long focal length: lower by 30 units of chi-square at three times the true one, in films by an outside
simulator.  A hand cannot jump from tilt to tilt.  On a smooth path the misfit of such a film is flat, and that of other
films is as sharp as before.

Convention: as `plane_pose`; the direction is that of the tangents Cx/Cz and Cy/Cz in the plane's frame.
Source: Gauss-Newton over rotation and distance for a given direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.plane_pose import PlanePoses, rotations
from moireid.verifier.camera.smoothing import GAP_S, rising, unbroken
from moireid.verifier.splines import smoothed

Array = NDArray[np.float64]
#: Faster changes of the direction count as noise: a hand's path is slower.
CUT_OFF_HZ = 3.0
STEPS = 5
#: A picture of a plane has eight degrees of freedom; rotation and distance take four of them.
SPARE = 4


def steady_errors_px(
    poses: PlanePoses, plane: Array, points_px: Array, times_s: Array, focal: float, centre: tuple[float, float]
) -> Array:
    """Reprojection errors (T,) px of poses whose direction is smoothed over time.

    Parameters: poses: the best ones without smoothing; points_px (T, N, 2); times_s (T,), rising.
    """
    frames, better = np.arange(len(poses.error_px)), poses.error_px.argmin(axis=1)
    rotation, camera = poses.rotation[frames, better], poses.camera[frames, better]
    tangents = np.column_stack([_smooth(camera[:, k] / camera[:, 2], times_s) for k in (0, 1)])
    direction = np.column_stack([tangents, np.ones(len(frames))])
    far = camera[:, 2].copy()
    seen = (points_px - np.array(centre)) / focal
    for _ in range(STEPS):
        towards = -np.einsum("tij,tj->ti", rotation, direction)
        local = plane @ rotation.swapaxes(-1, -2) + (towards * far[:, None])[:, None]
        flat = local[..., :2] / local[..., 2:]
        residual = (flat - seen).reshape(len(frames), -1)
        # A rotation is about the camera, so the plane moves with it; a step of distance is a share of it.
        turns = [np.cross(axis, local) for axis in np.eye(3)]
        moves = [*turns, np.broadcast_to((towards * far[:, None])[:, None], local.shape)]
        table = np.stack(
            [((move[..., :2] - flat * move[..., 2:]) / local[..., 2:]).reshape(len(frames), -1) for move in moves],
            axis=-1,
        )
        normal = table.swapaxes(-1, -2) @ table
        step = -np.linalg.solve(normal + 1e-12 * np.eye(4), table.swapaxes(-1, -2) @ residual[..., None])[..., 0]
        rotation, far = rotations(step[:, :3]) @ rotation, far * (1 + step[:, 3])
    return np.asarray(focal * np.sqrt((residual**2).sum(axis=1) / len(plane)))


def _smooth(values: Array, times_s: Array) -> Array:
    """The part of a series below `CUT_OFF_HZ`; never across gaps."""
    smooth = values.copy()
    for stretch in unbroken(times_s, GAP_S):
        if len(stretch) >= 8:
            clock = rising(times_s[stretch])
            stiffness = len(clock) / (clock[-1] - clock[0]) / (2 * np.pi * CUT_OFF_HZ) ** 4
            smooth[stretch] = smoothed(clock, values[stretch], stiffness)
    return smooth
