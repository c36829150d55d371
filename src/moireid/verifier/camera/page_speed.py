"""How the page moves in the picture: the speed of its points, jumps, and the effect of the print's aspect.

A printer feeds paper a little too far or too short, by one or some thousandths, and paper grows more across its fibres
than along them.  A page that is a thousandth too high looks like one that is tilted by 2.5 degrees.  That tilt is a
parallax which is not there: on a calm film it makes the fringes' gain 10 % wrong.  A film with tilts of its own shows
the difference, to a ten-thousandth.

Convention: points (T, N, 2) px, times (T,) s; aspect is the logarithm of the page's height over that of its design, at
one width, about the page's middle.
Source: derivative of each frame's homography along the page's y; an aspect is so small that its square does not matter.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.plane_pose import plane_homographies
from moireid.verifier.camera.smoothing import GAP_S, unbroken
from moireid.verifier.camera.stretches import AROUND, even_or_apart
from moireid.verifier.measuring import HAND_JERK_PER_S3, JUMP_NOISE_SDS, MAX_PICTURE_JUMP, MOST_JERK_S, TREMOR_HZ
from moireid.verifier.series import median_near, slopes

Array = NDArray[np.float64]
#: A value less the polynomial through its eight neighbours on either side, scaled to keep the size of white noise.
ALONE = np.array([(-1) ** k * math.comb(16, k) for k in range(17)]) / math.sqrt(math.comb(32, 16))
#: Steps between frames that differ by more are not even.
UNEVEN_RATIO = 1.5
#: Median of the absolute value of a normal distribution of standard deviation 1.
NORMAL_MEDIAN = 0.6745


def _even(clock: Array) -> NDArray[np.bool_]:
    """Whether the frames of each window of `ALONE` are evenly spaced, (T - 16,)."""
    steps = np.lib.stride_tricks.sliding_window_view(np.diff(clock), len(ALONE) - 1)
    return np.asarray(steps.max(axis=1) <= UNEVEN_RATIO * steps.min(axis=1))


def velocity_px_s(points_px: Array, times_s: Array, cuts: NDArray[np.bool_]) -> Array:
    """Velocity of each point, (T, N, 2) px/s: derivative of a cubic spline through the frames, not across cuts, and 0
    next to gaps.

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
            within = np.clip(clock, clock[kept[0]], clock[kept[-1]])
            velocity[stretch] = slopes(clock[kept], points_px[stretch][kept], within)
    return velocity


def hidden_speed_px_s(points_px: Array, times_s: Array, cuts: NDArray[np.bool_]) -> float:
    """Speed of a hand's tremor that is too fast for the frame rate, so that `velocity_px_s` misses it, px/s.

    At 30 frames a second a spline sees a tremor of 10 Hz as a slower one; a rolling shutter sees it as it is.
    Source: what a place differs from the polynomial through its eight neighbours on either side.  A motion below a
        quarter of the frame rate leaves nothing in it; what does not go on from frame to frame leaves all.  A swing of
        amplitude A at f has a speed of 2 pi f A.  On a measured run at 15, 30 and 60 frames a second this gives 169, 73
        and 30 px/s, where splines err by 126, 79 and 32 in median; on seven made-up motions at most 5, where they err
        by at most 4.
    """
    middle = points_px.mean(axis=1)
    runs = unbroken(times_s, GAP_S, np.cumsum(cuts))
    runs = [run for run in runs if len(run) >= len(ALONE)]
    if not runs:
        return 0.0
    left = np.concatenate(
        [np.stack([np.convolve(middle[run, k], ALONE, "valid") for k in (0, 1)]) for run in runs], axis=1
    )
    even = np.concatenate([_even(times_s[run]) for run in runs])
    swing_px = float(np.median(np.abs(left[:, even] if even.any() else left))) / NORMAL_MEDIAN
    return 2 * math.pi * TREMOR_HZ * swing_px


def jumps(points: Array, times_s: Array) -> NDArray[np.bool_]:
    """Frames before which the points (T, N, 2), in focal lengths, jump, (T,).

    Source: third differences, in which a jump counts once, twice and once, and a hand's motion as its jerk times the
        cube of the step.  Frames that are not evenly spaced have third divided differences in their place.
    """
    found = np.zeros(len(points), bool)
    if len(points) < AROUND:
        return found
    differences, cubes_s3 = _third_differences(points, times_s)
    jerk = np.abs(differences).max(axis=(1, 2))
    by_hand = HAND_JERK_PER_S3 * np.minimum(cubes_s3, MOST_JERK_S**3)
    sudden = jerk > np.maximum(np.maximum(MAX_PICTURE_JUMP, by_hand), JUMP_NOISE_SDS * median_near(jerk, AROUND))
    edges = np.diff(np.concatenate([[0], sudden, [0]]).astype(int))
    for first, end in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
        # A cut shows in three differences.  A frame that was exposed across the cut makes it four, and is alone.
        places = (first + 3, end) if end - first >= 3 else (first + int(np.argmax(jerk[first:end])) + 2,)
        found[list(places)] = True
    return found


def _third_differences(points: Array, times_s: Array) -> tuple[Array, Array]:
    """Third differences (T - 3, N, 2), in the unit of the points, and what a jerk of 1 adds to each, (T - 3,) s^3.

    Source: third divided differences (Newton), scaled to keep the size of white noise; that of t^3 is 1.
    """
    spans = np.lib.stride_tricks.sliding_window_view(even_or_apart(times_s), 4)
    weights = 1 / (spans[:, :, None] - spans[:, None, :] + np.eye(4)).prod(axis=2)
    scale = math.sqrt(math.comb(6, 3)) / np.linalg.norm(weights, axis=1)
    weights *= scale[:, None]
    differences = sum(weights[:, k, None, None] * points[k : len(points) - 3 + k] for k in range(4))
    return np.asarray(differences), scale / math.factorial(3)


def _apart(clock: Array, least_s: float) -> list[int]:
    """Indices of times that are at least `least_s` apart: a file may have two times that are equal or nearly so, and a
    spline through both would give a huge velocity.
    """
    kept = [0]
    for place in range(1, len(clock)):
        if clock[place] - clock[kept[-1]] >= max(least_s, 1e-6):
            kept.append(place)
    return kept


def lengthened_px(points_px: Array, plane_mm: Array) -> Array:
    """How points of a page move in the picture as the page's aspect grows, (T, N, 2) px per unit.

    Parameters: points_px (T, N, 2): pictures of plane_mm (N, 2), of mean 0, by one homography in each frame.
    Source: derivative of the points' homography by their y.
    """
    x, y = plane_mm.T
    mapped = plane_homographies(plane_mm, points_px)
    depth = mapped[:, 2:, 0] * x + mapped[:, 2:, 1] * y + 1
    along = mapped[:, None, :2, 1] - points_px * mapped[:, None, 2:, 1]
    return np.asarray(along * (y / depth)[..., None])
