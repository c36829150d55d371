"""Phase unwrapping: segments of frames that join, and the number of whole turns between segments.

Convention: phases in rad, one per frame, (T,); segments are index arrays of frames, in order of time.
Source: Itoh's condition: a phase can be unwrapped where neighbours differ by less than half a turn.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import unbroken
from moireid.verifier.measuring import MAX_GAP_S, MAX_STEP_RAD

Array = NDArray[np.float64]
Frames = NDArray[np.int64]


def joined_frames(predicted_rad: Array, times_s: Array, numbers: Frames | None = None) -> list[Frames]:
    """Segments in which each phase can be unwrapped from the one before.

    They end at gaps, and where the predicted phase moves by nearly half a turn or more between two frames;
    and with each stretch, whose numbers (T,) may be given.
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

    Within a segment the prediction is not used.  Between segments the number of whole turns is unknown, so the one
    nearest to the prediction is taken.  A forger gains no more than whole turns per gap from that.  Frames outside all
    segments have no phase and get the prediction.
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
