"""What a command costs in addition to its work: run `moireid lab bench commands [--clips N]`.

Each command runs in a process of its own, cold but for the disk's cache.  CPU seconds are those of all threads; of both
figures the best run is printed, as others only show what else the machine did, with the median.  The film is
the first two seconds of the outside film at 1 m.  Last come the packages whose modules take most of the time to load.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import av

from moireid_lab.bench.bench_frame import Bench, Row, Wish

FILMS = Path(__file__).parent.parent / "tests" / "data" / "films"
FILM_S = 2.0
MOST_PACKAGES = 8
SIMULATED = ("--frames", "120", "--overwrite", "--json")
#: `prctl`: processes whose parent has ended become children of this one (linux/prctl.h).
PR_SET_CHILD_SUBREAPER = 36


def beginning(source: Path, target: Path, seconds: float) -> Path:
    """The first seconds of a film, its packets copied."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        seen = given.streams.video[0]
        stream = made.add_stream_from_template(seen)
        for packet in given.demux(seen):
            if packet.pts is not None and packet.pts * packet.time_base < seconds:
                packet.stream = stream
                made.mux(packet)
    return target


def cost_s(arguments: list[str]) -> tuple[float, float]:
    """CPU and wall seconds of one run of `moireid`, and of every process that it starts."""
    # A process whose parent has ended comes to this one, which must wait for it, or its time is not counted.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(_command(arguments), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wall = time.perf_counter() - clock
    if done.returncode:
        sys.exit(done.stderr)
    with contextlib.suppress(ChildProcessError):
        while True:
            os.waitpid(-1, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def _command(arguments: list[str], *options: str) -> list[str]:
    return [sys.executable, *options, str(Path(sys.executable).parent / "moireid"), *arguments]


def load_ms(arguments: list[str]) -> Counter[str]:
    """Milliseconds that the modules of each package take to load, by Python's own count, which adds some."""
    done = subprocess.run(_command(arguments, "-X", "importtime"), capture_output=True, text=True, check=True)
    found: Counter[str] = Counter()
    for line in done.stderr.splitlines():
        own, _, module = line.removeprefix("import time:").split("|") if line.count("|") == 2 else ("", "", "")
        if own.strip().isdigit():
            found[module.strip().split(".")[0]] += int(own) / 1e3
    return found


def rows(wish: Wish) -> Iterator[Row]:
    """A row a command, then what is loaded."""
    with tempfile.TemporaryDirectory() as folder:
        film = beginning(FILMS / "genuine_1.0m.mp4", Path(folder) / "film.mp4", FILM_S)
        verify = ["verify", str(film), "--badge", str(FILMS / "badge.json"), "--json"]
        printed = ["print", "Ada Lovelace", "--out", f"{folder}/badge", "--overwrite", "--json"]
        commands = {
            "--help": ["--help"],
            f"verify of {FILM_S:g} s": verify,
            "the same, unsealed": [*verify, "--unsealed"],
            "simulate 120 frames": ["simulate", str(FILMS / "badge.json"), "--out", f"{folder}/made.mp4", *SIMULATED],
            "print without a mount": [*printed, "--mount", "none"],
            "print with a mount": printed,
        }
        for name in wish.chosen(commands):
            runs = [cost_s(commands[name]) for _ in range(wish.clips or (2 if wish.quick else 7))]
            cpu, wall = zip(*runs, strict=True)
            row = {"command": name, "CPU s": min(cpu), "median": statistics.median(cpu)}
            yield row | {"wall s": min(wall), "median wall": statistics.median(wall)}
        for package, milliseconds in load_ms(verify).most_common(MOST_PACKAGES):
            yield {"loaded by verify": package, "ms": milliseconds}


COLUMNS = {"command": "<22", "CPU s": ">7.2f", "median": ">7.2f", "wall s": ">7.2f", "median wall": ">12.2f"}
BENCH = Bench(rows, COLUMNS | {"loaded by verify": "<22", "ms": ">7.0f"})
