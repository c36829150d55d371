"""How exactly a lens pitch is measured from a photograph of the pitch test sheet.

A photograph of the chart is rendered: the sheet's pitch differs from its label, the sheet is turned, and the camera
is to the side.  The program's own reader then measures the pitch.  Reported are its error, and that error in the
reader's own standard deviations.

Convention: pitches in units of the printed page, as a photograph gives them (`moireid.calibration.lens_fit`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.calibration.chart_reading import view_chart
from moireid.calibration.lens_fit import lens_from_views
from moireid.designer.chart import design_chart
from moireid.errors import MoireIdError
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.motion import Poses
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Camera, Instant, Scene

#: A phone's still picture of 12 megapixels, upright like the sheet; its focal length suits a field of 66 degrees.
STILL = Camera(width=3000, height=4000, focal_px=3000.0, shutter_s=0.0)
#: How well the distance is known where the phone notes its focal length, as `moireid calibrate` has it.
NOTED_DISTANCE_SD = 0.06


@dataclass(frozen=True)
class PhotoCase:
    """One photograph: the sheet's pitch over its label's, its twist, and where the camera is."""

    lens: str
    lens_scale: float
    twist_deg: float
    distance_m: float
    aside_deg: float


def cases(count: int, seed: int) -> list[PhotoCase]:
    """Photographs drawn over what the sheet of instructions allows; the same for the same seed."""
    rng = np.random.default_rng(seed)
    return [
        PhotoCase(
            lens=("50lpi", "50lpi", "40lpi", "60lpi")[k % 4],
            lens_scale=1 + float(rng.uniform(-0.003, 0.003)),
            twist_deg=float(rng.uniform(-1, 1)),
            distance_m=float(rng.uniform(0.6, 2.0)),
            aside_deg=float(rng.uniform(-15, 15)),
        )
        for k in range(count)
    ]


def photograph(chart: Badge, case: PhotoCase, seed: int) -> NDArray[np.uint8]:
    """The picture of one case, (height, width) counts."""
    build = Build(
        lens_offset_mm=float(np.random.default_rng(seed).uniform(-0.25, 0.25)),
        twist_rad=math.radians(case.twist_deg),
        lens_scale=case.lens_scale,
    )
    scene = Scene(chart, build, STILL)
    aside = math.radians(case.aside_deg)
    turn = np.array([[math.cos(aside), 0, math.sin(aside)], [0, 1, 0], [-math.sin(aside), 0, math.cos(aside)]])
    camera = -1000 * case.distance_m * turn[2]
    poses = Poses(camera[None], turn[None])
    board = AnalyticRenderer(scene).render(Instant(poses, poses, camera))
    return Sensor(STILL, seed).expose(board, turn, 0.0)


def calibration_figures(*, count: int, seed: int) -> dict[str, Any]:
    """One row a photograph, and the worst and median error in percent and in standard deviations."""
    rows = []
    for k, case in enumerate(cases(count, seed)):
        chart = design_chart(lens=case.lens, printer_dpi=1200)
        row: dict[str, Any] = {
            "lens": case.lens,
            "pitch_error_of_sheet_percent": 100 * (case.lens_scale - 1),
            "twist_deg": case.twist_deg,
            "distance_m": case.distance_m,
            "aside_deg": case.aside_deg,
            "error_percent": None,
            "in_sd": None,
            "refused": None,
        }
        # The focal length that a phone notes has an error of its stated standard deviation.
        focal_px = STILL.focal_px * (1 + NOTED_DISTANCE_SD * float(np.random.default_rng(seed + k).normal()))
        try:
            view = view_chart(photograph(chart, case, seed + k), chart, focal_px=focal_px)
            made = lens_from_views([view], chart, distance_sd_share=NOTED_DISTANCE_SD, distance_from="the bench")
        except MoireIdError as refusal:
            row["refused"] = str(refusal)
        else:
            error = made.lens.pitch_mm / (chart.lens.pitch_mm * case.lens_scale) - 1
            row |= {
                "error_percent": 100 * error,
                "in_sd": error * made.lens.pitch_mm / (made.pitch_sd_mm or math.nan),
                "twist_found_deg": made.found["twist_deg"],
                "bands_used": made.found["bands_used"],
            }
        rows.append(row)
    errors = np.abs([row["error_percent"] for row in rows if row["error_percent"] is not None])
    in_sd = np.array([row["in_sd"] for row in rows if row["in_sd"] is not None])
    return {
        "photographs": len(rows),
        "read": len(errors),
        "worst_error_percent": float(errors.max()) if len(errors) else None,
        "median_error_percent": float(np.median(errors)) if len(errors) else None,
        "rms_in_sd": float(np.sqrt(np.mean(in_sd**2))) if len(errors) else None,
        "rows": rows,
    }
