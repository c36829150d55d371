"""The ground truth of a film: pose, parallax and shown fringe phase of each frame, as CSV.

frame, time_s: number and time in the file, of the picture's middle row; frames that a recipe drops have no row.
    Where an effect retimes or mixes frames, all else is of the camera's frame that weighs most.
camera_*_mm, r11 to r33: the true camera, board -> camera, in the board frame of `motion`; before mirroring.
parallax_x, parallax_y: of the true camera, Cx/|Cz| and Cy/|Cz|.
phase_rad: of the fringes as shown, forged or not, at the board's centre.  Where the parts of a forged badge disagree,
    the part that holds the centre counts: for `patchy`, the lower right patch.  nan where the view is steeper than the
    table of the law (63 degrees).
label: "genuine", or "forged:KIND".
shown_x, shown_y: parallax coordinates from which the fringes at the board's centre are shown; the true ones if genuine.
phase_other_rad, phase_third_rad: as phase_rad, for the first grating of a second and of a third axis; nan where the
    badge has none.
sheet_gain: how far the traced sheet moves fringes near the axis, over the badge's own; the same in every row.
build_*: the whole build, the same in every row: each number of `build.Build`, in full.

`Stages` counts the seconds of each stage.
"""

from __future__ import annotations

import csv
import math
import time
from dataclasses import replace
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Grating
from moireid.lenticule import MAX_TANGENT, view_law
from moireid.sheets import effective_gap_mm
from moireid.simulate.analytic.traced_sheet import sheet_as_built, traced_gap_mm
from moireid.simulate.build import BUILD_NUMBERS
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
#: Most axes whose phase is written.
MOST_AXES = 3
TRUTH_COLUMNS = (
    "frame",
    "time_s",
    "camera_x_mm",
    "camera_y_mm",
    "camera_z_mm",
    *(f"r{row}{column}" for row in "123" for column in "123"),
    "parallax_x",
    "parallax_y",
    "phase_rad",
    "label",
    "shown_x",
    "shown_y",
    "phase_other_rad",
    "sheet_gain",
    "phase_third_rad",
    *(f"build_{name}" for name in BUILD_NUMBERS),
)


def shown_phase_rad(scene: Scene, grating: Grating, shown_mm: Array, sight_mm: Array, field: Array) -> float:
    """Phase of a grating's fringes at the board's centre, as it is measured in a film rectified to the page's plane.

    Parameters: shown_mm, sight_mm (3,): as in `rear_layer.ShownViews`; field (2,): parallax added at the centre.
    Convention: phase by `lenticule.ViewLaw` for the grating's pitch, with print and sheet of their nominal scale, and
        without what changes over the sheet; nan beyond its table.  A gap below the sheet hides a part of each lens
        from aside; it, and lenses that are not round, add what they do near the axis.
    Source: the line of sight to the page's centre crosses the lenses at -g t; the lenses show there what is seen from
        the shown place.  Where both places are equal, this is the law for the page's plane.
    """
    lens, pitch = scene.lens, grating.pitch_mm
    frame = scene.badge.frame_of(grating)
    crossing = scene.height_mm * sight_mm[:2] / abs(sight_mm[2])
    tangents = (crossing - shown_mm[:2]) / (abs(shown_mm[2]) - scene.height_mm) - field
    if np.abs(tangents).max() > MAX_TANGENT:
        return math.nan
    lines = 1 / pitch - 1 / lens.pitch_mm
    (across, along), offset = frame.directions(tangents), float(frame.directions(crossing)[0])
    view = float(view_law(lens, pitch, laid=scene.build.air_gap_mm > 0).phase_rad(across, along))
    if scene.build.air_gap_mm or scene.build.conic:
        more_mm = sheet_gap_mm(scene, pitch) - effective_gap_mm(lens, pitch)
        view += 2 * math.pi * more_mm * float(across) / pitch
    return view + 2 * math.pi * lines * offset


def sheet_gap_mm(scene: Scene, pitch_mm: float) -> float:
    """How far the sheet as built moves fringes near the axis, as a length: phase = 2 pi g tan_x / p_r.

    Source: `sheets.effective_gap_mm`; lenses that are not round are traced by the renderer, and differ from round ones
        by as much.
    """
    lens, build = scene.lens, scene.build
    gap_mm = effective_gap_mm(lens, pitch_mm, build.air_gap_mm)
    if build.conic and lens.kind == "lenticular":
        sheet = sheet_as_built(replace(scene, build=replace(build, lens_scale=1.0)))
        gap_mm += traced_gap_mm(sheet, pitch_mm) - traced_gap_mm(sheet._replace(conic=0.0), pitch_mm)
    return gap_mm


class Truth:
    """Writes the rows of a film's truth as its frames are made."""

    def __init__(self, stream: TextIO, scene: Scene, label: str) -> None:
        badge, self._scene, self._label = scene.badge, scene, label
        pitch_mm = badge.gratings[0].pitch_mm
        self._gain = sheet_gap_mm(scene, pitch_mm) / effective_gap_mm(badge.lens, pitch_mm)
        self._build = [repr(float(getattr(scene.build, name))) for name in BUILD_NUMBERS]
        of_axis = {grating.axis: grating for grating in reversed(badge.gratings)}
        self._gratings = [of_axis[axis] for axis in dict.fromkeys(g.axis for g in badge.gratings)][:MOST_AXES]
        self._writer = csv.writer(stream, lineterminator="\n")
        self._writer.writerow(TRUTH_COLUMNS)

    def add(self, row: int, time_s: float, pose: Poses, shown_mm: Array, sight_mm: Array, field: Array | None) -> None:
        """One frame: its number in the file, its time, the true pose (of one frame), and what is shown."""
        camera = pose.camera_mm[0]
        centre = np.zeros(2) if field is None else field[field.shape[0] // 2, field.shape[1] // 2]
        parallax, shown = camera[:2] / abs(camera[2]), shown_mm[:2] / abs(shown_mm[2]) + centre
        phases = [shown_phase_rad(self._scene, g, shown_mm, sight_mm, centre) for g in self._gratings]
        phases += [math.nan] * (MOST_AXES - len(phases))
        figures = [*camera, *pose.rotation[0].ravel(), *parallax, phases[0]]
        after = [*shown, phases[1], self._gain, phases[2]]
        self._writer.writerow(
            [
                row,
                f"{time_s:.6f}",
                *(f"{value:.6f}" for value in figures),
                self._label,
                *(f"{value:.6f}" for value in after),
                *self._build,
            ]
        )


class Stages:
    """Seconds by stage; encoding runs in parallel to the rest, so only the time that the rest waits for it counts."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(("set up", "render", "sensor", "encode"), 0.0)
        self._clock = 0.0

    def begin(self) -> None:
        """Start the clock."""
        self._clock = time.perf_counter()

    def end(self, stage: str) -> None:
        """Count the time since the last call to a stage."""
        now = time.perf_counter()
        self.seconds[stage] += now - self._clock
        self._clock = now
