"""Lenses and builds that no limit may reject: run `moireid lab bench lenses [--only REGEX] [--clips N]`.

A board is filmed by `outside`, which shares nothing with `moireid.simulate`, through lenses of 0.5 to 8 times the
picture's long side, drawn at random, from so far that it is 420 px wide: a badge that is moved flat before a still
camera, a wearer who sways, a camera that walks.  And through one lens as it was built wrong: the page printed at 96 to
104 % of its size, or a sheet of another pitch.  And through webcams whose k1 is -0.4 to 0.1, in the picture's middle
and near its border (`--only k1`).  All of them are true films.  `--only air` is the table of air and angle: sheets
glued or laid on, from five angles, by a pinhole camera, and forged films from the two farthest aside.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from half_real import bent_webcam
from natural_films import prepared
from outside.build import Build, built
from outside.camera import LAPTOP, PHONE, Camera, drawn
from outside.film import Shoot, film
from outside.flaws import Flaws, flawed
from outside.motion import Array, Course, course
from outside.page import load_page

from moireid.badge import load_badge
from moireid.verifier import Question, verify
from moireid_lab.bench.part import OUTSIDE, Asked, Part, Row, film_row, interleaved

FRAMES, FPS = 150, 30
#: Focal lengths over the long side; how wide the board is in the picture, px.
LENSES, WIDE_PX = (0.5, 8.0), 420
MOVES = ("flat", "sway", "arc")
#: Of the page, and of the sheet's pitch, over the design's; air, mm; views, degrees.
PAGES = (0.96, 0.97, 0.98, 1.02, 1.04)
SHEETS = (0.984, 0.988, 1.012, 1.016, 1.0333)
#: Webcams' distortions k1 and k2, and focal lengths over the long side; aim off the badge, rad; distances, mm.
BENT = ((-0.4, 0.1, 0.62), (-0.34, 0.05, 0.7), (-0.15, 0.0, 0.66), (0.0, 0.0, 0.7), (0.1, -0.22, 0.6))
ASIDES_RAD, NEAR_MM = (0.0, 0.3), (330, 600)
AIRS_MM, VIEWS_DEG = (0.0, 0.005, 0.01, 0.02, 0.05, 0.2), ((-15, 15), (17, 39), (27, 45), (39, 52), (53, 62))
#: Of the other sheet, and what is forged from the side: under glued sheets, and through air.
OTHER_LENS, OTHER_AIRS_MM = "50lpi", (0.0, 0.02)
FORGED = ("gain_0.5", "gain_0.8", "frozen", "drift_fitted", "late_300ms")


def six(*parts: Any) -> Any:
    """A pose (6,) over time, of six figures or functions of time."""
    return lambda t: np.column_stack([part(t) if callable(part) else np.full(len(t), part) for part in parts])


def flat(distance_mm: float, rng: np.random.Generator) -> Course:
    """A badge that a hand moves sideways before a camera on a tripod, without turning it."""
    hz, wide, phase = rng.uniform(0.25, 0.45), 0.12 * min(distance_mm, 1500), rng.uniform(0, 2 * math.pi)
    tilt = np.radians(rng.uniform(-4, 4, 3))

    def sideways(t: Array) -> Array:
        return np.asarray(wide * np.sin(2 * math.pi * hz * t + phase))

    def up(t: Array) -> Array:
        return np.asarray(0.15 * wide * np.sin(2 * math.pi * 1.7 * hz * t))

    return Course("flat", six(*tilt, sideways, up, 0.0), six(0.0, 0.0, 0.0, 0.0, 0.0, -distance_mm))


def swept(distance_mm: float, views_deg: tuple[float, float], rng: np.random.Generator) -> Course:
    """A camera that sweeps to and fro between two angles of view around a badge at rest, and looks at it."""
    middle, half = np.radians(sum(views_deg) / 2), np.radians(views_deg[1] - views_deg[0]) / 2
    hz, phase = rng.uniform(0.2, 0.3), rng.uniform(0, 2 * math.pi)

    def angle(t: Array) -> Array:
        return np.asarray(middle + half * np.sin(2 * math.pi * hz * t + phase))

    camera = six(
        0.0,
        lambda t: -angle(t),
        0.0,
        lambda t: distance_mm * np.sin(angle(t)),
        lambda t: 0.02 * distance_mm * np.sin(1.3 * t),
        lambda t: -distance_mm * np.cos(angle(t)),
    )
    return Course("swept", six(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), camera)


def films(clips: int) -> dict[str, dict[str, Any]]:
    """What is filmed, by name."""
    found: dict[str, dict[str, Any]] = {}
    for number in range(clips):
        found |= {f"lens {move} {number}": {"kind": f"lens, {move}", "move": move} for move in MOVES}
    found |= {f"page {scale}": {"kind": "page", "page": scale} for scale in PAGES}
    found |= {f"sheet {scale}": {"kind": "sheet", "sheet": scale} for scale in SHEETS}
    for bent, aside, near in product(BENT, ASIDES_RAD, NEAR_MM):
        case = {"kind": f"k1 {bent[0]}", "bent": bent, "aside": aside, "near": near}
        found |= {f"k1 {bent[0]} aside {aside} {near} mm": case}
    for low, high in VIEWS_DEG:
        view, seen = f"{low} to {high} deg", {"view": (low, high)}
        found |= {f"air {air} {view}": seen | {"kind": f"air, {view}", "air": air} for air in AIRS_MM}
        other = seen | {"kind": f"air, {OTHER_LENS}", "lens": OTHER_LENS}
        found |= {f"air {air} {view} {OTHER_LENS}": other | {"air": air} for air in OTHER_AIRS_MM}
        forged = [(kind, air) for kind in FORGED for air in OTHER_AIRS_MM if low > 30]
        found |= {f"air {air} {view} {kind}": seen | {"kind": kind, "air": air, "forge": kind} for kind, air in forged}
    return found


def camera_and_course(case: dict[str, Any], width_mm: float, rng: np.random.Generator) -> tuple[Camera, Course]:
    """Who films the case, and how camera and badge move."""
    camera = drawn(rng, LAPTOP if "bent" in case else PHONE)
    if "bent" in case:
        k1, k2, share = case["bent"]
        camera = bent_webcam(replace(camera, focal_px=share * max(LAPTOP)), k1, k2)
        return camera, turned_aside(course("arc", case["near"], FRAMES / FPS, rng), case["aside"])
    if "move" in case:
        focal_px = max(PHONE) * math.exp(rng.uniform(*np.log(LENSES)))
        # A lens that is long for its sensor has less distortion, and hides less light at its edges.
        share = camera.focal_px / focal_px
        camera = replace(camera, focal_px=focal_px, k1=camera.k1 * min(1.0, share) ** 2)
    if "view" in case:
        camera = replace(camera, k1=0.0, readout_s=0.0)
    distance_mm = camera.focal_px * width_mm / WIDE_PX
    if "move" not in case:
        return camera, swept(distance_mm, case.get("view", (-15, 15)), rng)
    if case["move"] == "flat":
        return camera, flat(distance_mm, rng)
    return camera, course(case["move"], distance_mm, FRAMES / FPS, rng)


def turned_aside(motion: Course, off_rad: float) -> Course:
    """The course, with the camera turned aside, so that the badge is near the picture's border."""
    off = np.array([0.3 * off_rad, off_rad, 0, 0, 0, 0])
    return replace(motion, camera=lambda t: motion.camera(t) + off)


