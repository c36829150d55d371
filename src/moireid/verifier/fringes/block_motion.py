"""Do all places of a strip move alike?  How far the fringes at one place deviate from those of the whole strip.

The phase of a strip is a mean over its length.  Small patches that move differently cancel in this mean.  So what the
fringes' shape leaves of each frame is turned into a phase shift of each block.

Convention: phases in rad, positive as in `strip_phase`.
Source: `strip_shape`: least squares gives the shift of a block as the sum of left-over times slope over the sum of the
    slope's square.  This is first order in the shift, which is enough to detect it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import frame_s
from moireid.verifier.fringes.strip_shape import StripShape
from moireid.verifier.measuring import PLACE_MEAN_S, PLACE_MIN_INFORMATION_SHARE
from moireid.verifier.series import moving_mean

Array = NDArray[np.float64]
#: Blocks of a strip: 7 mm each on a badge 80 mm wide; a camera at 2 m resolves a few millimetres.
BLOCKS = 12


def places_apart_rad(shape: StripShape | None, times_s: Array) -> float:
    """Deviation of the blocks from their strip, root mean square over blocks and time, rad.

    Parameters: shape: of the strip, None if there are no fringes; times_s (T,).
    Returns: 0 if there are no fringes.
    Source: module docstring.
    """
    if shape is None:
        return 0.0
    times_s = times_s[shape.clear]
    borders = np.linspace(0, shape.left.shape[1], BLOCKS + 1).astype(int)[:-1]
    frames = max(1, round(PLACE_MEAN_S / max(frame_s(times_s, PLACE_MEAN_S), 1e-3)))
    information = moving_mean(np.add.reduceat(shape.slope**2, borders, axis=1), frames)
    correlated = moving_mean(np.add.reduceat(shape.left * shape.slope, borders, axis=1), frames)
    weight = np.where(information > PLACE_MIN_INFORMATION_SHARE * np.median(information), information, 0.0)
    if not weight.sum() > 0:
        return 0.0
    shift = correlated / np.maximum(information, 1e-12)
    # Remove the motion that all blocks share (the signal), and the constant of each block (an uneven sheet).
    for axis in (1, 0):
        total = weight.sum(axis=axis, keepdims=True)
        shift = shift - (weight * shift).sum(axis=axis, keepdims=True) / np.where(total > 0, total, 1.0)
    return float(np.sqrt((weight * shift**2).sum() / weight.sum()))
