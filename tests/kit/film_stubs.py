"""What tests have done in place of scoring films: other processes import it by name."""

from __future__ import annotations

import hashlib
import os
import signal
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from moireid_lab.archive.isolated import LostJob

if TYPE_CHECKING:
    from moireid_lab.evaluation.film_rows import Job, Row


@dataclass(frozen=True)
class Stub:
    """A job: its name, seconds it takes, what goes wrong with it, and a file that it notes itself in."""

    name: str
    log: Path
    seconds: float = 0.0
    fault: str = ""


def act(stub: Stub, film: str | None = None) -> str:
    """Do a stub; the result is its name with what the film holds."""
    note(stub.log, f"begun {stub.name}")
    time.sleep(stub.seconds)
    if stub.fault == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif stub.fault == "leave":
        os._exit(7)
    elif stub.fault == "hang":
        time.sleep(600)
    elif stub.fault == "memory":
        bytearray(10**10)
    elif stub.fault == "litter":
        tempfile.mkdtemp()
        time.sleep(600)
    elif stub.fault == "trims":
        raise LookupError(os.environ.get("MALLOC_TRIM_THRESHOLD_", "not set"))
    elif stub.fault == "raise":
        raise LookupError("nothing\nthere")
    note(stub.log, f"ended {stub.name}")
    return stub.name if film is None else f"{stub.name} {Path(film).read_text()}"


def score(job: Job, film: str) -> Row:
    """A row whose score is the film's size; the film says what else happens."""
    # Loading the verifier takes a child two seconds, which the other stubs need not wait for.
    from moireid_lab.evaluation.film_rows import failed_row

    words = Path(film).read_text().split()
    note(Path(words[0]), f"begun {job.entry.name} {job.pipeline}")
    time.sleep(float(words[1]))
    if "unreadable" in words:
        return failed_row(LostJob("no film", 0.0, "film"))
    return failed_row(LostJob("", 0.1, "film")) | {
        "verdict": "accept",
        "score": float(len(words)),
        "error": None,
        "fault": None,
        "sha256": hashlib.sha256(words[-1].encode()).hexdigest(),
    }


def score_as_sealed(job: Job, film: str) -> Row:
    """As `score`, by a process that says of itself how it is sealed."""
    return score(job, film) | {"sealed": ["everything"]}


def note(log: Path, words: str) -> None:
    """Add a line with the process that works and its worker's; lines of many processes never mix.

    A process that is given a film is sealed, where the system can do that, and writes none.
    """
    try:
        handle = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    except PermissionError:
        return
    os.write(handle, f"{words} {os.getpid()} {os.getppid()}\n".encode())
    os.close(handle)


def notes(log: Path) -> list[list[str]]:
    """The lines as words."""
    return [line.split() for line in log.read_text().splitlines()] if log.exists() else []
