"""Smoothing the camera's path over time, without removing a hand's motion; and the misfit of poses on a steady path.

If a badge is seen from the front by a camera that shifts but does not rotate, its focal length is poorly determined.
The longer the focal length, the more freely the tilt of each frame can fit noise.  So the least misfit over free tilts
is at a far too long focal length: lower by 30 units of chi-square at three times the true one, in films by an outside
simulator.  A hand cannot jump from tilt to tilt.  On a smooth path (`steady_errors_px`) the misfit of such a film
hardly depends on the focal length, which its prior then decides; that of other films depends on it as before.

Convention: as `fit` and `plane_pose`; the direction is that of the tangents Cx/Cz and Cy/Cz in the plane's frame.
Source: Gauss-Newton over rotation and distance for a given direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.plane_pose import PlanePoses, rotations
from moireid.verifier.measuring import (
    DOUBTED_MEDIANS_RATIO,
    DOUBTED_PX,
    SMOOTHED_ERROR_RATIO,
    STRAY_MEDIANS_RATIO,
    STRAY_PX,
)
from moireid.verifier.series import gaussian_mean, smoothed

Array = NDArray[np.float64]
#: Frames further apart than this are not smoothed together, and give no velocity.
GAP_S = 0.15
#: Cut-offs of smoothing.  A hand's path is slower than 2 Hz; the lowest cut-off keeps 83 % at 2 Hz and 99 % at 1 Hz.
CUT_OFFS_HZ = (3.0, 4.0, 6.0, 9.0, 14.0)


def unbroken(times_s: Array, gap_s: float, numbers: NDArray[np.int64] | None = None) -> list[NDArray[np.int64]]:
    """Frames grouped into runs without a gap of more than `gap_s`, each of one stretch; numbers: as `stretches`."""
    ends = np.diff(times_s) > gap_s
    if numbers is not None:
        ends |= np.diff(numbers) != 0
    return np.split(np.arange(len(times_s)), np.flatnonzero(ends) + 1)


def frame_s(times_s: Array, gap_s: float = GAP_S) -> float:
    """Mean time from one frame to the next without gaps; `gap_s` if there are only gaps.

    The mean, as the median would be 0 if a file gives each time three times.
    """
    steps = np.diff(times_s)
    steps = steps[steps <= gap_s]
    return float(steps.mean()) if steps.sum() > 0 else gap_s


def rising(times_s: Array) -> Array:
    """Strictly rising times from the first frame's on, which splines need; a file may repeat a time.

    From the first frame's: a file may count its times from 1970, where a double resolves a quarter of a microsecond.
    """
    return np.asarray(np.maximum.accumulate(times_s - times_s[0]) + 1e-7 * np.arange(len(times_s)))


def without_outliers(
    camera_mm: Array, reprojection_px: Array, times_s: Array, numbers: NDArray[np.int64] | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Camera centres (T, 3) with those of misregistered frames interpolated, and which frames are good.

    A page that is registered one module off, for example in a shaken frame, has a far larger reprojection error than
    others; smoothing would spread its error to its neighbours.  A frame that is only doubted keeps its fringes, as who
    shifts the markers of some frames must not have their fringes left out; but where frames are few, a single one of
    them is as long as a lie, and its neighbours are too far to know its pose from.
    Parameters: numbers: as `stretches`, if they are known; then nothing is interpolated from one stretch to another.
    Convention: a frame is good if its error is at most `STRAY_MEDIANS_RATIO` medians, or `STRAY_PX`, and if it is not
        doubted alone between neighbours that are far.
    """
    usual = float(np.median(reprojection_px))
    doubted = reprojection_px > max(DOUBTED_PX, DOUBTED_MEDIANS_RATIO * usual)
    short, beside = _short_runs(doubted, times_s), np.convolve(doubted, [1, 0, 1], "same") > 0
    good = reprojection_px <= max(STRAY_PX, STRAY_MEDIANS_RATIO * usual)
    good &= ~doubted | short | beside
    sound = good & ~short
    if sound.all() or not sound.any():
        return camera_mm, good
    clock = rising(times_s)
    tangents = camera_mm[:, :2] / camera_mm[:, 2:]
    columns = np.column_stack([tangents, camera_mm[:, 2]])
    for stretch in [np.arange(len(clock))] if numbers is None else unbroken(times_s, np.inf, numbers):
        own = stretch[sound[stretch]]
        if len(own):
            for k in range(3):
                columns[stretch, k] = np.interp(clock[stretch], clock[own], columns[own, k])
    return np.column_stack([columns[:, 0] * columns[:, 2], columns[:, 1] * columns[:, 2], columns[:, 2]]), good


def _short_runs(doubted: NDArray[np.bool_], times_s: Array) -> NDArray[np.bool_]:
    """The doubted frames whose neighbours are near: over a longer time a poor pose is better than none."""
    short = np.zeros_like(doubted)
    places = np.flatnonzero(doubted)
    for run in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1):
        if len(run):
            before, after = max(int(run[0]) - 1, 0), min(int(run[-1]) + 1, len(doubted) - 1)
            short[run] = times_s[after] - times_s[before] <= GAP_S
    return short


