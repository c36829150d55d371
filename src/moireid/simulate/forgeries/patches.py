"""Forgeries whose parts disagree: patches that each have their own clock, and fringes as generated pictures show them.

A field holds, for each part of the board, the parallax coordinate that it shows less the true one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.lenticule import view_law
from moireid.simulate.forgeries.courses import random_walk
from moireid.simulate.motion import Motion

Array = NDArray[np.float64]
#: Patches down and across the board.  The truth file holds the phase of the lower right patch, which has the centre.
PATCHES = (4, 4)
#: Each patch shows the true motion at another time, at most this far off.
CLOCK_S = 1.5
#: Steps of the generative field, mm: 0.03 rad of phase at its widest.
STEP_MM = 1.0
#: Spread of the generative pitch, as a share of the beat frequency.
PITCH_WANDER = 0.1


def parallax(camera_mm: Array) -> Array:
    """Parallax coordinates (..., 2) of camera centres (..., 3)."""
    return np.asarray(camera_mm[..., :2] / np.abs(camera_mm[..., 2:]))


class OwnClocks:
    """Each patch of the board shows the true motion at its own time, earlier or later by up to `CLOCK_S`."""

    def __init__(self, motion: Motion, seed: int) -> None:
        self._motion = motion
        self._late_s = np.random.default_rng(seed).uniform(-CLOCK_S, CLOCK_S, PATCHES)

    def at(self, time_s: float) -> Array:
        """The field (rows, columns, 2) at that time."""
        clocks = np.concatenate([[time_s], time_s + self._late_s.ravel()])
        shown = parallax(self._motion(clocks).camera_mm)
        return np.asarray((shown[1:] - shown[0]).reshape(*PATCHES, 2))


class Generative:
    """A true first frame; then phase and pitch wander, as in a film whose pictures are generated one by one.

    The phase wanders with the true course's own spread, at random; the beat's frequency wanders by `PITCH_WANDER`.
    Convention: the wandering phase is in the shown place, so the field holds only the change of pitch.
    """

    def __init__(self, badge: Badge, camera_mm: Array, fps: float, seed: int) -> None:
        true = parallax(camera_mm)
        walk = random_walk(len(true), fps, seed)
        walk = true[0] + true.std(axis=0) * (walk - walk[0])
        distance = np.abs(camera_mm[:, 2:])
        self.camera_mm = np.column_stack([walk * distance, camera_mm[:, 2]])
        stretch = random_walk(len(true), fps, seed + 1)
        self._stretch = PITCH_WANDER * (stretch - stretch[0])
        pitch, lens = badge.gratings[0].pitch_mm, badge.lens
        # A stretch s of the beat adds s * (1/p_r - 1/p_f) cycles to each mm; in parallax that is p_r / gap a cycle.
        gap = view_law(lens, pitch).effective_gap_mm(pitch)
        self._per_mm = (1 / pitch - 1 / lens.pitch_mm) * pitch / gap
        x0, y0, x1, y1 = badge.outline_mm
        # With an odd number of steps one lies at the board's centre, where a change of pitch changes nothing.
        self._size = 2 * math.ceil((y1 - y0) / STEP_MM / 2) + 1, 2 * math.ceil((x1 - x0) / STEP_MM / 2) + 1
        self._half = (x1 - x0) / 2, (y1 - y0) / 2

    def at(self, frame: int) -> Array:
        """The field (rows, columns, 2) of that frame."""
        rows, columns = self._size
        x = ((np.arange(columns) + 0.5) / columns * 2 - 1) * self._half[0]
        y = ((np.arange(rows) + 0.5) / rows * 2 - 1) * self._half[1]
        slope = -self._per_mm * self._stretch[frame]
        return np.stack(np.broadcast_arrays(slope[0] * x, slope[1] * y[:, None]), axis=-1)