def misbuilt(build: Build, case: dict[str, Any]) -> Build:
    """The build with a page or a sheet of another size."""
    sheets = build.sheets.copy()
    sheets[:, 7] *= case.get("sheet", 1.0)
    across, up = build.scale
    return replace(build, scale=(across * case.get("page", 1.0), up * case.get("page", 1.0)), sheets=sheets)


def judged(job: tuple[str, dict[str, Any]], folder: Path) -> Row:
    """Film a case, and judge it."""
    name, case = job
    path = folder / f"{name.replace(' ', '_')}.mp4"
    rng = np.random.default_rng([*name.encode(), 11])
    made = prepared(folder / case["lens"], lens=case["lens"]) if "lens" in case else prepared(folder)
    page = flawed(load_page(made / "badge"), Flaws(air_mm=case.get("air", 0.0)), 1)
    camera, motion = camera_and_course(case, page.size_mm[0], rng)
    own = misbuilt(built(page, rng), case)
    if not path.exists():
        scratch = path.with_suffix(".part.mp4")
        film(page, own, camera, motion, scratch, Shoot(FRAMES, FPS, 23, 1, case.get("forge")))
        scratch.rename(path)
    badge = load_badge(made / "badge" / "badge.json")
    report = verify(path, Question(badge, badge.id))
    solved = report.to_json()["camera"] or {}
    forge = case.get("forge")
    question = "forged" if forge else ("air" if "air" in case else case["kind"].split(",")[0].split()[0])
    row = film_row(case["kind"], report, true=not forge, question=question, gain_sd=report.invariant.gain_sd)
    off = solved.get("focal_px") and solved["focal_px"] / camera.focal_px
    return row | {"focal over true": off}


def cases(asked: Asked) -> dict[str, tuple[str, dict[str, Any]]]:
    """All films, mixed by kind."""
    by_kind: dict[str, dict[str, Any]] = {}
    for name, case in films(asked.clips or 10).items():
        by_kind.setdefault(case["kind"], {})[name] = name, case
    return interleaved(*by_kind.values())


QUESTIONS = {
    "lens": "Is a true film accepted through a lens of 0.5 to 8 times the long side?",
    "k1": "Is a true film accepted through a barrel or a pincushion?",
    "air": "Is a board accepted with up to 0.2 mm of air beneath its sheet, seen from up to 62° aside? Not enrolled",
    "page": "Is a page accepted that is printed at 96 to 104 % of its size? Not enrolled",
    "sheet": "Is a board accepted whose sheet has another pitch, by -1.6 to 3.3 %? Not enrolled",
    "forged": "Is a forged film rejected from 39° to 62° aside, glued or on 20 µm of air?",
}
PART = Part(QUESTIONS, OUTSIDE, cases, judged, 2)
