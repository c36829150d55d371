"""Phase without jumps of a turn: which frames join, and whole turns between those that do not.

Convention: phases in rad, one a frame, (T,); segments are index arrays of frames, in time's order.
Source: Itoh's condition: a phase can be unwrapped where neighbours differ by less than half a turn.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import unbroken
from moireid.verifier.limits import MAX_GAP_S, MAX_STEP_RAD

Array = NDArray[np.float64]
Frames = NDArray[np.int64]


def joined_frames(predicted_rad: Array, times_s: Array, numbers: Frames | None = None) -> list[Frames]:
    """Segments of frames in which each frame's phase can be told from the one before.

    numbers (T,): of the frames' stretches, which no segment crosses.
    They end at gaps, and where the camera went so fast that the optics predict a step of nearly half a turn or more.
    """
    fast = np.abs(np.diff(predicted_rad)) > MAX_STEP_RAD
    return [
        part
        for stretch in unbroken(times_s, MAX_GAP_S, numbers)
        for part in np.split(stretch, np.flatnonzero(fast[stretch[:-1]]) + 1)
    ]


def numbered(segments: Sequence[Frames], count: int) -> Frames:
    """The number of each frame's segment, (T,); a frame of none has that of the segment before."""
    begins = np.zeros(count, np.int64)
    for segment in segments[1:]:
        begins[segment[0]] = 1
    return np.cumsum(begins)


def unwrap(phase_rad: Array, predicted_rad: Array, segments: Sequence[Frames]) -> Array:
    """Phase without jumps of a turn, (T,).

    Within a segment each frame follows the one before, whatever the prediction says.  Whole turns between segments
    cannot be seen: there the number of turns is taken that lies nearest to the prediction, which gives a forger whole
    turns a gap and nothing else.  Frames of no segment have no phase, and get the prediction.
    """
    longest = max(segments, key=len, default=np.zeros(0, int))
    if not len(longest):
        return predicted_rad.copy()
    anchor = float(np.mean(np.unwrap(phase_rad[longest]) - predicted_rad[longest]))
    unwrapped = predicted_rad + anchor
    for segment in segments:
        unwrapped[segment] = np.unwrap(phase_rad[segment])
        if segment is not longest:
            apart = float(np.mean(unwrapped[segment] - predicted_rad[segment])) - anchor
            unwrapped[segment] -= 2 * np.pi * np.round(apart / (2 * np.pi))
    return unwrapped
