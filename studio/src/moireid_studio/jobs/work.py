"""The work of a film's own process: a film in, a verdict out.  Nothing here knows of requests or pages.

Loading this module loads all packages of the work.  A process that has loaded it is forked for each job, so that the
job can begin at once (`child.py`).  `task.Task` is the piece of work that it is given.

The process may be in a stranger's hands, so it never gets the registry.  To identify a badge it may ask two questions
(`EnrolledQuestions`), which the server answers (`task.answer_to`).
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import av  # noqa: F401 - loaded ahead
import matplotlib.backends.backend_svg
import matplotlib.figure  # noqa: F401 - loaded ahead

from moireid.badge import Badge, badge_from_json
from moireid.lenticule import know_law
from moireid.provenance import ClaimedBadge
from moireid.reading.film_orders import EnrolledQuestions
from moireid.sandbox.child import Talk
from moireid.verifier.report.report_page import pictures_of, signals_csv
from moireid.verifier.session.capture import capture_as_built
from moireid.verifier.session.claim import Claim
from moireid.verifier.session.film import verify
from moireid.verifier.session.identify import identify
from moireid_studio.jobs.task import SIGNALS, Ask, Law, Progress, Send, Task


def verify_film(
    video: Path,
    progress: Progress,
    send: Send,
    *,
    found: ClaimedBadge,
    report: bool = False,
    laws: Sequence[Law] = (),
    **asked: Any,
) -> None:
    """What `moireid verify --json` prints; with `report` also the pictures and the signals of its report.

    The page itself is made by the server, as this process is not to learn whose badge it has read.

    Parameters
    ----------
    asked
        What else the claim asks for, as for `Claim`.
    """
    _know(laws)
    made = verify(video, Claim.of(found, **asked), barred=found.barred, progress=progress)
    send({"result": made.to_json()})
    if not report:
        return
    pictures = pictures_of(made)
    for name, content in pictures.files.items():
        Path(name).write_bytes(content)
    Path(SIGNALS).write_text(signals_csv(made), encoding="utf-8")
    send({"files": list(pictures.files), "plots": list(pictures.plots), "frame_s": pictures.frame_s})


def identify_film(
    video: Path,
    progress: Progress,
    send: Send,
    *,
    ask: Ask,
    layouts: Sequence[Badge],
    focal_px: float | None = None,
    laws: Sequence[Law] = (),
) -> None:
    """What `moireid identify --json` prints, but the name and the registry: those are the server's own word."""
    _know(laws)
    send({"result": identify(video, layouts, EnrolledQuestions(ask), focal_px=focal_px, progress=progress).to_json()})


def measure_capture(video: Path, progress: Progress, send: Send, *, badge_json: str) -> None:
    """The as-built figures of the badge in a film, as `moireid enroll --capture` measures them; nothing is stored.

    Raises: MediaError where the film cannot be read or does not show this badge in motion.
    """
    badge = badge_from_json(badge_json)
    found = capture_as_built([video], badge, progress=progress)
    send({"result": {"kind": "capture", "id": badge.id, "as_built": json.loads(found.to_json())}})


def _know(laws: Sequence[Law]) -> None:
    """Take laws that the server has traced already; tracing one here would take a third of a second."""
    for lens, pitch_mm, law in laws:
        know_law(lens, pitch_mm, law)


#: Kinds of work by name.  Each is called with the film, for progress and results, and with the task's arguments;
#: identify may ask as well.
WORK: dict[str, Callable[..., None]] = {
    "verify": verify_film,
    "identify": identify_film,
    "capture": measure_capture,
}


def judge(talk: Talk) -> None:
    """Do a task in this process, which then ends."""
    task: Task | None = talk.next()
    if task is None:
        return
    os.chdir(task.folder)
    may_ask = {"ask": talk.ask} if task.kind == "identify" else {}
    WORK[task.kind](Path(task.video), talk.progress, talk.send, **task.arguments, **may_ask)
