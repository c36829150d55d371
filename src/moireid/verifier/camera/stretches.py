"""Stretches: runs of frames within which the badge was followed without a break.

Fringe phase is known modulo a turn, and a badge that is lost, cut or turned within one frame may have moved by any
number of turns meanwhile.  So what is between two stretches is no evidence, neither for a badge nor against it: each
stretch has a phase constant of its own, and only motion seen within one counts.  Else a still picture, shown at two
views a whole turn apart, would obey the law at both.

Convention: stretches are numbered from 0 in the order of time; tangents (T, 2) are the parallax coordinates Cx/Cz and
Cy/Cz.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.measuring import JUMP_NOISE_SDS, MAX_GAP_S, MAX_MISSING_FRAMES, MAX_TURN_PER_S2, MIN_GAP_S
from moireid.verifier.series import greatest_near, median_near

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: Frames on either side of a jump, and around it by which the usual scatter of poses is known.
SIDE, AROUND = 3, 31


def stretch_numbers(times_s: Array, tangents: Array, cuts: NDArray[np.bool_] | None = None) -> Numbers:
    """The number of each frame's stretch, (T,).

    Parameters: cuts (T,): frames before which the picture jumps, if that is known.
    Convention: a stretch ends where more than one frame is missing, and where the picture or the camera's direction
        jumps (`jumps`).
    """
    ends = np.zeros(len(times_s), bool)
    ends[1:] = (np.diff(times_s) > longest_step_s(times_s)) | jumps(times_s, tangents)
    if cuts is not None:
        ends |= cuts
    return np.cumsum(ends)


def longest_step_s(times_s: Array, least_s: float = MIN_GAP_S) -> float:
    """The longest time between two frames of one stretch: one may be missing, or more in so short a time.

    Parameters: least_s: 0 asks for neighbours alone.
    """
    steps = np.diff(times_s)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    return min(max(MAX_MISSING_FRAMES * usual, least_s), MAX_GAP_S)


def jumps(times_s: Array, tangents: Array) -> NDArray[np.bool_]:
    """Between which neighbouring frames the camera's direction jumps, (T - 1,).

    A hand speeds a badge or a camera up by no more than `MAX_TURN_PER_S2`; a plain cut moves it within one frame.
    Source: the medians of `SIDE` frames on either side, less the motion that the steps around let expect, against the
    usual size of that difference within a second or so; medians, because a single pose may err.  From rest to rest a
    hand moves by a quarter of its acceleration times the time squared; within one frame four times that is allowed.
    """
    found = np.zeros(max(len(times_s) - 1, 0), bool)
    if len(times_s) < 2 * SIDE + 2:
        return found
    steps, clock = np.diff(tangents, axis=0), even_or_apart(times_s)
    here = slice(SIDE - 1, len(found) - SIDE + 1)
    middles = np.median(np.lib.stride_tricks.sliding_window_view(tangents, SIDE, axis=0), axis=-1)
    usual_step, speed = (median_near(series, 4 * SIDE - 1)[here] for series in (steps, steps / np.diff(clock)[:, None]))
    # Frames may go on at half their rate, which is no jump by time; and a few may be missing, which is none by number.
    spans = (SIDE * usual_step, speed * (clock[1:-1][SIDE:] - clock[1:-1][:-SIDE])[:, None])
    sudden = np.min([np.abs(middles[SIDE:] - middles[:-SIDE] - expected) for expected in spans], axis=0)
    usual = 1.4826 * median_near(sudden, AROUND)
    time = np.diff(times_s)[here]
    reach = MAX_TURN_PER_S2 * np.where(time > 1.5 * np.median(time), time / 2, time) ** 2
    over = (sudden / np.maximum(reach[:, None], JUMP_NOISE_SDS * usual)).max(axis=1)
    # Windows that straddle a cut next to their middle see some of it too: the cut is where they see most, or next to it
    # where the step itself is larger.
    size = np.linalg.norm(steps, axis=1)
    for place in np.flatnonzero((over > 1) & (over == greatest_near(over, 2 * SIDE - 1))) + here.start:
        first = max(int(place) - 1, 0)
        found[first + int(np.argmax(size[first : int(place) + 2]))] = True
    return found


def even_or_apart(times_s: Array) -> Array:
    """Times that are apart by a quarter of the usual step at least: a file may repeat a time."""
    steps = np.diff(times_s)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 1.0
    return np.concatenate([[0.0], np.cumsum(np.maximum(steps, usual / 4))])


def within_stretches(series: Array, numbers: Numbers) -> Array:
    """A series without the mean of each of its stretches, (T,)."""
    place = numbers - numbers.min(initial=0)
    means = np.bincount(place, weights=series) / np.maximum(np.bincount(place), 1)
    return np.asarray(series - means[place])
