"""Do all places of a strip move alike?  How far the fringes at some place stray from those of the whole strip.

A strip's phase is a mean over its length, in which patches that are finer than the strip, each on its own clock,
cancel. Here the fringe's own shape is learnt from the film, and what a frame leaves of it is turned into a shift of
phase block by block.  What stands still (dirt, shading, a lens sheet that is not quite even) is no motion and is
taken away.

Convention: phases in rad, positive as in `strip_phase`.
Source: a small shift of phase d adds w'(phase) d to a profile of shape w, so least squares gives the shift of a block
as the sum of residual times w' over the sum of w'^2; first order in d, which is enough to tell that there is one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from moireid.verifier.camera.smoothing import frame_s
from moireid.verifier.fringes.predicted_phase import StripLaw
from moireid.verifier.fringes.sinusoid import fit_series, series, series_slope
from moireid.verifier.fringes.strip_phase import StripPhase
from moireid.verifier.limits import PLACE_CLEAR_RAD, PLACE_MEAN_S, PLACE_MIN_INFORMATION_SHARE

Array = NDArray[np.float64]
#: Blocks of a strip: 7 mm of a badge 80 mm wide, where a few millimetres are the finest that a camera at 2 m tells.
BLOCKS = 12
HARMONICS = 5


def places_apart_rad(profiles: Array, law: StripLaw, found: StripPhase, times_s: Array) -> float:
    """How far blocks of a strip stray from the strip, root mean square over blocks and time, rad.

    Parameters: profiles (T, N) counts; law: of the same frames and samples; found: the strip as it was measured;
        times_s (T,).
    Returns: 0 where there are no fringes.
    Source: module docstring.
    """
    turned = law.phase_rad(found.frequency_per_mm) + found.phase_rad[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        seen = np.nan_to_num((profiles - found.level[:, None]) / found.contrast[:, None], posinf=0.0, neginf=0.0)
    clear = found.phase_sd_rad < PLACE_CLEAR_RAD
    if not clear.any():
        return 0.0
    turned, seen, times_s = turned[clear], seen[clear], times_s[clear]
    shape = fit_series(seen, turned, HARMONICS)
    left, slope = seen - series(shape, turned), series_slope(shape, turned)
    left -= left.mean(axis=0)
    borders = np.linspace(0, seen.shape[1], BLOCKS + 1).astype(int)[:-1]
    frames = max(1, round(PLACE_MEAN_S / max(frame_s(times_s, PLACE_MEAN_S), 1e-3)))
    information = _averaged(np.add.reduceat(slope**2, borders, axis=1), frames)
    correlated = _averaged(np.add.reduceat(left * slope, borders, axis=1), frames)
    weight = np.where(information > PLACE_MIN_INFORMATION_SHARE * np.median(information), information, 0.0)
    if not weight.sum() > 0:
        return 0.0
    shift = correlated / np.maximum(information, 1e-12)
    # The whole strip's own motion is the signal; a block's own constant is a sheet that is not quite even.
    for axis in (1, 0):
        total = weight.sum(axis=axis, keepdims=True)
        shift = shift - (weight * shift).sum(axis=axis, keepdims=True) / np.where(total > 0, total, 1.0)
    return float(np.sqrt((weight * shift**2).sum() / weight.sum()))


def _averaged(series: Array, frames: int) -> Array:
    """The mean over so many frames around each, (T, B)."""
    return np.asarray(uniform_filter1d(series, frames, axis=0, mode="nearest"))
