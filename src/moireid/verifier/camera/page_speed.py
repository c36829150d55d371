"""How the page moves in the picture: the speed of its points, and where the picture jumps.

Convention: points (T, N, 2) px, times (T,) s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from moireid.verifier.camera.smoothing import GAP_S, unbroken
from moireid.verifier.camera.stretches import AROUND
from moireid.verifier.limits import JUMP_NOISE_SDS, MAX_PICTURE_JUMP

Array = NDArray[np.float64]


def velocity_px_s(points_px: Array, times_s: Array, cuts: NDArray[np.bool_]) -> Array:
    """Velocity of each point, (T, N, 2) px/s: derivative of a cubic spline through the frames, not across cuts, and 0
    beside gaps.

    Registered points are exact to some hundredths of a pixel, so they are interpolated and not smoothed: smoothing
    would flatten a hand's tremor, and the shutter time would be overestimated.
    """
    velocity = np.zeros_like(points_px)
    for stretch in unbroken(times_s, GAP_S, np.cumsum(cuts)):
        if len(stretch) < 4:
            continue
        clock = times_s[stretch]
        kept = _apart(clock, 0.5 * float(np.median(np.diff(clock))))
        if len(kept) >= 4:
            spline = CubicSpline(clock[kept], points_px[stretch][kept])
            velocity[stretch] = spline(np.clip(clock, clock[kept[0]], clock[kept[-1]]), 1)
    return velocity


def jumps(points: Array) -> NDArray[np.bool_]:
    """Frames before which the points (T, N, 2), in focal lengths, jump, (T,).

    Source: third differences, in which a jump counts once, twice and once, and a hand's motion hardly at all.
    """
    found = np.zeros(len(points), bool)
    if len(points) < AROUND:
        return found
    jerk = np.abs(np.diff(points, 3, axis=0)).max(axis=(1, 2))
    sudden = jerk > np.maximum(MAX_PICTURE_JUMP, JUMP_NOISE_SDS * median_filter(jerk, AROUND, mode="nearest"))
    edges = np.diff(np.concatenate([[0], sudden, [0]]).astype(int))
    for first, end in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
        # A cut shows in three differences.  A frame that was exposed across the cut makes it four, and stands alone.
        places = (first + 3, end) if end - first >= 3 else (first + int(np.argmax(jerk[first:end])) + 2,)
        found[list(places)] = True
    return found


def _apart(clock: Array, least_s: float) -> list[int]:
    """Indices of times that are at least `least_s` apart: a file may have two times that are equal or nearly so, and a
    spline through both would give a huge velocity.
    """
    kept = [0]
    for place in range(1, len(clock)):
        if clock[place] - clock[kept[-1]] >= max(least_s, 1e-6):
            kept.append(place)
    return kept
