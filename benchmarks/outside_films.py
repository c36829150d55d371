"""Films by an outside tracer, judged: run `moireid lab bench outside [--only REGEX] [--clips N]`.

Badges are made as `print-your-badge` makes them, in each format, landscape and portrait, plain and with all that
templates wear, with squares and with a thin frame; each is filmed twice by `outside`, which shares nothing with
`moireid.simulate`, at distances that fill the range that the badge itself states, and judged by `moireid.verifier`.
Of each format there are as many films of true badges as are asked for, and thirteen of lies about them.  `--keep DIR`
keeps films and reports.

Every draw follows from the format and the film's number.
"""

from __future__ import annotations

import json
import math
import shutil
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from outside.build import built
from outside.camera import LAPTOP, PHONE, drawn
from outside.film import Shoot, film
from outside.forge import KINDS
from outside.motion import KINDS as MOTIONS
from outside.motion import course
from outside.page import load_page

from moireid.badge import load_badge
from moireid.designer import Order
from moireid.errors import MoireIdError
from moireid.verifier import Question, verify
from moireid_lab.bench.part import OUTSIDE, Asked, Part, Row, film_row, identity_answer, interleaved, printed

FORMATS = ("cr80", "a7", "4x3in", "a6", "a5", "webcam", "board")
SEED, FRAMES, FPS, PER_BADGE = 1, 240, 30, 2
LINES = ["Reporter · Example News", "Accredited until 31 Dec 2026"]
WIDE, TALL = {"orientation": "landscape"}, {"orientation": "portrait"}
#: What badges wear, in turns: fields of an order; pictures are drawn.
WEAR: tuple[dict[str, Any], ...] = (
    WIDE,
    TALL | {"template": "conference", "logo": "drawn", "lines": LINES, "colour": "#134e8c"},
    WIDE | {"markers": "frame"},
    TALL,
    WIDE | {"template": "newsroom", "logo": "drawn", "portrait": "drawn", "lines": LINES[:1]},
    TALL | {"markers": "frame"},
    WIDE | {"template": "court", "logo": "drawn", "lines": LINES[:1]},
    TALL | {"axes": "xy"},
    WIDE | {"template": "conference", "markers": "frame", "lines": LINES[:1]},
    WIDE | {"template": "webcam", "lines": LINES[:1]},
)


@dataclass(frozen=True)
class Task:
    """One film to make: of which format, which badge, its number, where in the range (0 to 1), and the lie, if any."""

    format: str
    number: int
    badge: int
    place: float
    forge: str | None = None

    @property
    def seed(self) -> list[int]:
        """What every draw of the film follows from."""
        kind = KINDS.index(self.forge) + 1 if self.forge else 0
        return [SEED, FORMATS.index(self.format), self.number, kind]

    @property
    def name(self) -> str:
        """Of the film."""
        return "_".join(str(word) for word in (self.format, self.number, self.forge) if word is not None)


def issued(task: Task, folder: Path) -> str:
    """Print the task's badge into `folder`; say what it wears.  A wish without room is made plain."""
    rng = np.random.default_rng([SEED, FORMATS.index(task.format), 1000 + task.badge])
    wish, payload = WEAR[task.badge % len(WEAR)], rng.bytes(8).hex()
    drawn_by = {name: _picture(name, folder) for name in ("logo", "portrait") if name in wish}
    plain = {"orientation": wish["orientation"]}
    for each, wear in ((wish | drawn_by, wish), (plain, plain | {"for want of room": True})):
        with suppress(MoireIdError):
            printed(Order(f"Guest {task.badge}", format=task.format, payload=payload, **each), folder / "badge")
            return ", ".join(f"{name} {value}" for name, value in wear.items())
    raise RuntimeError(f"{task.name}: no room for a plain badge")


