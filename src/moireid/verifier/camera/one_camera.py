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

from moireid.verifier.camera.smoothing import GAP_S, slow_part, unbroken
from moireid.verifier.limits import STRAY_MEDIANS_RATIO

Array = NDArray[np.float64]
#: Standard deviation of the mean over time that separates what lasts from noise, s.
LASTING_S = 0.25
#: Share of the noise that is left in such a mean.  White noise leaves 0.19 at 30 frames a second and 0.27 at 15; a
#: codec repeats its errors for a few frames.
NOISE_LEFT_SHARE = 0.45


def lasting_error_px(residuals_px: Array, times_s: Array, numbers: NDArray[np.int64]) -> tuple[float, float]:
    """Reprojection error that lasts longer than noise does, and the noise, root mean squares over points, px.

    Parameters: numbers (T,): as `stretches`.
    Convention: module docstring; misregistered frames count as bounded.
    """
    size = np.sqrt((residuals_px**2).mean(axis=1))
    known = np.flatnonzero(np.isfinite(size))
    if len(known) < 2:
        return 0.0, 0.0
    most = STRAY_MEDIANS_RATIO * float(np.median(size[known]))
    errors = residuals_px[known] * np.minimum(1.0, most / np.maximum(size[known], 1e-12))[:, None]
    clock, numbers = times_s[known], numbers[known]
    slow = np.column_stack([slow_part(column, clock, LASTING_S, numbers) for column in errors.T])
    runs = [run for run in unbroken(clock, GAP_S, numbers) if len(run) > 1]
    steps = np.concatenate([np.diff(errors[run], axis=0) for run in runs]) if runs else errors
    # The square of a point's error is the sum of those of its two coordinates.
    lasting, noise = 2 * float((slow**2).mean()), float((steps**2).mean())
    return math.sqrt(max(lasting - NOISE_LEFT_SHARE**2 * noise, 0.0)), math.sqrt(noise)
