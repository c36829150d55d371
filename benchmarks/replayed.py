"""Forgeries made from true films, on one axis and two: run `moireid lab bench replayed`.

clip: a public film of the badge, 1 to 8 s of a hand's measured motion, is put over another trajectory, which stays
    within the parallaxes that the clip shows: the badge whole by the nearest view, or field by field, each field by its
    own parallax.  Level: at one distance; deep: 8 % nearer and farther; own way: the clip's own, forth and back.
    Stretched: rows by the distance, one number a frame.  Faded: two frames of the clip, cross-faded.
slid: one photograph, of which each row is
    slid by the law.
re-badged: the true film of another person's badge of the same layout; its middle row is copied into every cell.  With
    figures: corrected so that the figures are those of the victim's enrolment (two true films).
true: films of the badge itself on the same trajectories, and on measured motion (natural) in four formats.

`--keep DIR` keeps the clips.
"""

from __future__ import annotations

import contextlib
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from true_films.clip import Clip, filmed_clip
from true_films.paths import DEPTH, lively, natural, swaying, to_and_fro
from true_films.rebadge import Correction, Rebadging
from true_films.replay import Replay

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import MediaError
from moireid.files import whole_file, write_text
from moireid.simulate.filming import Show, film
from moireid.simulate.forgeries.rear_layer import ShownViews
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid.verifier.session.capture import capture_as_built
from moireid_lab.bench.part import INCONCLUSIVE, OWN, RIGHT, WRONG, Asked, Part, Row, film_row, interleaved

Kind = Literal["clip", "slid", "re-badged", "true"]
Way = Literal["level", "deep", "own way", "natural"]
FRAMES, FPS, CRF = 180, 30, 23
#: Of this many badges there is a long public clip, of the others a short one, s.
LONG, LONG_S, SHORT_S = 4, 8, 2
PHONE, SMALL = Camera(), Camera(1280, 720, 1150.0)
#: Of the donor of a re-badged film: another person's badge, and another build.
DONOR = 500


@dataclass(frozen=True)
class Case:
    """One kind of film; films: how many by default; seconds: of the clip; way: trajectory."""

    kind: Kind
    axes: str
    films: int
    format: str = "board"
    metres: float = 1.0
    way: Way = "level"
    seconds: int = 0
    by_field: bool = False
    faded: bool = False
    stretched: bool = False
    figures: bool = False

    @property
    def name(self) -> str:
        """In a few words."""
        what = f"clip of {self.seconds} s" if self.kind == "clip" else self.kind
        taken = ("field by field" if self.by_field else "whole") if self.axes == "xy" and self.kind == "clip" else ""
        way = "" if self.kind in ("slid", "re-badged") else self.way
        words = [what, way, taken, "faded" if self.faded else "", "stretched" if self.stretched else ""]
        words.append("with figures" if self.figures else "")
        return f"{self.axes}, {self.format} {self.metres:g} m: " + ", ".join(word for word in words if word)

    @property
    def camera(self) -> Camera:
        """Boards fill a picture of 720p; smaller formats and greater distances have 1080p."""
        return SMALL if self.format == "board" and self.metres <= 1 else PHONE


def all_cases() -> list[Case]:
    """Every case."""
    found: list[Case] = []
    for axes, by_field in (("xy", False), ("xy", True), ("x", False)):
        found += clip_cases(axes, by_field)
    for axes in ("x", "xy"):
        found += [Case("clip", axes, 2, way="own way", seconds=8), Case("slid", axes, 2)]
        found += [
            Case("re-badged", axes, 3),
            Case("re-badged", axes, 1, "a6"),
            Case("re-badged", axes, 3, figures=True),
        ]
        found += [Case("true", axes, films, way=way) for way, films in (("level", 2), ("deep", 2), ("own way", 2))]
        found += [Case("true", axes, films, *at, way="natural") for *at, films in TRUE]
    return found


def clip_cases(axes: str, by_field: bool) -> list[Case]:
    """Clips, of badges that are taken whole or field by field."""
    usual = {"axes": axes, "by_field": by_field, "seconds": 2, "stretched": True}
    found = [Case("clip", films=2, **usual)]
    found += [Case("clip", films=2, **usual | {"seconds": seconds}) for seconds in (1, 4, 8)]
    found += [Case("clip", films=2, way="deep", **usual | {"stretched": stretched}) for stretched in (False, True)]
    found += [Case("clip", films=1, format="a6", **usual)]
    if by_field or axes == "x":
        found += [Case("clip", films=2, faded=True, **usual), Case("clip", films=2, figures=True, **usual)]
    return found


#: Format, distance in m and number of true films: at 1 m and 2 m, or at the middle and the far end of a smaller range.
TRUE = (("board", 1.0, 4), ("board", 2.0, 4), ("a6", 0.7, 2), ("a5", 1.0, 2), ("4x3in", 0.5, 2))


def badge_of(case: Case, number: int) -> Badge:
    """A badge of its own for each number, of hard cells."""
    payload = np.random.default_rng([number, 7]).bytes(8)
    return design_badge(Order("Bench", axes=case.axes, format=case.format), payload)


def scene_of(case: Case, number: int) -> Scene:
    """The badge, as it was built."""
    return Scene(badge_of(case, number), Build.typical(number), case.camera)


