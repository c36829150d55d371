"""The stability suite: stiff and extreme badges, builds, pictures and motions.

Each must be read correctly, or be inconclusive with the reason; never wrongly.  One clip a case, made to be at the edge
of what a badge, its building, its picture or its motion can be, and beyond it.

right: as physics expects.  inconclusive: although the film shows enough: a shortfall.  refused: a beat of zero, or of
the wrong sign, whose fringes move against the law, just like those of a reversed forgery.  wrong: a true film is
rejected, one that shows nothing is accepted, or another identity is read.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge, Rect
from moireid.designer import Order, design_badge
from moireid.errors import MoireIdError
from moireid.question import KnownCamera
from moireid.simulate.motion import Motion, Poses, motion_named
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Camera, Scene
from moireid.simulate.shots import Edit
from moireid.verifier import Question, Report, verify
from moireid_lab.bench.part import INCONCLUSIVE, OWN, RIGHT, WRONG, Asked, Part, Row, temporary_film

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
Outcome = Literal["right", "inconclusive", "refused", "wrong"]
#: What physics expects: that the identity is read; a verdict; or the code of the reason why it must be inconclusive.
Expected = Literal["read", "accept", "accept or inconclusive", "motion", "gain", "badge_absent"]
PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FPS, FRAMES, CRF = 30.0, 150, 28
#: The usual camera; and a small picture, in which a thousand full searches take a minute.
ZOOMED, NARROW = Camera(1280, 720, 1450.0), Camera(640, 360, 483.0)
#: Phase of the fringes by parallax at the first order, rad: 2 pi g_eff / p_r of the default sheet.
SLOPE_RAD = 7.25


@dataclass(frozen=True)
class StabilityCase:
    """One case: how the badge is made, built and filmed, and what physics expects.

    beat: share of the reference row's designed beat that is left, made by a sheet of another pitch; hidden: part of
    the board that is covered, as shares of its width and height; contrast: of the print, (paper - ink)/(paper + ink);
    motion: by name, or itself; frames: None for the usual number; known: whether the focal length is given; edit: what
    becomes of the pictures before they are coded.
    """

    name: str
    expected: Expected = "read"
    request: Order = field(default_factory=lambda: Order("Bench", lens="50lpi"))
    payload: bytes = PAYLOAD
    twist_deg: float = 0.1
    beat: float = 1.0
    hidden: tuple[float, float, float, float] | None = None
    contrast: float | None = None
    distance_m: float = 1.4
    motion: str | Motion = "sway"
    fps: float = FPS
    frames: int | None = None
    camera: Camera = ZOOMED
    known: bool = True
    recipe: str | None = None
    edit: Edit | None = None


def held(slide_mm: Callable[[Array], Array] | None = None, turn_deg: Callable[[Array], Array] | None = None) -> Motion:
    """A badge 1.4 m away that is slid (T, 3) and turned about its own y, x and z axes (T, 3) before a still camera."""

    def poses(times_s: Array) -> Poses:
        nothing = np.zeros((len(times_s), 3))
        slid = slide_mm(times_s) if slide_mm else nothing
        turned = Rotation.from_euler("yxz", turn_deg(times_s) if turn_deg else nothing, degrees=True)
        return Poses(-turned.inv().apply(slid + np.array([0.0, 0.0, 1400.0])), turned.as_matrix())

    return poses


def panned(turn_deg: Callable[[Array], Array]) -> Motion:
    """A camera that turns on a tripod before a badge at rest."""

    def poses(times_s: Array) -> Poses:
        place = np.tile([0.0, 0.0, -1400.0], (len(times_s), 1))
        return Poses(place, Rotation.from_euler("yxz", turn_deg(times_s), degrees=True).as_matrix())

    return poses


def swing(axis: int, amplitude: float, hz: float, middle: float = 0.0) -> Callable[[Array], Array]:
    """A sine along one of three axes, (T, 3)."""

    def course(times_s: Array) -> Array:
        found = np.zeros((len(times_s), 3))
        found[:, axis] = middle + amplitude * np.sin(2 * math.pi * hz * times_s)
        return found

    return course


def built_and_filmed() -> list[StabilityCase]:
    """Badges, builds and pictures; each group begins with one that must be read."""
    small, large = (
        Order("Bench", lens="50lpi", size_mm=(96.0, 110.0), range_m=(0.5, 0.9)),
        Order("Bench", lens="50lpi", size_mm=(186.0, 273.0)),
    )
    return [
        *(
            StabilityCase(f"beat at {100 * share:g} % of the design", beat=share)
            for share in (0.9, 0.5, 0.2, 0.0, -0.5, -1.0)
        ),
        *(StabilityCase(f"twist {degrees:g} degrees", twist_deg=degrees) for degrees in (0.3, 0.45, 0.7, 1.5, 5.0)),
        *(
            StabilityCase(
                f"twist 1.2 degrees, {axes}",
                request=Order("Bench", lens="50lpi", axes=axes, range_m=(0.8, 2.0)),
                twist_deg=1.2,
            )
            for axes in ("xy", "hex")
        ),
        StabilityCase("smallest board, 0.7 m", request=small, distance_m=0.7),
        StabilityCase("largest board", request=Order("Bench", lens="50lpi", size_mm=large.size_mm, range_m=(1.2, 2.5))),
        StabilityCase("quarter hidden, a corner", hidden=(0.0, 0.0, 0.5, 0.5)),
        StabilityCase("quarter hidden, the right edge", hidden=(0.75, 0.0, 1.0, 1.0)),
        StabilityCase("quarter hidden, the middle", hidden=(0.25, 0.25, 0.75, 0.75)),
        StabilityCase("quarter hidden, the top", hidden=(0.0, 0.0, 1.0, 0.25)),
        *(StabilityCase(f"print contrast {100 * c:g} %", contrast=c) for c in (0.2, 0.1, 0.05, 0.02)),
        *(StabilityCase(f"distance {metres:g} m", distance_m=metres) for metres in (0.6, 3.0, 4.0, 6.0)),
        StabilityCase("no motion", motion="static"),
        StabilityCase("payload of zeros", payload=bytes(8)),
        StabilityCase("payload of ones", payload=b"\xff" * 8),
    ]


def moved() -> list[StabilityCase]:
    """Motions and frames, by a camera whose focal length is not given."""
    half_fringe_mm = 1400 * math.pi / 2 / SLOPE_RAD

    def of(name: str, motion: str | Motion = "sway", expected: Expected = "accept", **how: Any) -> StabilityCase:
        usual: dict[str, Any] = {"camera": Camera(), "known": False}
        return StabilityCase(name, expected, motion=motion, **usual | how)

    return [
        of("frontal, slid 15 cm sideways", held(swing(0, 150, 0.4))),
        of("the same, zoomed in 1.5 times", held(swing(0, 150, 0.4)), "gain", camera=ZOOMED),
        of("frontal, tilted by half a degree", held(None, swing(0, 0.5, 0.4)), "motion"),
        of("frontal, slid 8 cm sideways", held(swing(0, 80, 0.4))),
        of("turned about its upright axis", held(None, swing(0, 12, 0.4))),
        of("turned in the picture's plane", held(None, swing(2, 25, 0.4)), "motion"),
        of("camera pans on a tripod", panned(swing(0, 6, 0.4)), "motion"),
        of("slid along the lines only", held(swing(1, 150, 0.4)), "motion"),
        of("half a fringe", held(swing(0, half_fringe_mm, 0.3))),
        of("a sixteenth of a fringe", held(swing(0, half_fringe_mm / 8, 0.3)), "motion"),
        of("a quarter of a turn of phase a frame", held(None, swing(0, 30, 2.0))),
        of("over half a turn a frame", held(None, swing(0, 35, 4.0)), "accept or inconclusive"),
        *(
            of(f"{fps} frames a second", fps=fps, frames=frames)
            for fps, frames in ((24, 150), (60, 300), (120, 360), (240, 720))
        ),
        of("variable rate", recipe="vfr"),
        of("view at 45 degrees", held(swing(0, 120, 0.4), swing(0, 0, 0, 45))),
        of("view at 60 degrees", held(swing(0, 60, 0.4), swing(0, 0, 0, 60))),
        of("two transcodes", recipe="double", frames=240, distance_m=1.0),
        of("first frame black", edit=_first_black),
        of("first frame smeared", edit=_first_smeared),
        of("two frames", expected="badge_absent", frames=2),
        of("a thousand frames of nothing", "static", "badge_absent", frames=1000, camera=NARROW, edit=_nothing),
    ]


def cases() -> dict[str, StabilityCase]:
    """All cases by name."""
    return {case.name: case for case in (*built_and_filmed(), *moved())}


def read_case(job: tuple[str, int, int]) -> Row:
    """Film one case and read it; it is sent by its name, as motions cannot travel to another process."""
    name, seed, usual = job
    case = cases()[name]
    badge = design_badge(case.request, case.payload)
    grating = badge.gratings[0]
    designed = 1 / grating.pitch_mm - 1 / badge.lens.pitch_mm
    lens_scale = 1 / (badge.lens.pitch_mm * (1 / grating.pitch_mm - case.beat * designed))
    build = Build(0.17, math.radians(case.twist_deg), 1.001, 1.001 * lens_scale)
    scene = Scene(badge, build, case.camera, hidden_mm=_part_of(badge, case.hidden))
    if case.contrast is not None:
        scene = replace(scene, paper=0.5, ink=0.5 * (1 - case.contrast) / (1 + case.contrast))
    motion = case.motion
    if isinstance(motion, str):
        motion = motion_named(motion, distance_mm=1000 * case.distance_m, seed=seed if case.known else 4)
    frames = case.frames or usual
    how = {"frames": frames, "fps": case.fps, "seed": seed, "recipe": case.recipe, "edit": case.edit}
    row: Row = {"name": name, "expected": case.expected, "frames": frames, "verdict": None, "codes": []}
    try:
        with temporary_film(scene, motion, crf=CRF if case.known else None, **how) as video:
            report = verify(
                video, Question(badge, badge.id, camera=KnownCamera(case.camera.focal_px) if case.known else None)
            )
    except MoireIdError as error:
        right = "right" if case.expected == "badge_absent" else "inconclusive"
        return row | {"outcome": right, "why": str(error)}
    against = [reason for level in ("fail", "undecided") for reason in report.reasons if reason.level == level]
    codes = [reason.code for reason in against]
    found = {"outcome": outcome_of(case, report, badge, codes), "verdict": report.verdict, "codes": codes}
    return row | found | {"why": against[0].text if against else ""}


def outcome_of(case: StabilityCase, report: Report, badge: Badge, codes: list[str]) -> Outcome:
    """As the module docstring says; codes: of the reasons against acceptance."""
    decoded, verdict = report.identity.decoded_id, report.verdict
    if decoded not in (None, badge.id):
        return "wrong"
    if verdict == "reject":
        return "refused" if case.beat <= 0 else "wrong"
    if case.expected == "read":
        return "right" if decoded == badge.id else "inconclusive"
    if verdict == "accept":
        return "right" if case.expected.startswith("accept") else "wrong"
    return "right" if case.expected == "accept or inconclusive" or case.expected in codes else "inconclusive"


def _nothing(frame: int, luma: Luma, homography: Array) -> Luma:
    """A picture of a background, with noise, over which the camera pans."""
    turned = panned(swing(0, 5, 0.1))(np.array([frame / FPS])).rotation[0]
    return np.asarray(Sensor(NARROW, frame).expose(None, turned, frame / FPS))


def _first_black(frame: int, luma: Luma, homography: Array) -> Luma:
    return luma if frame else np.zeros_like(luma)


def _first_smeared(frame: int, luma: Luma, homography: Array) -> Luma:
    return luma if frame else np.asarray(cv2.blur(luma, (81, 1)), np.uint8)


def _part_of(badge: Badge, shares: tuple[float, float, float, float] | None) -> Rect | None:
    """A part of the board, page mm."""
    if shares is None:
        return None
    x0, y0, x1, y1 = badge.outline_mm
    left, top, right, bottom = shares
    return (x0 + left * (x1 - x0), y0 + top * (y1 - y0), x0 + right * (x1 - x0), y0 + bottom * (y1 - y0))


def judged(name: str, folder: Path) -> Row:
    """One case."""
    row = read_case((name, 0, FRAMES))
    answer = {"right": RIGHT, "wrong": WRONG}.get(row["outcome"], INCONCLUSIVE)
    return {"kind": row["expected"], "answers": {"edge": answer}, "verdict": row["verdict"], "why": row["codes"]}


def named(asked: Asked) -> dict[str, str]:
    """All cases."""
    return {name: name for name in cases()}


QUESTIONS = {"edge": "Is a stiff or extreme badge, build, picture or motion judged as physics expects?"}
PART = Part(QUESTIONS, OWN, named, judged, 4)
