"""A phone's measured walk about a room, changed to a walk around the badge: path, turns and time.

Convention: the world of the run has y up; the phone was held upright, so its camera's x axis points down and its y axis
to the left.
Source: ARKit-Data-Logger, ARKit_camera_pose.txt (Pyojin Kim, 2019), MIT licence; see THIRD_PARTY.md.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.turns import continuous

Array = NDArray[np.float64]
PHONE_WALK = "data/phone_walk.csv"
#: Largest tangent of the view sideways, and its shares up and down, and to and fro.
TANGENT, RISE, DEPTH = 0.35, 0.5, 0.4
#: Share of the phone's own turns that is kept.
TURNS = 0.5
#: Turns slower than this follow the room; the aim at the badge replaces them.
AIM_S = 1.0
#: Time that the walk takes to turn back at an end of the run.
REVERSAL_S = 1.0


def around_badge(places_mm: Array) -> Array:
    """The path scaled to a walk around the badge.

    Parameters
    ----------
    places_mm : array (T, 3)
        Places of the phone in the world of the run, mm.

    Returns
    -------
    array (T, 3)
        Camera centres in the board frame, as a share of the mean distance.

    Notes
    -----
    Convention: the widest horizontal direction of the run is sideways, up stays up.  The tangent of the view reaches
        `TANGENT` sideways; up and down it has the same scale, but reaches at most `RISE` of that.  The distance varies
        by `DEPTH` of that to either side.
    Source: the scale is ours.
    """
    level = places_mm - places_mm.mean(axis=0)
    across = np.linalg.svd(level[:, [0, 2]], full_matrices=False)[2][0]
    right = np.sign(across[0]) * np.array([across[0], 0.0, across[1]])
    down = np.array([0.0, -1.0, 0.0])
    wide, low, near = level @ right, level @ down, level @ np.cross(right, down)
    depth = 1.0 - TANGENT * DEPTH * near / np.abs(near).max()
    scale = TANGENT / np.abs(wide / depth).max()
    scale_low = min(scale, TANGENT * RISE / np.abs(low / depth).max())
    return np.column_stack([scale * wide, scale_low * low, -depth])


def fast_turns_rad(times_s: Array, quaternions: Array) -> Array:
    """The phone's own turns, as far as they are faster than `AIM_S`, times `TURNS`.

    Parameters
    ----------
    times_s : array (T,)
        Times of the run, s, evenly spaced.
    quaternions : array (T, 4)
        From the phone's camera to the world, x, y, z, w.

    Returns
    -------
    array (T, 3)
        Rotation vectors from the aimed camera's axes to the turned one's, rad.

    Notes
    -----
    Convention: about the axes of an upright camera, x right, y down, z forward.
    Source: the run's orientations against themselves smoothed by a Gaussian of standard deviation `AIM_S`; ours.
    """
    from scipy.ndimage import gaussian_filter1d
    from scipy.spatial.transform import Rotation

    turns = continuous(quaternions)
    frames = AIM_S / float(np.median(np.diff(times_s)))
    aimed = Rotation.from_quat(gaussian_filter1d(turns, frames, axis=0))
    turn = (Rotation.from_quat(turns).inv() * aimed).as_rotvec()
    return TURNS * np.column_stack([-turn[:, 1], turn[:, 0], turn[:, 2]])


def to_and_fro_s(times_s: Array, length_s: float) -> Array:
    """The place in a run that is walked to and fro, slowing down before each end.

    Parameters
    ----------
    times_s : array (T,)
        Times since the walk began at the run's begin, s.
    length_s : float
        Length of the run, s, longer than `REVERSAL_S`.

    Returns
    -------
    array (T,)
        Times in the run, s, from `REVERSAL_S` / 4 to `length_s` less that.

    Notes
    -----
    Convention: speed 1, then -1; within `REVERSAL_S` / 2 of an end it changes evenly.
    Source: parabolas that meet the straight parts with their slope; ours.
    """
    phase = np.mod(times_s, 2 * length_s)
    clock = np.where(phase <= length_s, phase, 2 * length_s - phase)
    half = REVERSAL_S / 2
    begin, end = np.minimum(clock - half, 0.0), np.minimum(length_s - clock - half, 0.0)
    return np.asarray(clock + (begin**2 - end**2) / (2 * half))
