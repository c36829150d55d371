"""What the neighbours of a cell add to its phase, where lines pass into each other.

A smooth field blends the *numbers* of the lines, and the picture blurs the fringes besides.  Both are known: once each
cell's symbol is read, the lines of the whole field are known, so the phase that every sample of a cell shows ahead of
that of its own lines is computed, and taken off what was measured.  A wrong symbol makes the phases of its neighbours
wrong by as much as if they had not been corrected.

Convention: phases in rad, positive where the fringes are ahead; own millimetres (`moireid.frames`).
Source: the fringe of a line of number n is ahead by 2 pi n, as a shift of s of the pitch p counts n down by s/p
    (`moireid.idcodes.spacing`); a blur of the picture averages exp(i phase).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.idcodes.pitch import level_pitch_mm, line_up
from moireid.idcodes.spacing import PHASE_LEVELS, lined_up
from moireid.smooth_lines import LineField
from moireid.verifier.measuring import PICTURE_BLUR_PX
from moireid.verifier.tracking.brightness_profiles import read_across_mm
from moireid.verifier.tracking.registration import scale_px_per_mm
from moireid.verifier.tracking.track import Track

Array = NDArray[np.float64]
#: Distance of the places at which the field is computed, mm.
STEP_MM = 0.5


def ahead_of_own_lines(track: Track, grating: int, places: Mapping[int, int], steps: Sequence[int]) -> dict[int, Array]:
    """How far the fringes of each phase cell are ahead of those of its own lines.

    Parameters
    ----------
    track : Track
        Its layout and its scale in the picture are used.
    grating : int
        A smooth one, of the spacing family.
    places : mapping of int to int
        Of each phase cell, the place of its symbol on the circle, 0 to `PHASE_LEVELS` - 1.
    steps : sequence of int
        Beat level of each uniform cell less that of its reference, in the order of the cells.

    Returns
    -------
    dict of int to array (N,)
        By cell, rad, at the samples of its strip; of use within and near the cell.

    Notes
    -----
    Convention and source: module docstring.
    """
    own, front = track.badge.gratings[grating], track.badge.lens.pitch_mm
    assert own.code is not None
    phase_cells = [cell for cell, role in enumerate(own.code.roles) if role == "phase"]
    lines = lined_up(own, iter([places[cell] for cell in phase_cells]), steps, front)
    field = LineField(replace(own, cells=lines))
    counts = [int((high - low) / STEP_MM) + 1 for low, high in ((field.low, field.high), (field.begin, field.end))]
    along, across = np.linspace(field.low, field.high, counts[0]), np.linspace(field.begin, field.end, counts[1])
    reference = line_up(own.cells[own.code.reference_cell], own, level_pitch_mm(own.code, 0, front))
    turns = field.numbers(along, across[:, None]) - (along - reference.edge_mm) / reference.pitch_mm
    seen = _blurred(np.exp(2j * np.pi * turns), _blur_mm(track, field, grating) / STEP_MM)
    found: dict[int, Array] = {}
    for strip in track.strips:
        if strip.grating != grating or strip.uniform:
            continue
        top, bottom = read_across_mm(own, strip.cells[0])
        row = seen[(across >= top) & (across <= bottom)].mean(axis=0)
        row = np.interp(strip.along_mm, along, row.real) + 1j * np.interp(strip.along_mm, along, row.imag)
        found |= {cell: np.angle(row * np.exp(-2j * np.pi * places[cell] / PHASE_LEVELS)) for cell in strip.cells}
    return found


def _blur_mm(track: Track, field: LineField, grating: int) -> float:
    """The picture's blur on the page, at the middle of the grating and of the film."""
    middle = track.badge.frame_of(track.badge.gratings[grating]).on_page(
        np.array([(field.low + field.high) / 2, (field.begin + field.end) / 2])
    )
    return PICTURE_BLUR_PX / scale_px_per_mm(track.homographies[track.tracked // 2], middle)


def _blurred(values: NDArray[np.complex128], steps: float) -> NDArray[np.complex128]:
    """Complex values (Y, X) blurred by a Gaussian of that standard deviation."""
    parts = np.stack([values.real, values.imag], axis=-1)
    blurred = cv2.GaussianBlur(parts, (0, 0), steps, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(blurred[..., 0] + 1j * blurred[..., 1])
