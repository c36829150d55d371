"""Does one camera explain all poses of a film, or was its picture zoomed, reframed or stabilised?

A program that follows a face, zooms or stabilises moves the optical axis and the focal length within the film.  A zoom
can often be solved (`zoom_course`).  The course of an axis cannot, from the badge alone: it changes poses much as
another focal length does.  But both show.  The errors that one camera leaves are then no longer those of single frames,
but go on over many frames.

Convention: residuals (T, 2 N) px of N points, as `PlanePoses.residuals_px`.
Source: the slow part of the residuals, less what white noise leaves in it; noise by the difference of neighbouring
    frames (von Neumann 1941).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import CUT_OFFS_HZ, GAP_S, slow_part, unbroken
from moireid.verifier.measuring import STRAY_MEDIANS_RATIO

Array = NDArray[np.float64]
#: Standard deviation of the mean over time that separates what lasts from noise, s.
LASTING_S = 0.25
#: Share of the noise that is left in such a mean.  White noise leaves 0.19 at 30 frames a second and 0.27 at 15; a
#: codec repeats its errors for a few frames.
NOISE_LEFT_SHARE = 0.45
#: Least power that smoothing removes, over what it keeps.
LEAST_REMOVED = 1e-6
#: Standard deviation of the mean that halves the frequency at which smoothing halves, s.
SMOOTHED_S = math.sqrt(2 * math.log(2)) / (2 * math.pi * CUT_OFFS_HZ[0])


def lasting_error_px(residuals_px: Array, times_s: Array, numbers: NDArray[np.int64]) -> tuple[float, float]:
    """Reprojection error that lasts longer than noise does, and the noise, root mean squares over points, px.

    Parameters: numbers (T,): as `stretches`.
    Convention: module docstring; misregistered frames count as bounded.
    """
    errors, known = _bounded(residuals_px)
    if len(known) < 2:
        return 0.0, 0.0
    clock, numbers = times_s[known], numbers[known]
    slow = _slow(errors, clock, LASTING_S, numbers)
    runs = [run for run in unbroken(clock, GAP_S, numbers) if len(run) > 1]
    steps = np.concatenate([np.diff(errors[run], axis=0) for run in runs]) if runs else errors
    # The square of a point's error is the sum of those of its two coordinates.
    lasting, noise = 2 * float((slow**2).mean()), float((steps**2).mean())
    return math.sqrt(max(lasting - NOISE_LEFT_SHARE**2 * noise, 0.0)), math.sqrt(noise)


def slow_to_fast(residuals_px: Array, times_s: Array, numbers: NDArray[np.int64]) -> float:
    """How much of the residuals is too slow for smoothing to remove, over what it removes; 0 where it removes nothing.

    A coder that saves leaves small markers as they were for some frames, so their errors are slow.  Poses share them,
    but in a pose what is slow cannot be told from motion.  In the residuals it can.
    Parameters: numbers (T,): as `stretches`.
    Convention: as `lasting_error_px`.
    Source: one coordinate of a homography errs as another does, so slow and fast parts have one ratio in all of them.
    """
    errors, known = _bounded(residuals_px)
    if len(known) < 2:
        return 0.0
    slow = _slow(errors, times_s[known], SMOOTHED_S, numbers[known])
    kept, removed = float((slow**2).mean()), float(((errors - slow) ** 2).mean())
    # Of frames that are too far apart to be smoothed, rounding alone is removed.
    return math.sqrt(kept / removed) if removed > LEAST_REMOVED * kept else 0.0


def _bounded(residuals_px: Array) -> tuple[Array, NDArray[np.int64]]:
    """The residuals of the frames that have some, with those of misregistered frames bounded, and which they are."""
    size = np.sqrt((residuals_px**2).mean(axis=1))
    known = np.flatnonzero(np.isfinite(size))
    if not len(known):
        return residuals_px[known], known
    most = STRAY_MEDIANS_RATIO * float(np.median(size[known]))
    return residuals_px[known] * np.minimum(1.0, most / np.maximum(size[known], 1e-12))[:, None], known


def _slow(errors: Array, times_s: Array, spread_s: float, numbers: NDArray[np.int64]) -> Array:
    return np.column_stack([slow_part(column, times_s, spread_s, numbers) for column in errors.T])
