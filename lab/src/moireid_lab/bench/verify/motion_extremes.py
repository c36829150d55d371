"""Stiff and extreme motions: each must be read correctly, or be inconclusive with the reason.

Each case is one film with the outcome that physics expects: it is accepted, or it is inconclusive for a stated reason,
because its motion cannot test the law.  A true film must never be rejected.

right: as expected.  inconclusive: although the film shows enough: a shortfall.  wrong: a true film is rejected, a
film that shows nothing is accepted, a figure is not finite, or the program crashes.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import MoireIdError
from moireid.simulate.filming import truth_path
from moireid.simulate.motion import Motion, Poses, motion_named
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Camera, Scene
from moireid.simulate.shots import Edit
from moireid.verifier import Question, Report, verify
from moireid_lab.bench.bench_frame import temporary_film

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
Outcome = Literal["right", "inconclusive", "wrong"]
#: What physics expects: a verdict of the film, or the code of the reason for which it must be inconclusive.
Expected = Literal["accept", "accept or inconclusive", "motion", "gain", "badge_absent"]
PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FPS, FRAMES = 30.0, 150
#: A phone's camera zoomed in 1.5 times, or cut to its middle: a focal length that no verifier would guess.
ZOOMED = Camera(1280, 720, 1450.0)
#: A small picture, in which a thousand full searches take a minute.
NARROW = Camera(640, 360, 483.0)
#: Phase of the fringes by parallax at the first order, rad: 2 pi g_eff / p_r of the default sheet.
SLOPE_RAD = 7.25


#: Figures of a row that a case may lack.
FIGURES = ("verdict", "true_excitation_rad", "correlation", "gain_ratio", "gain_sd", "residual_rad")


def held(
    distance_m: float,
    *,
    slide_mm: Callable[[Array], Array] | None = None,
    turn_deg: Callable[[Array], Array] | None = None,
) -> Motion:
    """A badge that is slid (T, 3) and turned about its own y, x and z axes (T, 3) before a still camera."""

    def poses(times_s: Array) -> Poses:
        nothing = np.zeros((len(times_s), 3))
        slid = slide_mm(times_s) if slide_mm else nothing
        turned = Rotation.from_euler("yxz", turn_deg(times_s) if turn_deg else nothing, degrees=True)
        return Poses(-turned.inv().apply(slid + np.array([0.0, 0.0, 1000 * distance_m])), turned.as_matrix())

    return poses


def panned(distance_m: float, turn_deg: Callable[[Array], Array]) -> Motion:
    """A camera that turns on a tripod before a badge at rest."""

    def poses(times_s: Array) -> Poses:
        place = np.tile([0.0, 0.0, -1000 * distance_m], (len(times_s), 1))
        return Poses(place, Rotation.from_euler("yxz", turn_deg(times_s), degrees=True).as_matrix())

    return poses


def swing(axis: int, amplitude: float, hz: float, middle: float = 0.0) -> Callable[[Array], Array]:
    """A sine along one of three axes, (T, 3)."""

    def course(times_s: Array) -> Array:
        found = np.zeros((len(times_s), 3))
        found[:, axis] = middle + amplitude * np.sin(2 * math.pi * hz * times_s)
        return found

    return course


@dataclass(frozen=True)
class Extreme:
    """One case: what moves, how it is filmed, what is spoiled of it, and what physics expects.

    edit: what becomes of the pictures before they are coded; quick: part of a quick run.
    """

    name: str
    motion: Motion
    expected: Expected = "accept"
    fps: float = FPS
    frames: int = FRAMES
    camera: Camera = field(default_factory=Camera)
    contrast: float | None = None
    recipe: str | None = None
    edit: Edit | None = None
    quick: bool = False


def cases() -> list[Extreme]:
    """All cases, by what they strain."""
    sway = [motion_named("sway", distance_mm=1000.0 * metres, seed=4) for metres in (1.4, 3.0, 4.0, 1.0)]
    still = motion_named("static", distance_mm=1400.0, seed=0)
    half_fringe_mm = 1400 * math.pi / 2 / SLOPE_RAD
    return [
        Extreme("frontal, slid 15 cm sideways", held(1.4, slide_mm=swing(0, 150, 0.4)), quick=True),
        Extreme("the same, zoomed in 1.5 times", held(1.4, slide_mm=swing(0, 150, 0.4)), "gain", camera=ZOOMED),
        Extreme("frontal, tilted by half a degree", held(1.4, turn_deg=swing(0, 0.5, 0.4)), "motion"),
        Extreme("frontal, slid 8 cm sideways", held(1.4, slide_mm=swing(0, 80, 0.4))),
        Extreme("turned about its upright axis", held(1.4, turn_deg=swing(0, 12, 0.4))),
        Extreme("turned in the picture's plane", held(1.4, turn_deg=swing(2, 25, 0.4)), "motion", quick=True),
        Extreme("camera pans on a tripod", panned(1.4, swing(0, 6, 0.4)), "motion"),
        Extreme("slid along the lines only", held(1.4, slide_mm=swing(1, 150, 0.4)), "motion"),
        Extreme("half a fringe", held(1.4, slide_mm=swing(0, half_fringe_mm, 0.3))),
        Extreme("a sixteenth of a fringe", held(1.4, slide_mm=swing(0, half_fringe_mm / 8, 0.3)), "motion"),
        Extreme("a quarter of a turn of phase a frame", held(1.4, turn_deg=swing(0, 30, 2.0))),
        Extreme(
            "over half a turn a frame", held(1.4, turn_deg=swing(0, 35, 4.0)), "accept or inconclusive", quick=True
        ),
        *(
            Extreme(f"{fps} frames a second", sway[0], fps=fps, frames=frames)
            for fps, frames in ((24, 150), (60, 300), (120, 360), (240, 720))
        ),
        Extreme("variable rate", sway[0], recipe="vfr"),
        Extreme("3 m", sway[1], frames=240),
        Extreme("4 m", sway[2], frames=240),
        Extreme("view at 45 degrees", held(1.4, slide_mm=swing(0, 120, 0.4), turn_deg=swing(0, 0, 0, 45))),
        Extreme("view at 60 degrees", held(1.4, slide_mm=swing(0, 60, 0.4), turn_deg=swing(0, 0, 0, 60)), quick=True),
        Extreme("print contrast 5 %", sway[0], contrast=0.05),
        Extreme("two transcodes", sway[3], recipe="double", frames=240),
        Extreme("first frame black", sway[0], edit=_first_black, quick=True),
        Extreme("first frame smeared", sway[0], edit=_first_smeared),
        Extreme("two frames", sway[0], "badge_absent", frames=2, quick=True),
        Extreme("a thousand frames of nothing", still, "badge_absent", FPS, 1000, NARROW, edit=_nothing(), quick=True),
    ]


def extreme_jobs(*, quick: bool, seed: int) -> dict[str, tuple[str, int]]:
    """The cases of a run by name, as their motions cannot travel to another process."""
    return {case.name: (case.name, seed) for case in cases() if case.quick or not quick}


def read_extreme(job: tuple[str, int]) -> dict[str, Any]:
    """Film one case and judge it; one row."""
    name, seed = job
    case = next(case for case in cases() if case.name == name)
    badge = design_badge(Order("Bench", lens="50lpi"), PAYLOAD)
    row: dict[str, Any] = {
        "extreme": case.name,
        "expected": case.expected,
        "outcome": "wrong",
        "reasons": [],
        "why": "",
    }
    row |= {"tracked": 0, "frames": case.frames} | dict.fromkeys(FIGURES)
    scene = Scene(badge, Build(0.17, math.radians(0.1), 1.001, 1.001), case.camera)
    if case.contrast is not None:
        share = (1 - case.contrast) / (1 + case.contrast)
        scene = replace(scene, ink=0.5 * share, paper=0.5)
    how = {"frames": case.frames, "fps": case.fps, "seed": seed, "recipe": case.recipe, "edit": case.edit}
    try:
        with temporary_film(scene, case.motion, **how) as video:
            row["true_excitation_rad"] = _true_excitation(video)
            report = verify(video, Question(badge, badge.id))
    except MoireIdError as error:
        return row | {"outcome": outcome_of(case.expected, "inconclusive", []), "why": str(error)}
    # A crash is a result of this bench, and the next cases must still run.
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        return row | {"why": f"crash: {type(error).__name__}: {error}"}
    return row | _figures(case, report, badge)


def _figures(case: Extreme, report: Report, badge: Badge) -> dict[str, Any]:
    """What came out."""
    motion = report.invariant
    why = [reason for level in ("fail", "undecided") for reason in report.reasons if reason.level == level]
    outcome = outcome_of(case.expected, report.verdict, [reason.code for reason in why])
    texts = [reason.text for reason in why]
    figures = (motion.correlation, motion.gain_ratio, motion.gain_sd, motion.phase_residual_rad, motion.score)
    if not all(math.isfinite(value) for value in figures if value is not None):
        outcome, texts = "wrong", ["a figure is not finite", *texts]
    if report.identity.decoded_id not in (None, badge.id):
        outcome, texts = "wrong", [f"read as {report.identity.decoded_id}", *texts]
    return {
        "verdict": report.verdict,
        "outcome": outcome,
        "reasons": [reason.code for reason in why],
        "why": texts[0] if texts else "",
        "correlation": _number(motion.correlation),
        "gain_ratio": _number(motion.gain_ratio),
        "gain_sd": _number(motion.gain_sd),
        "residual_rad": _number(motion.phase_residual_rad),
        "tracked": report.frames["tracked"],
        "frames": report.frames["read"],
    }


def outcome_of(expected: Expected, verdict: str, codes: list[str]) -> Outcome:
    """Right, inconclusive or wrong, as defined in the module docstring; codes: of the reasons against acceptance."""
    if verdict == "reject" or (verdict == "accept" and not expected.startswith("accept")):
        return "wrong"
    if verdict == "accept" or expected == "accept or inconclusive" or expected in codes:
        return "right"
    return "inconclusive"


def _true_excitation(video: Path) -> float | None:
    """Standard deviation of the true phase; None where the law is not traced for the view."""
    with truth_path(video).open(encoding="utf-8", newline="") as stream:
        phases = [float(row["phase_rad"]) for row in csv.DictReader(stream)]
    return _number(float(np.nanstd(phases))) if np.isfinite(phases).any() else None


def _nothing() -> Edit:
    """Pictures of a background, with noise, over which the camera pans."""
    sensor, pan = Sensor(NARROW, 0), panned(1.0, swing(0, 5, 0.1))

    def edit(frame: int, luma: Luma, homography: Array) -> Luma:
        return np.asarray(sensor.expose(None, pan(np.array([frame / FPS])).rotation[0], frame / FPS))

    return edit


def _first_black(frame: int, luma: Luma, homography: Array) -> Luma:
    return luma if frame else np.zeros_like(luma)


def _first_smeared(frame: int, luma: Luma, homography: Array) -> Luma:
    return luma if frame else np.asarray(cv2.blur(luma, (81, 1)), np.uint8)


def _number(value: float | None) -> float | None:
    """The figure for JSON, None where it is not finite."""
    return float(f"{value:.6g}") if value is not None and math.isfinite(value) else None
