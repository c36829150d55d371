"""The processor time of what people wait for, over that of bare packages on the same machine, and its memory."""

from __future__ import annotations

import os
import re
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

import av
import numpy as np
import psutil

from moireid.badge import load_badge
from moireid.errors import MoireIdError
from moireid.registry import open_registry
from moireid.sandbox.process import ONE_THREAD
from moireid_lab.bench.many_people import People
from moireid_lab.bench.part import OWN, RIGHT, WRONG, Asked, Part, Row

#: Each is a program of its own that does no more than the packages must, for a film named by its first argument.
COMMAND = "from moireid.cli.main import main; main()"
CLICK = "import click"
CAD = "import build123d"
DRAWING = "import click, cv2, msgspec, numpy, PIL.Image, reportlab.pdfgen.canvas, uharfbuzz"
DECODING = """import sys, av, click, cv2, numpy
with av.open(sys.argv[1]) as film:
    film.streams.video[0].thread_type = "AUTO"
    for picture in film.decode(video=0):
        shown = picture
"""
ENCODING = f"""{DECODING}
with av.open(sys.argv[1] + ".again.mp4", "w") as made:
    stream = made.add_stream("libx264", rate=60, options={{"preset": "ultrafast"}})
    stream.width, stream.height = shown.width, shown.height
    with av.open(sys.argv[1]) as film:
        for picture in film.decode(video=0):
            picture.pict_type = 0
            made.mux(stream.encode(picture))
        made.mux(stream.encode())
"""
FPS, SECONDS, MOST_MB, FEW, MANY = 60, 4, 250, 10, 100_000
#: A user's programs use as many threads as they like, and Python keeps what it compiled.
NOT_A_USER_S = {*ONE_THREAD, "PYTHONDONTWRITEBYTECODE"}
#: Exit codes of a command that did its work: of a film it may have accepted, rejected or neither.
ENDS = (0, 1, 3)
#: The same badge, and the same films, at each run.
PRINT = "print Ada.Lovelace --payload 7097c67b0fafc59b --overwrite --out"
FILM = f"simulate ada/badge.json --overwrite --fps {FPS} --frames {FPS * SECONDS} --seed"


class Case(NamedTuple):
    """A command and the program that is its limit, with the names of their files; how many times that is to be taken,
    and which ratio was asked for.

    taken_off: a program whose time is not of the limit's.
    """

    command: str
    limit: str
    program: str
    argument: str
    asked: float
    times: float = 1.0
    taken_off: str = ""


VERIFY = "verify {} --badge ada/badge.json"
CASES = {
    "--help": Case("--help", "import click", CLICK, "", 1.8),
    "print --mount none": Case(f"{PRINT} made --mount none", "imports", DRAWING, "", 3.2),
    "print": Case(f"{PRINT} mounted", "import build123d", CAD, "", 1.3),
    "print --people, 10": Case(
        "print --people people.csv --format a6 --overwrite --out list", "imports, for each", DRAWING, "", 2.0, 10
    ),
    "simulate, 4 s": Case(f"{FILM} 1 --out made.mp4", "x264 ultrafast", ENCODING, "film.mp4", 4.5, 1, DECODING),
    "simulate handheld": Case(
        f"{FILM} 1 --motion handheld --out made.mp4", "x264 ultrafast", ENCODING, "film.mp4", 4.5, 1, DECODING
    ),
    "simulate --camera dim": Case(
        f"{FILM} 1 --camera dim --out made.mp4", "x264 ultrafast", ENCODING, "film.mp4", 6.5, 1, DECODING
    ),
    "verify, 4 s, cold": Case(VERIFY.format("film.mp4"), "imports and decoding", DECODING, "film.mp4", 1.6),
    "verify, badge lost": Case(VERIFY.format("lost.mp4"), "imports and decoding", DECODING, "lost.mp4", 1.8),
    "verify, 1 minute": Case(VERIFY.format("minute.mp4"), "imports and decoding", DECODING, "minute.mp4", 1.3),
    "verify, 10 minutes": Case(VERIFY.format("minutes.mp4"), "imports and decoding", DECODING, "minutes.mp4", 1.3),
    "identify, 10 people": Case(
        "identify film.mp4 --registry few.sqlite", "verify", COMMAND, VERIFY.format("film.mp4"), 1.3
    ),
    "identify, 100,000 people": Case(
        "identify film.mp4 --registry many.sqlite", "10 people", COMMAND, "identify film.mp4 --registry few.sqlite", 1.1
    ),
}


def cost_row(work: str, folder: Path, runs: int) -> Row:
    """A command next to its limit, run in turn so that what else the machine does slows both."""
    case, spent = CASES[work], []
    for _ in range(runs):
        limit_s, _ = _run(folder, case.program, case.argument)
        less_s = _run(folder, case.taken_off, case.argument)[0] if case.taken_off else 0.0
        spent.append((*_run(folder, COMMAND, case.command), limit_s, less_s))
    s, mb, limit_s, less_s = map(min, zip(*spent, strict=True))
    # A picture is decoded twice where it is encoded.
    limit_s = case.times * (limit_s - 2 * less_s)
    row = {"work": work, "s": s, "limit": case.limit, "limit_s": limit_s, "ratio": s / limit_s, "asked": case.asked}
    return row | {"MB": mb, "of_most": mb / MOST_MB}


