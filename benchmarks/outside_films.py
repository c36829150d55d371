"""Films by an outside tracer, judged: run `moireid lab bench outside [--formats a7,a6] [--clips N]`.

Badges are made by the command `print-your-badge`, in each format, landscape and portrait, plain and with all that
templates wear, with squares and with a thin frame; each is filmed twice by `outside`, which shares nothing with
`moireid.simulate`, at distances that fill the range that the badge itself states, and judged by `moireid.verifier`.
Printed is, for each format, how many films were accepted, inconclusive and rejected, how many identities of 64 bits
were read, and the gain furthest from 1; then each film that was not accepted and read, with what makes it again:
`--only ^NAME$` with the same `--clips` and `--seed`, with `--keep DIR` to look at it.  With `--forgeries`, thirteen
lies about badges of each format instead.

Every draw follows from `--seed`, the format and the film's number.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
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
from moireid.verifier import Question, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped

FORMATS = ("cr80", "a7", "4x3in", "a6", "a5", "webcam", "board")
FRAMES, FPS, PER_BADGE = 240, 30, 2
LINES = ["--line", "Reporter · Example News", "--line", "Accredited until 31 Dec 2026"]
#: What badges wear, in turns; LOGO and PORTRAIT are replaced by files.
WEAR: tuple[tuple[str, ...], ...] = (
    ("--orientation", "landscape"),
    ("--orientation", "portrait", "--template", "conference", "--logo", "LOGO", *LINES, "--colour", "#134e8c"),
    ("--orientation", "landscape", "--markers", "frame"),
    ("--orientation", "portrait"),
    ("--orientation", "landscape", "--template", "newsroom", "--logo", "LOGO", "--portrait", "PORTRAIT", *LINES[:2]),
    ("--orientation", "portrait", "--markers", "frame"),
    ("--orientation", "landscape", "--template", "court", "--logo", "LOGO", *LINES[:2]),
    ("--orientation", "portrait", "--axes", "xy"),
    ("--orientation", "landscape", "--template", "conference", "--markers", "frame", *LINES[:2]),
    ("--orientation", "landscape", "--template", "webcam", *LINES[:2]),
)
PROGRAM = Path(sys.executable).with_name("print-your-badge")


@dataclass(frozen=True)
class Task:
    """One film to make: of which format, which badge, its number, where in the range (0 to 1), and the lie, if any."""

    format: str
    number: int
    badge: int
    place: float
    base_seed: int
    clips: int
    forge: str | None = None
    keep: str | None = None

    @property
    def seed(self) -> list[int]:
        """What every draw of the film follows from."""
        kind = KINDS.index(self.forge) + 1 if self.forge else 0
        return [self.base_seed, FORMATS.index(self.format), self.number, kind]


def issued(task: Task, folder: Path) -> str:
    """Make the task's badge by the command, in `folder`; say what it wears.  A wish without room is made plain."""
    rng = np.random.default_rng([task.base_seed, FORMATS.index(task.format), 1000 + task.badge])
    wish = WEAR[task.badge % len(WEAR)]
    payload = rng.bytes(8).hex()
    words = [str(_picture(word, folder)) if word in ("LOGO", "PORTRAIT") else word for word in wish]
    for each, wear in ((words, " ".join(wish)), (words[:2], f"{wish[:2]} for want of room")):
        command = [str(PROGRAM), f"Guest {task.badge}", "--format", task.format, "--mount", "none"]
        command += ["--payload", payload]
        done = subprocess.run(
            [*command, *each, "--out", str(folder / "badge"), "--json"], capture_output=True, text=True, check=False
        )
        if done.returncode == 0:
            return wear
    raise RuntimeError(f"{task.format}: {done.stderr.strip()}")


def _picture(word: str, folder: Path) -> Path:
    """A logo of nested squares, or a portrait that is a chessboard: pictures of many edges."""
    from PIL import Image, ImageDraw

    path = folder / f"{word.lower()}.png"
    if word == "PORTRAIT":
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
    places = film(page, built(page, rng), camera, walk, folder / "film.mp4", shoot)
    tangents = -places[:, 0] / places[:, 2]
    facts = {
        "wear": wear,
        "distance_m": round(distance_m, 3),
        "motion": motion,
        "crf": crf,
        "tan_u": (float(tangents.min()), float(tangents.max())),
    }
    note.write_text(json.dumps(facts), encoding="utf-8")
    return facts


