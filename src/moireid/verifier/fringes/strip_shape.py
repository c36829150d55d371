"""The shape of a strip's fringes over a film, and what it leaves of the brightness, place by place.

The phase of a strip is a mean over its length, in which small patches that move differently cancel.  So the residual of
each frame is turned into a phase shift of each block (`places_apart_rad`).

Convention: phases in rad, positive where the fringe is ahead; brightness of a shape in contrasts, (profile - level) /
    contrast.  Single precision resolves some millionths of a contrast and of a radian, and noise leaves a thousand
    times that.
Source: a small phase shift d adds w'(phase) d to a profile of shape w, so the residual against w' gives any deviation
    of places along the strip, to first order, which is enough to detect it.  Shift of a block: least squares, the sum
    of residual times slope over the sum of the slope's square.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import frame_s
from moireid.verifier.fringes.sinusoid import Single, fit_columns, fit_series, in_blocks, wave_and_slope
from moireid.verifier.fringes.strip_phase import StripLaw, StripPhase, level_and_slope
from moireid.verifier.fringes.uneven_air import less_uneven_air
from moireid.verifier.measuring import PLACE_CLEAR_RAD, PLACE_MEAN_S, PLACE_MIN_INFORMATION_SHARE
from moireid.verifier.series import moving_mean

Array = NDArray[np.float64]
HARMONICS = 5


@dataclass(frozen=True)
class StripShape:
    """One strip in its clear frames: K of T frames, N samples.

    clear (T,): frames whose phase is read well; turned (K, N): the shape's argument, rad; left (K, N): what the shape
    leaves of the brightness, without each frame's slope and what stays still (dirt, shading, an uneven lens sheet);
    slope (K, N): derivative of the shape by its argument, contrasts per rad.
    """

    clear: NDArray[np.bool_]
    turned: Single
    left: Single
    slope: Single


def strip_shape(profiles: Array, law: StripLaw, found: StripPhase) -> StripShape | None:
    """The shape of one strip.

    Parameters
    ----------
    profiles : array (T, N)
        Brightness along the strip, `picture.LINEAR_COUNTS`.
    law : StripLaw
        Of the same frames and samples.
    found : StripPhase
        The strip as it was measured.

    Returns
    -------
    StripShape or None
        None if no frame is clear (`PLACE_CLEAR_RAD`).
    """
    clear = found.phase_sd_rad < PLACE_CLEAR_RAD
    if not clear.any():
        return None
    turned = law.phase_rad(found.frequency_per_mm)[clear]
    turned += found.phase_rad[clear, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        contrasts = profiles[clear] - found.level[clear, None]
        contrasts /= found.contrast[clear, None]
    seen = np.nan_to_num(contrasts, copy=False, posinf=0.0, neginf=0.0).astype(np.float32)
    fringes = fit_series(seen, turned, HARMONICS)
    single: Single = turned.astype(np.float32)
    parts = [wave_and_slope(fringes, fit_columns(part, HARMONICS, np.zeros((0, 1)))) for part in in_blocks(single)]
    fringe, slope = (np.concatenate(of_all) for of_all in zip(*parts, strict=True))
    left = seen - fringe - np.float32(fringes[0].real)
    # The slope of the background is each frame's own, and not the shape's.
    sloping = level_and_slope(turned.shape[1])[1].astype(np.float32)
    left -= np.outer(left @ sloping / (sloping @ sloping), sloping)
    left -= left.mean(axis=0)
    return StripShape(clear, single, left, slope)


#: Blocks of a strip: 7 mm each on a badge 80 mm wide; a camera at 2 m resolves a few millimetres.
BLOCKS = 12


def places_apart_rad(shape: StripShape | None, times_s: Array, predicted_rad: Array, air_rad: Array) -> float:
    """Deviation of the blocks from their strip, apart from gains of their own (`uneven_air`).

    Parameters
    ----------
    shape : StripShape or None
        None if there are no fringes.
    times_s : array (T,)
        Of all frames, s.
    predicted_rad : array (T,)
        Predicted phase of all frames.
    air_rad : array (T,)
        What is added to it where the sheet is laid on (`strip_law.air_law`).

    Returns
    -------
    float
        Root mean square over blocks and time, rad; 0 if there are no fringes.
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
    motion, air = moving_mean(np.column_stack([predicted_rad, air_rad])[shape.clear], frames).T
    shift = less_uneven_air(shift.T, weight.T, motion, air).T
    return float(np.sqrt((weight * shift**2).sum() / weight.sum()))
