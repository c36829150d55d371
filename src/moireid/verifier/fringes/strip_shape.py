"""The shape of a strip's fringes, learnt from the film, and what it leaves unexplained in each frame.

Convention: brightness is in contrasts, (profile - level) / contrast; phases in rad, positive as in `strip_phase`.
Source: a small phase shift d adds w'(phase) d to a profile of shape w, so the left-over against w' gives any
    deviation of places along the strip, to first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.predicted_phase import StripLaw
from moireid.verifier.fringes.sinusoid import fit_series, series, series_slope
from moireid.verifier.fringes.strip_phase import StripPhase
from moireid.verifier.limits import PLACE_CLEAR_RAD

Array = NDArray[np.float64]
HARMONICS = 5


@dataclass(frozen=True)
class StripShape:
    """One strip in its clear frames: K of T frames, N samples.

    clear (T,): frames whose phase is read well; turned_rad (K, N): argument of the shape; left (K, N): what the shape
    leaves of the brightness, without what stands still (dirt, shading, an uneven lens sheet); slope (K, N): derivative
    of the shape by its argument, contrasts per rad.
    """

    clear: NDArray[np.bool_]
    turned_rad: Array
    left: Array
    slope: Array


def strip_shape(profiles: Array, law: StripLaw, found: StripPhase) -> StripShape | None:
    """The shape of one strip; None if no frame is clear.

    Parameters: profiles (T, N) counts; law: of the same frames and samples; found: the strip as it was measured.
    Source: module docstring.
    """
    clear = found.phase_sd_rad < PLACE_CLEAR_RAD
    if not clear.any():
        return None
    turned = law.phase_rad(found.frequency_per_mm)[clear] + found.phase_rad[clear, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        seen = (profiles[clear] - found.level[clear, None]) / found.contrast[clear, None]
    seen = np.nan_to_num(seen, posinf=0.0, neginf=0.0)
    shape = fit_series(seen, turned, HARMONICS)
    left = seen - series(shape, turned)
    left -= left.mean(axis=0)
    return StripShape(clear, turned, left, series_slope(shape, turned))
