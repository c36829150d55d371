"""The forgers suite.

Which attacks by a reader of this code are accepted; true films on their trajectories are judged
next to them.

Convention: a film is accepted, inconclusive or rejected by `verify` with the badge as claim and its identity; its
    figures as built are not known.
"""

from __future__ import annotations

from pathlib import Path

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.forgers.cases import Shoot, cases
from moireid_lab.bench.part import OWN, Asked, Part, Row, film_row, numbered, temporary_film

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES = 240
CRF = 23
CAMERA = Camera(1280, 720, 1150.0)


def badge_of(axes: str) -> Badge:
    """The badge that is filmed."""
    return design_badge(Order("Bench", lens="50lpi", axes=axes), PAYLOAD)


def judged(job: tuple[str, int], folder: Path) -> Row:
    """One film of one case, judged."""
    name, seed = job
    case = next(case for case in cases() if case.name == name)
    shoot = Shoot(badge_of(case.axes), (1000.0, 1400.0)[seed % 4 // 2], seed, FRAMES)
    filming = case.make(shoot)
    scene = Scene(shoot.badge, Build.typical(seed), CAMERA)
    how = {"frames": round(shoot.length_s * filming.fps), "fps": filming.fps, "show": filming.show}
    with temporary_film(scene, filming.motion, seed=seed, crf=CRF, edit=filming.edit, **how) as video:
        report = verify(video, Question(shoot.badge, shoot.badge.id))
    return film_row(name, report, true=case.genuine)


def named(asked: Asked) -> dict[str, tuple[str, int]]:
    """All cases; the first of a run are a true film, and one that is frozen for a while."""
    first = ["plain", "frozen for 2 s"]
    return numbered([*first, *(case.name for case in cases() if case.name not in first)], asked.clips or 1)


QUESTIONS = {
    "forged": "Is a film rejected that a reader of this code forges?",
    "genuine": "Is a true film on the same trajectories accepted?",
}
PART = Part(QUESTIONS, OWN, named, judged, 4)
