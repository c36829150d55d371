"""Do all places of a strip move alike?  How far the fringes at one place deviate from those of the whole strip.

The phase of a strip is a mean over its length.  Small patches that move differently cancel in this mean.  So the shape
of the fringe is learnt from the film, and the residual of each frame is turned into a phase shift of each block.
Residuals that stay still (dirt, shading, an uneven lens sheet) are not motion and are removed.

Convention: phases in rad, positive as in `strip_phase`.
Source: a small phase shift d adds w'(phase) d to a profile of shape w, so least squares gives the shift of a block as
    the sum of residual times w' over the sum of w'^2.  This is first order in d, which is enough to detect a shift.
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
#: Blocks of a strip: 7 mm each on a badge 80 mm wide; a camera at 2 m resolves a few millimetres.
BLOCKS = 12
HARMONICS = 5


def places_apart_rad(profiles: Array, law: StripLaw, found: StripPhase, times_s: Array) -> float:
    """Deviation of the blocks from their strip, root mean square over blocks and time, rad.

    Parameters: profiles (T, N) counts; law: of the same frames and samples; found: the strip as it was measured;
        times_s (T,).
    Returns: 0 if there are no fringes.
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
    # Remove the motion that all blocks share (the signal), and the constant of each block (an uneven sheet).
    for axis in (1, 0):
        total = weight.sum(axis=axis, keepdims=True)
        shift = shift - (weight * shift).sum(axis=axis, keepdims=True) / np.where(total > 0, total, 1.0)
    return float(np.sqrt((weight * shift**2).sum() / weight.sum()))


def _averaged(series: Array, frames: int) -> Array:
    """Moving mean over `frames` frames, (T, B)."""
    return np.asarray(uniform_filter1d(series, frames, axis=0, mode="nearest"))
