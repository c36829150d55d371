"""cost: the processor time of what people wait for, over that of bare packages on the same machine."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from moireid.cli.common import echo, friendly, json_option, show_json, status_line
from moireid.errors import MoireIdError
from moireid_lab.evaluation.text_table import table_lines

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
COLUMNS = {"work": "<32", "s": ">7.3f", "limit": "<26", "limit s": "limit_s >7.3f", "ratio": ">6.2f", "asked": ">6.2f"}


@click.command("cost")
@click.option("--runs", type=click.IntRange(1), default=3, show_default=True, help="Runs of each; the least counts.")
@json_option
@friendly
def cost_command(runs: int, as_json: bool) -> None:
    """Compare what commands cost with the least that they could.

    Each row is the processor time of a command with all its processes, the least of some runs, over that of its limit
    on this machine: bare packages imported, or a film decoded or encoded and nothing else. The film is simulated: 4 s
    at 1080p and 60 frames a second.
    """
    with status_line() as say, tempfile.TemporaryDirectory() as folder:
        rows = []
        for row in cost_rows(Path(folder), runs):
            say(row["work"])
            rows.append(row)
    if as_json:
        show_json({"rows": rows})
        return
    for line in table_lines(rows, COLUMNS):
        echo(line)


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
