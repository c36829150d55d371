"""Uniform cells and their beat levels, shared by every family: the arithmetic of pitches and frequency differences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from moireid.badge import Cell, Code, Grating
from moireid.errors import CodeError
from moireid.frames import own_rect
from moireid.idcodes.family import CellReading
from moireid.optics import rear_pitch_for_beat_mm

#: A reading is unclear if it is further than this from every level, in steps, or if its error bar is larger.
UNCLEAR_BEYOND_STEPS = 0.35


def code_of(grating: Grating) -> Code:
    """The grating's code.  Raises: CodeError where it carries none."""
    if grating.code is None:
        raise CodeError("this grating carries no code; it can be checked for motion alone")
    return grating.code


def level_pitch_mm(code: Code, level: int, front_pitch_mm: float) -> float:
    """Printed pitch of a beat level under that front pitch.

    Convention: as `optics.beat_frequency_per_mm` at infinite distance.  Source: p = 1 / (1/p_f + f).
    """
    frequency = code.base_frequency_per_mm + code.frequency_step_per_mm * level
    return float(rear_pitch_for_beat_mm(front_pitch_mm, frequency))


def line_up(cell: Cell, grating: Grating, pitch_mm: float, shift: float = 0.0) -> Cell:
    """The cell with that pitch: a dark line is centred on the grating's middle, then moved by `shift` of a pitch.

    With this common line the fringes of all uniform cells meet in the middle of a badge built without twist.
    """
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    middle_mm = (low + high) / 2
    return replace(cell, pitch_mm=pitch_mm, edge_mm=middle_mm + (shift - cell.duty / 2) * pitch_mm)


def steps_from_reference(readings: Sequence[CellReading], grating: Grating) -> list[tuple[float, float]]:
    """Level of each cell less that of the reference, in steps with standard deviation; unread cells are infinite.

    Convention: page scale drops out, as markers and lines are printed together; lens pitch, distance and tilt shift
    all cells alike and drop out of the difference.
    """
    code = code_of(grating)
    reference = readings[code.reference_cell]
    found = []
    for reading in readings:
        steps = (reading.frequency_per_mm - reference.frequency_per_mm) / code.frequency_step_per_mm
        sd = math.hypot(reading.frequency_sd, reference.frequency_sd) / abs(code.frequency_step_per_mm)
        found.append((steps, sd if math.isfinite(steps) else math.inf))
    return found
