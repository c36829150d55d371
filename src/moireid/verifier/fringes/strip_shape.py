"""The shape of a strip's fringes, learnt from the film, and what it leaves unexplained in each frame.

Convention: brightness is in contrasts, (profile - level) / contrast; phases in rad, positive as in `strip_phase`.
    Single precision resolves some millionths of a contrast and of a radian, and noise leaves a thousand times that.
Source: a small phase shift d adds w'(phase) d to a profile of shape w, so the left-over against w' gives any
    deviation of places along the strip, to first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.predicted_phase import StripLaw
from moireid.verifier.fringes.sinusoid import Single, fit_columns, fit_together, slope_of
from moireid.verifier.fringes.strip_phase import StripPhase, level_and_slope
from moireid.verifier.measuring import PLACE_CLEAR_RAD

Array = NDArray[np.float64]
HARMONICS = 5


@dataclass(frozen=True)
class StripShape:
    """One strip in its clear frames: K of T frames, N samples.

    clear (T,): frames whose phase is read well; columns (K, 2 + 2 HARMONICS, N): level, slope along the strip, and
    cosine and sine of each harmonic, as `fit_columns` of the shape's argument; left (K, N): what the shape leaves of
    the brightness, without what stands still (dirt, shading, an uneven lens sheet); slope (K, N): derivative of the
    shape by its argument, contrasts per rad.
    """

    clear: NDArray[np.bool_]
    columns: Single
    left: Single
    slope: Single


def strip_shape(profiles: Array, law: StripLaw, found: StripPhase) -> StripShape | None:
    """The shape of one strip; None if no frame is clear.

    Parameters: profiles (T, N) counts; law: of the same frames and samples; found: the strip as it was measured.
    Source: module docstring.
    """
    clear = found.phase_sd_rad < PLACE_CLEAR_RAD
    if not clear.any():
        return None
    turned = law.phase_rad(found.frequency_per_mm)[clear] + found.phase_rad[clear, None]
    columns = fit_columns(turned.astype(np.float32), HARMONICS, level_and_slope(turned.shape[1]))
    with np.errstate(divide="ignore", invalid="ignore"):
        contrasts = (profiles[clear] - found.level[clear, None]) / found.contrast[clear, None]
    seen = np.nan_to_num(contrasts, posinf=0.0, neginf=0.0).astype(np.float32)
    # A slope of the background is not the shape's, so it is left out here.
    together = np.moveaxis(columns, 1, 0).reshape(columns.shape[1], -1)
    fringes = fit_together(together, seen.ravel(), np.arange(columns.shape[1]) != 1)
    left = seen - (fringes @ together).reshape(seen.shape)
    left -= left.mean(axis=0)
    return StripShape(clear, columns, left, (slope_of(fringes) @ together).reshape(seen.shape))
