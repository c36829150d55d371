"""Smoothing the camera's course over time, as far as a hand's own motion allows.

Convention: as `camera`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline
from scipy.ndimage import gaussian_filter1d

from moireid.verifier.limits import SMOOTHED_ERROR_RATIO, STRAY_MEDIANS_RATIO, STRAY_PX

Array = NDArray[np.float64]
#: Two frames further apart than this tell no velocity, and are not smoothed into one another.
GAP_S = 0.15
#: Cut-offs of smoothing.  A hand's path is slower than 2 Hz, of which the lowest leaves 83 %, and of 1 Hz 99 %.
CUT_OFFS_HZ = (3.0, 4.0, 6.0, 9.0, 14.0)


def unbroken(times_s: Array, gap_s: float, numbers: NDArray[np.int64] | None = None) -> list[NDArray[np.int64]]:
    """Frames grouped into runs without a gap of more than `gap_s`, each of one stretch; numbers: as `stretches`."""
    ends = np.diff(times_s) > gap_s
    if numbers is not None:
        ends |= np.diff(numbers) != 0
    return np.split(np.arange(len(times_s)), np.flatnonzero(ends) + 1)


def frame_s(times_s: Array, gap_s: float = GAP_S) -> float:
    """Mean time from one frame to the next, gaps left out; `gap_s` where there is nothing else.

    The mean and not the median: a file may tell each time thrice, and the median would then be nothing.
    """
    steps = np.diff(times_s)
    steps = steps[steps <= gap_s]
    return float(steps.mean()) if steps.sum() > 0 else gap_s


def _rising(times_s: Array) -> Array:
    """Times that rise strictly, as splines need; a file may repeat one."""
    return np.asarray(np.maximum.accumulate(times_s) + 1e-7 * np.arange(len(times_s)))


def without_strays(camera_mm: Array, reprojection_px: Array, times_s: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Camera centres (T, 3), those of misregistered frames put where their neighbours are, and which frames are good.

    A page that was registered a module off, in a shaken frame say, leaves many times more unexplained than any other;
    smoothing would drag its neighbours along.
    Convention: good are residuals of at most `STRAY_MEDIANS_RATIO` medians, or `STRAY_PX`.
    """
    good = reprojection_px <= max(STRAY_PX, STRAY_MEDIANS_RATIO * float(np.median(reprojection_px)))
    if good.all() or not good.any():
        return camera_mm, good
    clock = _rising(times_s)
    tangents = camera_mm[:, :2] / camera_mm[:, 2:]
    columns = [np.interp(clock, clock[good], column[good]) for column in (*tangents.T, camera_mm[:, 2])]
    return np.column_stack([columns[0] * columns[2], columns[1] * columns[2], columns[2]]), good


def slow_part(series: Array, times_s: Array, spread_s: float, numbers: NDArray[np.int64] | None = None) -> Array:
    """A series without what is fast, (T,): a Gaussian mean of standard deviation `spread_s`, not across gaps."""
    slow = np.empty_like(series)
    for stretch in unbroken(times_s, GAP_S, numbers):
        slow[stretch] = gaussian_filter1d(
            series[stretch], spread_s / max(frame_s(times_s[stretch]), 1e-4), mode="nearest"
        )
    return slow


def smooth_camera(
    camera_mm: Array,
    times_s: Array,
    tangent_error: tuple[float, float],
    vague: Array | None = None,
    numbers: NDArray[np.int64] | None = None,
) -> Array:
    """Camera centres smoothed over time, (T, 3); tangent_error: of one frame, as `CameraFit` has it; vague
    (T, 2): by how many times a frame errs more, None where none does.

    The direction of the camera is noisy, its distance is not; so the tangents Cx/Cz and Cy/Cz and the distance are
    smoothed apart.  How much is chosen from the film itself by generalised cross-validation among a few cut-offs, none
    so low that a hand's own motion would be eaten.
    Convention: as `CameraFit`.
    Source: natural cubic smoothing spline (Woltring 1986 uses it for body motion the same way), whose response to a
    frequency f is 1 / (1 + (f / cut-off)^4).
    """
    clock = _rising(times_s)
    columns = np.column_stack([camera_mm[:, 0] / camera_mm[:, 2], camera_mm[:, 1] / camera_mm[:, 2], camera_mm[:, 2]])
    for stretch in unbroken(times_s, GAP_S, numbers):
        if len(stretch) >= 8:
            for k in range(3):
                explained = SMOOTHED_ERROR_RATIO * tangent_error[k] if k < 2 else 0.0
                weights = vague[stretch, k] ** -2.0 if vague is not None and k < 2 else None
                columns[stretch, k] = _smooth(clock[stretch], columns[stretch, k], explained, weights)
    return np.column_stack([columns[:, 0] * columns[:, 2], columns[:, 1] * columns[:, 2], columns[:, 2]])


def _smooth(clock: Array, values: Array, explained: float, weights: Array | None = None) -> Array:
    """The smoothing spline of the lowest cut-off, if it leaves no more than `explained` (RMS).

    Else that of the cut-off which predicts left-out samples best.  Errors that last over some frames would deceive
    cross-validation, which takes them for motion; up to `explained` they are taken for errors.
    """
    count, length = len(clock), float(clock[-1] - clock[0])
    best: tuple[float, Array] | None = None
    for cut_off in CUT_OFFS_HZ:
        if cut_off > 0.5 * count / length:
            continue
        stiffness = count / length / (2 * np.pi * cut_off) ** 4
        course = np.asarray(make_smoothing_spline(clock, values, w=weights, lam=stiffness)(clock))
        freedom = np.sum(1 / (1 + (np.arange(count) / (2 * length) / cut_off) ** 4))
        left = float(np.sum((values - course) ** 2 if weights is None else weights * (values - course) ** 2))
        if cut_off == CUT_OFFS_HZ[0] and np.sqrt(left / count) <= explained:
            return course
        score = left / (1 - freedom / count) ** 2
        if best is None or score < best[0]:
            best = score, course
    return best[1] if best else values
