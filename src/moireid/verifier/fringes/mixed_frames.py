"""Are frames mixed with their neighbours?

Temporal noise reduction and a change of the frame rate mix frames.  At one pixel the fringe's phase turns from frame to
frame, as the page moves in the picture and as the parallax changes.  A frame that holds a share w of the one before
adds two fringes that are apart by this `turn`.  The phase of the sum is wrong, and its contrast shows that, because it
dips with the turn:

    |1 - w + w exp(i turn)|^2 = 1 - 2 w (1 - w) (1 - cos turn).

A long exposure blurs in the same way: open all frame long, the mean over a turn keeps 1 - turn^2 / 24, as w (1 - w) of
a twelfth does.  More than that is mixed.

Convention: angles in rad, positive as in `strip_phase`; a series has one entry per frame, (T,).
Source: sum of two waves; linear regression of the contrast's logarithm, first order in w (1 - w).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.frames import OwnFrame
from moireid.verifier.camera.stretches import longest_step_s
from moireid.verifier.limits import MIXED_SDS
from moireid.verifier.measuring import MAX_STEP_RAD

Array = NDArray[np.float64]
#: Fewer frames than this are too few for a regression of four unknowns.
LEAST_FRAMES = 50


def carried_rad(
    homographies: Array, frame: OwnFrame, middle_mm: Array, frequency_per_mm: float, times_s: Array
) -> Array:
    """By how much the page, at rest to the camera's parallax, turned the fringe at one pixel since the frame before.

    Parameters: homographies (T, 3, 3): page -> picture; frame, middle_mm (2,): of the grating whose pixel is meant, own
        mm.
    Convention: 2 pi f times how far on the page that pixel lay before; 0 for the first frame and after a missing one.
    Returns: (T,).
    """
    seen = homographies[1:] @ np.append(frame.on_page(middle_mm), 1.0)
    before = np.linalg.solve(homographies[:-1], seen[..., None])[..., 0]
    moved_mm = frame.places(before[:, :2] / before[:, 2:])[:, 0] - middle_mm[0]
    moved_mm[np.diff(times_s) > longest_step_s(times_s, least_s=0.0)] = 0.0
    return np.asarray(np.concatenate([[0.0], 2 * np.pi * frequency_per_mm * moved_mm]))


def mixed_share(contrast: Array, carried_rad: Array, predicted_rad: Array) -> float:
    """The least w (1 - w) that explains how contrast dips with the turn, within `MIXED_SDS`; 0 where none is seen.

    Parameters: contrast (T,): not a number where it is not known; predicted_rad (T,): the parallax turns the fringe
        too, and contrast depends on it, and so on this phase and its square.
    """
    turn_rad = carried_rad - np.diff(predicted_rad, prepend=predicted_rad[0])
    used = np.isfinite(contrast) & (contrast > 0) & (np.abs(turn_rad) < MAX_STEP_RAD)
    if used.sum() < LEAST_FRAMES:
        return 0.0
    law = predicted_rad[used] - predicted_rad[used].mean()
    table = np.column_stack([1 - np.cos(turn_rad[used]), np.ones(used.sum()), law, law**2])
    log_contrast = np.log(contrast[used])
    found, *_ = np.linalg.lstsq(table, log_contrast, rcond=None)
    left = log_contrast - table @ found
    try:
        variance = float(np.linalg.inv(table.T @ table)[0, 0])
    except np.linalg.LinAlgError:
        return 0.0
    sd = float(np.sqrt(left @ left / (len(left) - table.shape[1]) * variance))
    return max(-float(found[0]) - MIXED_SDS * sd, 0.0)