def public_clip(case: Case, number: int, folder: Path) -> Clip:
    """The public clip of that badge, of all its seconds; kept in the folder."""
    path = folder / f"clip_{case.axes}_{case.format}_{case.metres:g}_{number}.npz"
    if not path.exists():
        seconds = FRAMES // FPS if number > DONOR else LONG_S if number <= LONG else SHORT_S
        made = filmed_clip(scene_of(case, number), hand(case, number), seconds * FPS, number)
        with whole_file(path) as temporary, temporary.open("wb") as stream:
            np.savez(stream, pictures=made.pictures, views=made.views)
    with np.load(path) as kept:
        return Clip(kept["pictures"], kept["views"])


def hand(case: Case, number: int) -> Motion:
    """The measured motion of the public clip."""
    return lively(1000 * case.metres, number)


def enrolled(case: Case, number: int, folder: Path) -> AsBuilt:
    """The figures of the victim's enrolment, by two true films; kept in the folder."""
    path = folder / f"figures_{case.axes}_{case.format}_{case.metres:g}_{number}.json"
    if not path.exists():
        with tempfile.TemporaryDirectory() as own:
            films = [Path(own) / f"{k}.mp4" for k in (1, 2)]
            for k, video in enumerate(films):
                motion = lively(1000 * case.metres, number + 1000 * (k + 1))
                shot(scene_of(case, number), motion, video, number + k, frames=240)
            write_text(path, capture_as_built(films, badge_of(case, number)).to_json())
    return as_built_from_json(path.read_text(encoding="utf-8"))


def shot(scene: Scene, motion: Motion, video: Path, seed: int, show: Show | None = None, frames: int = FRAMES) -> None:
    """One film."""
    film(scene, motion, video, frames=frames, fps=FPS, show=show, seed=seed, crf=CRF, overwrite=True)


def trajectory(case: Case, number: int, views: np.ndarray) -> Motion:
    """That of the film: within what a clip shows, or measured."""
    if case.way == "natural":
        return natural(("handheld", "walk")[number % 2], 1000 * case.metres, number + 50)
    if case.way == "own way":
        return to_and_fro(hand(case, number), case.seconds or LONG_S)
    return swaying(views, 1000 * case.metres, number, depth=DEPTH if case.way == "deep" else 0.0)


def replayed(case: Case, number: int, clip: Clip) -> Show:
    """A clip."""
    return Replay(clip, case.by_field, case.faded, case.stretched).shown


def slid(scene: Scene, motion: Motion, camera_mm: np.ndarray, fps: float) -> ShownViews:
    """One photograph, its rows slid by the law; as `moireid_lab.bench.forgers.cases.slid`."""
    away = np.abs(camera_mm[:, 2:])
    return ShownViews(camera_mm / away * away.mean(), camera_mm)


def made_of_donor(case: Case, number: int, folder: Path) -> tuple[Motion, Show]:
    """Trajectory and show of another person's film, re-badged; corrected if figures are to agree."""
    scene, donor = scene_of(case, number), number + DONOR
    found = Rebadging(badge_of(case, donor), public_clip(case, donor, folder))
    motion = hand(case, donor)
    if case.figures:
        # The forger measures his first try by our own program, and corrects what is off.
        video, wanted = folder / f"try_{case.axes}_{number}.mp4", enrolled(case, number, folder)
        shot(scene, motion, video, number, found.shown)
        # A first try that is no usable capture leaves him nothing to correct by.
        with contextlib.suppress(MediaError):
            found = replace(found, correction=Correction.between(wanted, capture_as_built([video], scene.badge)))
        video.unlink()
    return motion, found.shown


def made(case: Case, number: int, folder: Path) -> tuple[Motion, Show | None]:
    """Trajectory and show of one film."""
    if case.kind == "re-badged":
        return made_of_donor(case, number, folder)
    if case.way == "natural":
        return trajectory(case, number, np.zeros((0, 3))), None
    whole, frames = public_clip(case, number, folder), (case.seconds or LONG_S) * FPS
    clip = Clip(whole.pictures[:frames], whole.views[:frames])
    motion = trajectory(case, number, clip.views)
    if case.kind == "clip":
        return motion, replayed(case, number, clip)
    return motion, slid if case.kind == "slid" else None


def judged(job: tuple[Case, int], folder: Path) -> Row:
    """One film, made and judged."""
    case, number = job
    scene = scene_of(case, number)
    claim = Question(scene.badge, scene.badge.id)
    motion, show = made(case, number, folder)
    with tempfile.TemporaryDirectory() as own:
        video = Path(own) / "film.mp4"
        shot(scene, motion, video, number, show)
        if case.figures:
            claim = replace(claim, as_built=enrolled(case, number, folder))
        report = verify(video, claim)
    row = film_row(case.name, report, true=case.kind == "true")
    if case.figures:
        row["answers"]["figures"] = {"agrees": WRONG, "differs": RIGHT}.get(report.identity.built, INCONCLUSIVE)
    return row


def cases(asked: Asked) -> dict[str, tuple[Case, int]]:
    """All films, mixed by kind."""
    every = {case.name: range(1, 1 + (asked.clips or case.films)) for case in all_cases()}
    by_name = {case.name: case for case in all_cases()}
    return interleaved(*({f"{name}|{k}": (by_name[name], k) for k in numbers} for name, numbers in every.items()))


QUESTIONS = {
    "forged": "Is a film rejected that is made from true films of the badge, or of another?",
    "figures": "Do the figures of enrolment differ from those of such a film?",
    "genuine": "Is a true film on the same trajectories, or on measured motion, accepted?",
}
PART = Part(QUESTIONS, OWN, cases, judged, 2)
