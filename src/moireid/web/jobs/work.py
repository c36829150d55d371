"""What is done in a process of its own: a film in, a verdict out.  Nothing here knows of requests or pages.

The process has a film, a folder and a pipe.  It may take no more memory and time than it is given, and tells what it
finds as JSON: what it sends is not unpickled, as it has read what a stranger made.

Loading this module loads all that the work needs, so that a process which is forked from one that has loaded it can
begin at once (`child.py`).
"""

from __future__ import annotations

import json
import os
import resource
import signal
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import av  # noqa: F401 - loaded ahead
import jinja2  # noqa: F401 - loaded ahead
import jsonschema  # noqa: F401 - loaded ahead
import matplotlib.backends.backend_svg
import matplotlib.figure  # noqa: F401 - loaded ahead

from moireid.errors import MoireIdError
from moireid.lenticule import know_law
from moireid.registry import Claimed, People
from moireid.verifier.report.page import pictures_of, write_report
from moireid.verifier.session.claim import Claim
from moireid.verifier.session.film import verify
from moireid.verifier.session.identify import identify
from moireid.web.jobs.enroll_work import measure_capture
from moireid.web.jobs.issue_work import issue_badge, issue_event, server_registry
from moireid.web.jobs.task import Law, Task

#: Progress is told at most so often.
TELL_S = 0.1
#: Libraries set this aside for each processor: stacks of threads, buffers of linear algebra.
PROCESSOR_BYTES = 64 << 20
#: No file that is written here is larger.
FILE_BYTES = 256 << 20


Tell = Callable[[dict[str, Any]], None]
Progress = Callable[[int, int | None], None]


def verify_film(
    video: Path,
    progress: Progress,
    tell: Tell,
    *,
    found: Claimed,
    focal_px: float | None = None,
    require_original: bool = False,
    report: bool = False,
    laws: Sequence[Law] = (),
) -> None:
    """What `moireid verify --json` prints; with `report` also the files of `moireid verify --report`, and the plots."""
    _know(laws)
    claim = Claim(found.badge, found.badge.id, focal_px, found.as_built, require_original)
    made = verify(video, claim, revoked=found.revoked, progress=progress)
    tell({"result": made.to_json()})
    if not report:
        return
    pictures = pictures_of(made)
    drawn = [*pictures.plots, *([("The law by time", pictures.timeline)] if pictures.timeline else [])]
    for number, (_, svg) in enumerate(drawn):
        Path(f"plot{number}.svg").write_text(svg, encoding="utf-8")
    if pictures.badge_png:
        Path("badge.png").write_bytes(pictures.badge_png)
    write_report(made, Path("."), pictures=pictures)
    tell({"plots": [title for title, _ in drawn], "badge": pictures.badge_png is not None})


def identify_film(
    video: Path,
    progress: Progress,
    tell: Tell,
    *,
    registry_url: str,
    keys: str,
    focal_px: float | None = None,
    laws: Sequence[Law] = (),
) -> None:
    """What `moireid identify --json` prints."""
    _know(laws)
    with server_registry(registry_url, keys) as registry:
        people = People(registry)
        outcome = identify(video, registry.layouts(), people, focal_px=focal_px, progress=progress)
        tell({"result": outcome.to_json() | {"found_name": people.name(outcome.found_id)}})


def _know(laws: Sequence[Law]) -> None:
    """Take laws that the server has traced already; each would be a third of a second here."""
    for lens, pitch_mm, law in laws:
        know_law(lens, pitch_mm, law)


#: Kinds of work by name.  Each is called with the film, for progress and results, and with the task's arguments.
WORK: dict[str, Callable[..., None]] = {
    "verify": verify_film,
    "identify": identify_film,
    "badge": issue_badge,
    "event": issue_event,
    "capture": measure_capture,
}


def run(pipe: Connection, task: Task) -> None:
    """Do a task in this process, which then ends; what is wrong with the film is told, all else lets it crash."""
    _confine(task)

    def tell(message: dict[str, Any]) -> None:
        pipe.send_bytes(json.dumps(message, allow_nan=False).encode())

    told_s = 0.0

    def progress(done: int, of: int | None) -> None:
        nonlocal told_s
        if time.monotonic() - told_s >= TELL_S:
            told_s = time.monotonic()
            tell({"progress": [done, of]})

    try:
        WORK[task.kind](Path(task.video), progress, tell, **task.arguments)
        tell({"ended": True})
    except MoireIdError as error:
        tell({"failed": [type(error).__name__, " ".join(str(error).split())]})
    except MemoryError:
        tell({"failed": ["memory", "This film asks for more memory than one may have here."]})


def _confine(task: Task) -> None:
    """Limits of the system on this process.

    Private memory is what counts (Linux; RLIMIT_DATA): address space is also reserved by libraries and never used.
    Beside what a film may have there is room for what the process has already, and what is set aside for threads.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Decoders talk; what a stranger's film makes them say is not for the server's own stderr.
    quiet = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(quiet, stream)
    os.chdir(task.folder)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (task.cpu_s, task.cpu_s + 5))
    memory = task.memory_bytes + _held_bytes() + PROCESSOR_BYTES * (os.cpu_count() or 1)
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))


def _held_bytes() -> int:
    """Private memory that this process has, where the system tells."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[5])
    except (OSError, ValueError, IndexError):
        return 0
    return pages * resource.getpagesize()