def slow_part(series: Array, times_s: Array, spread_s: float, numbers: NDArray[np.int64] | None = None) -> Array:
    """The slow part of a series, (T,) or (T, B): a Gaussian mean of standard deviation `spread_s`, not across gaps."""
    slow = np.empty_like(series)
    for stretch in unbroken(times_s, GAP_S, numbers):
        slow[stretch] = gaussian_mean(series[stretch], spread_s / max(frame_s(times_s[stretch]), 1e-4))
    return slow


def smooth_camera(
    camera_mm: Array,
    times_s: Array,
    tangent_error: tuple[float, float],
    vague: Array | None = None,
    numbers: NDArray[np.int64] | None = None,
) -> Array:
    """Camera centres smoothed over time, (T, 3); tangent_error: of one frame, as in `CameraFit`; vague (T, 2): factor
    on the error of each frame, None if all are 1.

    The direction of the camera is noisy and its distance is not, so the tangents Cx/Cz and Cy/Cz and the distance are
    smoothed separately.  Generalised cross-validation on the film chooses one of a few cut-offs.  None of them is low
    enough to remove a hand's motion.
    Convention: as `CameraFit`.
    Source: natural cubic smoothing spline (Woltring 1986 uses it for body motion the same way), whose response to a
    frequency f is 1 / (1 + (f / cut-off)^4).
    """
    columns = np.column_stack([camera_mm[:, 0] / camera_mm[:, 2], camera_mm[:, 1] / camera_mm[:, 2], camera_mm[:, 2]])
    # The film's own scatter is that of its usual frame, be it one with a marker covered.
    spread = None if vague is None else vague / np.median(vague, axis=0)
    for stretch in unbroken(times_s, GAP_S, numbers):
        if len(stretch) >= 8:
            clock = rising(times_s[stretch])
            for k in range(3):
                explained = SMOOTHED_ERROR_RATIO * tangent_error[k] if k < 2 else 0.0
                weights = spread[stretch, k] ** -2.0 if spread is not None and k < 2 else None
                columns[stretch, k] = _smooth(clock, columns[stretch, k], explained, weights)
    return np.column_stack([columns[:, 0] * columns[:, 2], columns[:, 1] * columns[:, 2], columns[:, 2]])


def _smooth(clock: Array, values: Array, explained: float, weights: Array | None = None) -> Array:
    """The smoothing spline of the lowest cut-off if its RMS residual is at most `explained`.

    Otherwise that of the cut-off which predicts left-out samples best.  Cross-validation alone would take errors that
    last over some frames for motion; up to `explained` they count as errors.
    """
    count, length = len(clock), float(clock[-1] - clock[0])
    best: tuple[float, Array] | None = None
    for cut_off in CUT_OFFS_HZ:
        if cut_off > 0.5 * count / length:
            continue
        stiffness = count / length / (2 * np.pi * cut_off) ** 4
        curve = smoothed(clock, values, stiffness, weights)
        freedom = np.sum(1 / (1 + (np.arange(count) / (2 * length) / cut_off) ** 4))
        left = float(np.sum((values - curve) ** 2 if weights is None else weights * (values - curve) ** 2))
        if cut_off == CUT_OFFS_HZ[0] and np.sqrt(left / count) <= explained:
            return curve
        score = left / (1 - freedom / count) ** 2
        if best is None or score < best[0]:
            best = score, curve
    return best[1] if best else values


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
    tangents = np.column_stack([_smooth_path(camera[:, k] / camera[:, 2], times_s) for k in (0, 1)])
    direction = np.column_stack([tangents, np.ones(len(frames))])
    far = camera[:, 2].copy()
    seen = (points_px - np.array(centre)) / focal
    for _ in range(STEPS):
        towards = -np.einsum("tij,tj->ti", rotation, direction)
        local = plane @ rotation.swapaxes(-1, -2) + (towards * far[:, None])[:, None]
        flat = local[..., :2] / local[..., 2:]
        residual = (flat - seen).reshape(len(frames), -1)
        # A rotation is about the camera, so the plane moves with it; a step of distance is a share of it.
        x, y, away = flat[..., 0], flat[..., 1], far[:, None] / local[..., 2]
        along_x = [-x * y, 1 + x * x, -y, (towards[:, :1] - x * towards[:, 2:]) * away]
        along_y = [-1 - y * y, x * y, x, (towards[:, 1:2] - y * towards[:, 2:]) * away]
        both = [np.stack(pair, axis=-1) for pair in zip(along_x, along_y, strict=True)]
        table = np.stack(both, axis=-1).reshape(len(frames), -1, 4)
        normal = table.swapaxes(-1, -2) @ table
        step = -np.linalg.solve(normal + 1e-12 * np.eye(4), table.swapaxes(-1, -2) @ residual[..., None])[..., 0]
        rotation, far = rotations(step[:, :3]) @ rotation, far * (1 + step[:, 3])
    return np.asarray(focal * np.sqrt((residual**2).sum(axis=1) / len(plane)))


def _smooth_path(values: Array, times_s: Array) -> Array:
    """The part of a series below `CUT_OFF_HZ`; never across gaps."""
    smooth = values.copy()
    for stretch in unbroken(times_s, GAP_S):
        if len(stretch) >= 8:
            clock = rising(times_s[stretch])
            stiffness = len(clock) / (clock[-1] - clock[0]) / (2 * np.pi * CUT_OFF_HZ) ** 4
            smooth[stretch] = smoothed(clock, values[stretch], stiffness)
    return smooth