def _run(folder: Path, program: str, words: str) -> tuple[float, float]:
    """Processor time of a Python program and the processes that it waits for, s; and the most memory of them all, MB.

    Parameters: words: its arguments; files of `FILES` are made before.
    Raises: MoireIdError where it fails.
    """
    for name, make in FILES.items():
        needed = re.search(rf"\b{re.escape(name)}\b", words) and f"--out {name}" not in words
        if needed and not (folder / name).exists():
            make(folder, folder / name)
    arguments = [word.replace("Ada.", "Ada ") for word in words.split()]
    with tempfile.TemporaryFile() as said:
        before, peak = resource.getrusage(resource.RUSAGE_CHILDREN), 0
        kept = {name: value for name, value in os.environ.items() if name not in NOT_A_USER_S}
        child = psutil.Popen(
            [sys.executable, "-c", program, *arguments], cwd=folder, env=kept, stdout=said, stderr=said
        )
        while child.poll() is None:
            # A process of it may end at any moment.
            with suppress(psutil.NoSuchProcess):
                tree = [one.memory_full_info() for one in (child, *child.children(recursive=True))]
                # What several share counts once, where the system knows.
                peak = max(peak, sum(getattr(one, "pss", one.rss) for one in tree))
            time.sleep(0.05)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if child.returncode not in ENDS:
            said.seek(0)
            text = said.read().decode(errors="replace").strip()[-300:]
            raise MoireIdError(f"moireid {words} ended with {child.returncode}: {text}")
    used_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used_s, peak / 1e6


def _made(folder: Path, path: Path, command: str) -> None:
    _run(folder, COMMAND, f"{command} --out {path.name}")


def looped(film: Path, out: Path, times: int) -> Path:
    """The film over and over, its packets copied; where it begins again the badge jumps."""
    with av.open(str(out), "w") as made:
        stream, later = None, 0
        for _ in range(times):
            last = 0
            with av.open(str(film)) as source:
                shown = source.streams.video[0]
                stream = stream or made.add_stream_from_template(shown)
                for packet in source.demux(shown):
                    if packet.dts is None or packet.pts is None:
                        continue
                    last = max(last, packet.pts + (packet.duration or 0))
                    packet.pts, packet.dts, packet.stream = packet.pts + later, packet.dts + later, stream
                    made.mux(packet)
            later += last
    return out


def _looped(folder: Path, path: Path, times: int) -> None:
    looped(folder / "film.mp4", path, times)


def _lost(folder: Path, path: Path) -> None:
    """The film, whose camera turns from the badge to a wall full of boxes, and back, every two seconds."""
    wall = np.kron(np.random.default_rng(1).integers(20, 235, (27, 48)), np.ones((40, 40))).astype(np.uint8)
    with av.open(str(folder / "film.mp4")) as source, av.open(str(path), "w") as made:
        stream = made.add_stream("libx264", rate=FPS)
        for number, picture in enumerate(source.decode(video=0)):
            seen = picture.to_ndarray(format="gray")
            if not number:
                stream.height, stream.width = seen.shape
            turned = np.clip(4 * abs(number / FPS % 2 - 1) - 1.5, 0, 1) * seen.shape[1]
            view = np.roll(np.hstack([wall, seen]), -int(turned), axis=1)[:, -seen.shape[1] :]
            grey = av.VideoFrame.from_ndarray(np.ascontiguousarray(view), format="gray")
            made.mux(stream.encode(grey.reformat(format="yuv420p")))
        made.mux(stream.encode())


def _enrolled(folder: Path, path: Path, people: int) -> None:
    """A registry of so many people."""
    badge = load_badge(folder / "ada" / "badge.json")
    with open_registry(str(path), create=True) as registry:
        registry.enroll_many(People(badge, people - 1))
        registry.enroll(badge)


def _listed(folder: Path, path: Path) -> None:
    path.write_text("name\n" + "".join(f"Person {number}\n" for number in range(10)), encoding="utf-8")


#: The files that commands read, in the order in which they need each other.
FILES: dict[str, Callable[[Path, Path], None]] = {
    "ada": partial(_made, command="print Ada.Lovelace --payload 7097c67b0fafc59b --mount none"),
    "film.mp4": partial(_made, command=f"{FILM} 1"),
    "lost.mp4": _lost,
    "minute.mp4": partial(_looped, times=15),
    "minutes.mp4": partial(_looped, times=150),
    "people.csv": _listed,
    "few.sqlite": partial(_enrolled, people=FEW),
    "many.sqlite": partial(_enrolled, people=MANY),
}


def judged(work: str, folder: Path) -> Row:
    """A command's row: is it within what was asked, and within the memory?"""
    row = cost_row(work, folder, RUNS)
    within = {"cost": row["ratio"] <= row["asked"], "memory": row["of_most"] <= 1}
    answers = {question: RIGHT if kept else WRONG for question, kept in within.items()}
    return {"kind": work, "answers": answers, "command s": row["s"]} | {
        one: row[one] for one in ("ratio", "asked", "MB")
    }


def cases(asked: Asked) -> dict[str, str]:
    """All commands."""
    return {work: work for work in CASES}


RUNS = 3
QUESTIONS = {
    "cost": "Does a command take no more processor time over its limit than is asked?",
    "memory": f"Does a command take at most {MOST_MB} MB, with all its processes?",
}
PART = Part(QUESTIONS, OWN, cases, judged, sources=("moireid.cli.main",))
