"""The processor time of what people wait for, over that of bare packages on the same machine."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from moireid.errors import MoireIdError
from moireid_lab.bench.part import OWN, Asked, Part, Row

#: Each is a program of its own that does no more than the packages must, for a film named by its first argument.
PROGRAM = "from moireid.cli.main import main; main()"
CLICK = "import click"
DRAWING = "import click, cv2, msgspec, numpy, PIL.Image, reportlab.pdfgen.canvas, uharfbuzz"
DECODING = """import sys, av, click, cv2, numpy
with av.open(sys.argv[1]) as film:
    film.streams.video[0].thread_type = "AUTO"
    for picture in film.decode(video=0):
        shown = picture
"""
ENCODING = f"""{DECODING}
with av.open(sys.argv[2], "w") as made:
    stream = made.add_stream("libx264", rate=60, options={{"preset": "ultrafast"}})
    stream.width, stream.height = shown.width, shown.height
    with av.open(sys.argv[1]) as film:
        for picture in film.decode(video=0):
            picture.pict_type = 0
            made.mux(stream.encode(picture))
        made.mux(stream.encode())
"""
FPS, SECONDS = 60, 4
#: The same badge at each run.
BADGE = ["print", "Ada Lovelace", "--mount", "none", "--payload", "7097c67b0fafc59b", "--overwrite"]


def cost_rows(folder: Path, runs: int) -> Iterator[dict[str, Any]]:
    """One row for each command, as each is measured; the first make what the later ones read."""
    ada, film, registry = folder / "ada", folder / "film.mp4", f"{folder / 'registry.sqlite'}"
    printing = [*BADGE, "--out", str(ada)]
    filming = ["simulate", str(ada / "badge.json"), "--out", str(film), "--fps", str(FPS), "--seed", "1"]

    def row(work: str, s: float, limit: str, limit_s: float, asked: float) -> dict[str, Any]:
        return {"work": work, "s": s, "limit": limit, "limit_s": limit_s, "ratio": s / limit_s, "asked": asked}

    yield row("--help", _cpu_s(PROGRAM, ["--help"], runs), "import click", _cpu_s(CLICK, [], runs), 1.8)
    _cpu_s(PROGRAM, [*printing, "--registry", registry], 1)
    drawing_s = _cpu_s(DRAWING, [], runs)
    yield row("print --mount none", _cpu_s(PROGRAM, printing, runs), "imports", drawing_s, 3.2)
    filming_s = _cpu_s(PROGRAM, [*filming, "--frames", str(FPS * SECONDS), "--overwrite"], runs)
    decoding_s = _cpu_s(DECODING, [str(film)], runs)
    encoding_s = _cpu_s(ENCODING, [str(film), str(folder / "again.mp4")], runs) - 2 * decoding_s
    yield row("simulate, 4 s", filming_s, "x264 ultrafast", encoding_s, 4.5)
    verify_s = _cpu_s(PROGRAM, ["verify", str(film), "--badge", str(ada / "badge.json")], runs)
    yield row("verify, 4 s, cold", verify_s, "imports and decoding", decoding_s, 1.6)
    identify_s = _cpu_s(PROGRAM, ["identify", str(film), "--registry", registry], runs)
    yield row("identify, 4 s", identify_s, "verify", verify_s, 1.3)


def _cpu_s(program: str, words: list[str], runs: int) -> float:
    """Least processor time of a Python program and the processes that it waits for, s.

    Raises: MoireIdError where it fails.
    """
    found = []
    for _ in range(runs):
        before = os.times()
        done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True)
        after = os.times()
        if done.returncode:
            raise MoireIdError(f"moireid {' '.join(words)} ended with {done.returncode}: {done.stderr.strip()[-300:]}")
        found.append(after.children_user + after.children_system - before.children_user - before.children_system)
    return min(found)


def judged(runs: int, folder: Path) -> Row:
    """All commands, one after another."""
    rows = list(cost_rows(folder, runs))
    over = sum(row["ratio"] > row["asked"] for row in rows)
    row: Row = {"kind": "commands", "answers": {"cost": (len(rows) - over, 0, over)}}
    return row | {f"{one['work']} over {one['limit']}": one["ratio"] for one in rows}


def cases(asked: Asked) -> dict[str, int]:
    """One."""
    return {"commands": asked.clips or 3}


QUESTIONS = {"cost": "Do --help, print, simulate, verify and identify take no more over their limit than is asked?"}
PART = Part(QUESTIONS, OWN, cases, judged, sources=("moireid.cli.main",))