def _picture(word: str, folder: Path) -> Path:
    """A logo of nested squares, or a portrait that is a chessboard: pictures of many edges."""
    from PIL import Image, ImageDraw

    path = folder / f"{word}.png"
    if word == "portrait":
        Image.fromarray((255 * np.kron(np.indices((10, 8)).sum(axis=0) % 2, np.ones((40, 40)))).astype(np.uint8)).save(
            path
        )
        return path
    picture = Image.new("RGB", (600, 200), "white")
    draw = ImageDraw.Draw(picture)
    for k, colour in enumerate(("black", "#134e8c", "white", "black", "#134e8c")):
        draw.rectangle((20 + 18 * k, 20 + 18 * k, 180 - 18 * k, 180 - 18 * k), fill=colour)
    draw.rectangle((220, 60, 580, 140), outline="black", width=12)
    picture.save(path)
    return path


def made(task: Task, folder: Path) -> dict[str, Any]:
    """Make one film in `folder`, and say what is in it; a film that an earlier run kept there is not made again."""
    note = folder / "film.json"
    if note.is_file():
        return json.loads(note.read_text(encoding="utf-8"))  # type: ignore[no-any-return]
    rng = np.random.default_rng(task.seed)
    folder.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(folder / "badge", ignore_errors=True)
    wear = issued(task, folder)
    near, far = load_badge(folder / "badge" / "badge.json").range_m or (math.nan, math.nan)
    distance_m = near + task.place * (far - near)
    camera = drawn(rng, LAPTOP if task.format == "webcam" else PHONE)
    motion, crf = MOTIONS[task.number % len(MOTIONS)], (23, 28)[task.number % 2]
    walk = course(motion, 1000 * distance_m, FRAMES / FPS, rng)
    page = load_page(folder / "badge")
    shoot = Shoot(FRAMES, FPS, crf, int(rng.integers(1 << 30)), task.forge)
    film(page, built(page, rng), camera, walk, folder / "film.mp4", shoot)
    facts = {
        "wear": wear,
        "distance_m": round(distance_m, 3),
        "motion": motion,
        "crf": crf,
    }
    note.write_text(json.dumps(facts), encoding="utf-8")
    return facts


def judged(task: Task, folder: Path) -> Row:
    """Make one film and judge it."""
    home = folder / task.name
    facts = made(task, home)
    badge = load_badge(home / "badge" / "badge.json")
    report = verify(home / "film.mp4", Question(badge, badge.id))
    (home / "report.json").write_text(json.dumps(report.to_json(), indent=1), encoding="utf-8")
    row = film_row(task.forge or task.format, report, true=task.forge is None, **facts)
    if task.forge is None:
        row["answers"]["identity"] = identity_answer(report, badge)
    return row


def cases(asked: Asked) -> dict[str, Task]:
    """All films; the place of a film in its badge's range does not depend on which others are made."""
    true, forged = dict[str, Task](), dict[str, Task]()
    clips = asked.clips or 20
    # A lie of each kind, about badges that wear different things, over the range.
    places = (np.random.default_rng([SEED, 31]).permutation(len(KINDS)) + 0.5) / len(KINDS)
    for name in FORMATS:
        rng = np.random.default_rng([SEED, FORMATS.index(name), 999])
        order = rng.permutation(clips)
        spread = (order + rng.random(clips)) / clips
        films = [Task(name, k, k // PER_BADGE, float(spread[k])) for k in range(clips)]
        lies = [Task(name, k, k, float(places[k]), forge=kind) for k, kind in enumerate(KINDS)]
        true |= {task.name: task for task in films}
        # Formats begin with different kinds, so that a run that is stopped has films of each.
        turn = 2 * FORMATS.index(name)
        forged |= {task.name: task for task in lies[turn:] + lies[:turn]}
    by_number = sorted(true, key=lambda name: true[name].number)
    turns = [list(forged)[k :: len(KINDS)] for k in range(len(KINDS))]
    return interleaved({name: true[name] for name in by_number}, {name: forged[name] for one in turns for name in one})


QUESTIONS = {
    "genuine": "Is a true film accepted? Seven formats over their ranges",
    "identity": "Is the identity of 64 bits read whole?",
    "forged": "Is a forged film rejected? 13 kinds about seven formats",
}
PART = Part(QUESTIONS, OUTSIDE, cases, judged, 6)
