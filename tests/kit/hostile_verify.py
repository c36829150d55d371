"""Crafted media through plain `verify`.

Each is verified by the command, in a process of its own, with a deadline.  A right outcome is a verdict or a sentence;
wrong are an internal error, a traceback, more than `MOST_S` or `MOST_MB`, and another file that was opened: each
crafted list names a pipe, and a pipe notes its readers.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kit.crafted_films import readers_of
from kit.crafted_media import CRAFTED
from kit.places import FILMS

MOST_S, MOST_MB = 60.0, 1000.0
WRONG = ("inside moireid", "Traceback", "internal error")


#: Runs a command, and writes down its exit code and the greatest memory of its processes, KB.  A process of its own, as
#: the count of a child begins with the memory of the one that forks it.
MEASURED = """
import ctypes, os, subprocess, sys
# PR_SET_CHILD_SUBREAPER: the program that readers of films are forked from is left to this one when the command ends.
ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)
program = subprocess.Popen(sys.argv[2:], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
_, status, used = os.wait4(program.pid, 0)
peak = used.ru_maxrss
while True:
    try:
        peak = max(peak, os.wait4(-1, 0)[2].ru_maxrss)
    except ChildProcessError:
        break
open(sys.argv[1], "w").write(f"{os.waitstatus_to_exitcode(status)} {peak}")
"""


@dataclass(frozen=True)
class RunOutcome:
    """How a command ended: exit code, stderr, wall time, and memory of its largest process."""

    code: int
    words: str
    seconds: float
    peak_mb: float

    @property
    def faults(self) -> list[str]:
        """What is wrong, in words."""
        found = [word for word in WRONG if word in self.words]
        found += [f"exit code {self.code}"] if self.code not in (0, 1, 2, 3) else []
        found += [f"{self.seconds:.0f} s"] if self.seconds > MOST_S else []
        found += [f"{self.peak_mb:.0f} MB"] if self.peak_mb > MOST_MB else []
        sentence = self.words.strip().startswith("error: ") and self.words.count("\n") == 1
        return found + (["no sentence"] if self.code == 2 and not sentence else [])


def verified(path: Path) -> RunOutcome:
    """Verify a file by the command."""
    command = [str(Path(sys.executable).with_name("moireid")), "verify", str(path)]
    command += ["--badge", str(FILMS / "badge.json"), "--json"]
    begun = time.monotonic()
    with tempfile.NamedTemporaryFile("r") as figures:
        run = [sys.executable, "-c", MEASURED, figures.name, *command]
        with subprocess.Popen(run, stderr=subprocess.PIPE, start_new_session=True) as program:
            timer = threading.Timer(MOST_S + 30, lambda: os.killpg(program.pid, signal.SIGKILL))
            timer.start()
            words = program.communicate()[1].decode(errors="replace")
            timer.cancel()
        code, peak_kb = map(int, (figures.read() or "-9 0").split())
    return RunOutcome(code, words, time.monotonic() - begun, peak_kb / 1e3)


def outcomes(folder: Path) -> Iterator[tuple[str, RunOutcome, list[str]]]:
    """Name, outcome and faults of each file."""
    for name, craft in CRAFTED.items():
        own = folder / name.replace(" ", "_").replace("/", "_")
        own.mkdir()
        with readers_of(own / "other.mp4") as films, readers_of(own / "other.ts") as parts:
            path, end = craft(own)
            try:
                outcome = verified(path)
            finally:
                end()
        yield name, outcome, outcome.faults + [f"{other} was opened" for other in {*films, *parts}]