def judged(task: Task) -> Row:
    """Make one film and judge it."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(task.keep or scratch) / _name(task)
        facts = made(task, folder)
        badge = load_badge(folder / "badge" / "badge.json")
        report = verify(folder / "film.mp4", Question(badge, badge.id))
        found = report.to_json()
        if task.keep:
            (folder / "report.json").write_text(json.dumps(found, indent=1), encoding="utf-8")
    return {
        "format": task.format,
        "number": task.number,
        "forge": task.forge,
        "verdict": report.verdict,
        "read": report.identity.decoded_id == badge.id,
        "wrong": report.identity.decoded_id not in (None, badge.id),
        "gain": found["invariant"].get("gain_ratio"),
        "reasons": [_reason_text(reason) for reason in found["reasons"] if reason["level"] != "pass"],
        "tracked": found["frames"]["tracked"],
        **facts,
    }


def _name(task: Task) -> str:
    return "_".join(str(word) for word in (task.format, task.number, task.forge) if word is not None)


def _reason_text(reason: dict[str, Any]) -> str:
    """A reason as code, what was measured and the limit."""
    return f"{reason['code']}[{reason['level']}] {reason.get('measured')} / {reason.get('limit')}"


def tasks(arguments: argparse.Namespace, seed: int, clips: int, keep: Path | None) -> list[Task]:
    """All films that are asked for; a film's place in the range does not depend on which others are made."""
    found = []
    for name in arguments.formats:
        rng = np.random.default_rng([seed, FORMATS.index(name), 999])
        order = rng.permutation(clips)
        spread = (order + rng.random(clips)) / clips
        common = {"base_seed": seed, "clips": clips, "keep": str(keep) if keep else None}
        if arguments.forgeries:
            # A lie of each kind, about badges that wear different things, over the range.
            places = (np.random.default_rng([seed, 31]).permutation(len(KINDS)) + 0.5) / len(KINDS)
            found += [Task(name, k, k, float(places[k]), forge=kind, **common) for k, kind in enumerate(KINDS)]
        else:
            found += [Task(name, k, k // PER_BADGE, float(spread[k]), **common) for k in range(clips)]
    # All formats, and all kinds, go on together, so that a run that is stopped has films of each.
    steps = len(KINDS) if arguments.forgeries else clips
    turn = 2 if arguments.forgeries else 0
    return sorted(found, key=lambda task: (task.number - turn * FORMATS.index(task.format)) % steps)


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    wanted = {_name(task): task for task in tasks(wish.own, wish.seed or 1, wish.clips or 50, wish.folder)}
    return wish.each(judged, wanted)


def table(films: list[Row]) -> Iterator[Row]:
    """One row a format, and one a kind of forgery; then each film that was not judged as it ought to be."""
    kinds = grouped(films, "format") | grouped([row for row in films if row["forge"]], "forge")
    for name, own in kinds.items():
        verdicts, gains = [row["verdict"] for row in own], [row["gain"] for row in own if row["gain"] is not None]
        yield {
            "films of": name,
            "films": len(own),
            "read": sum(row["read"] for row in own),
            "wrong": sum(row["wrong"] for row in own),
            **{verdict: verdicts.count(verdict) for verdict in ("accept", "inconclusive", "reject")},
            "worst gain": max(gains, key=lambda gain: abs(gain - 1), default=None),
        }
    for row in sorted(films, key=lambda row: (row["format"], row["number"])):
        good = row["verdict"] == "reject" if row["forge"] else row["verdict"] == "accept" and row["read"]
        if not good:
            words = (row[key] for key in ("format", "number", "forge"))
            yield {"film": "_".join(str(word) for word in words if word is not None)} | row


OPTIONS: dict[str, dict[str, Any]] = {
    "--formats": {"type": lambda text: text.split(","), "default": list(FORMATS), "metavar": "F,…"},
    "--forgeries": {"action": "store_true", "help": "thirteen lies about each format instead"},
}
COLUMNS = {"films of": "<12", "films": ">5", "read": ">5", "wrong": ">5", "film": "<22", "accept": ">8"}
COLUMNS |= {"inconclusive": ">13", "reject": ">8", "worst gain": ">11.3f"}
COLUMNS |= {"m": "distance_m >6.3f", "motion": "<10", "crf": ">3", "gain": ">7.3f", "tracked": ">7", "verdict": "<12"}
COLUMNS |= {"wear": "<40", "reasons": "<1"}
BENCH = Bench(rows, COLUMNS, options=OPTIONS, table=table)
