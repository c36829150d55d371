"""A process for each job, and the checks of what it says.

If a film's process crashes, hangs or grows, only its own job is lost.  The process may be in a stranger's hands, so
types and ranges are checked as its messages are read, before anything in the server relies on them.  What is checked
here can still be untrue; it cannot be of another shape.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from functools import cache
from typing import Any

from moireid import errors
from moireid.badge import Badge
from moireid.errors import MoireIdError
from moireid.json_schema import schema_fault
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ForkServer, ProcessEnd
from moireid.sandbox.seal import ProcessLimits
from moireid_studio.jobs.task import Task

#: How soon a stop is noticed.
LOOK_S = 0.25
#: How long a process may take to read an answer that it has asked for, and waits for.
ANSWER_S = 10.0
#: It loads the verifier, some seconds long, for all films; a film's process is sealed.
films = ForkServer("moireid_studio.jobs.work:judge", sealed=True)
#: For badges that are made; it begins with the first of them.
orders = ForkServer("moireid_studio.jobs.issue_work:make")
#: Kinds of tasks without a stranger's film; all others are sealed.
ORDERS = frozenset({"badge", "event"})


STOPPED = ("stopped", "The studio was stopped meanwhile.")


class JobFailure(Exception):
    """A job that ended without its result: a code and a sentence."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


def run_task(
    task: Task,
    limits: ProcessLimits,
    handle: Callable[[dict[str, Any]], object],
    *,
    wall_s: float,
    stopping: Callable[[], bool],
) -> None:
    """Do a task in its own process; `handle` gets each of its messages, and what it returns, unless None, goes back.

    Raises: JobFailure where the film is at fault, the process crashes or takes too long, or `stopping` says so; the
        process is ended then.  OSError where no process can be started.
    """
    if task.kind in ORDERS:
        child = orders.fork(limits, task.folder)
    else:
        child = films.fork(limits, task.folder, within=reach(write=[task.folder]))
    try:
        child.send(task, wall_s)
        _listen(child, handle, wall_s, stopping)
    except ProcessEnd as ended:
        if ended.kind == "memory":
            raise JobFailure("memory", "This film asks for more memory than one may have here.") from ended
        if not ended.ours:
            raise JobFailure("crash", "The process that read this film ended by itself.") from ended
        if ended.kind != "done":
            # No word of the studio's own, such as "stopped", after which a job is begun again.
            raise JobFailure(ended.kind if ended.kind in errors.__all__ else "crash", ended.words) from ended
    finally:
        child.kill()


def _listen(
    child: Child, handle: Callable[[dict[str, Any]], object], wall_s: float, stopping: Callable[[], bool]
) -> None:
    """Pass messages on until the process says that it has ended.  Raises: ProcessEnd, JobFailure."""
    deadline = time.monotonic() + wall_s
    while (rest := deadline - time.monotonic()) > 0:
        if stopping():
            raise JobFailure(*STOPPED)
        if (message := child.hear(min(rest, LOOK_S))) is None:
            continue
        if isinstance(message.get("result"), dict):
            # How it is sealed is what it reported before it had its film.
            message["result"]["sealed"] = list(child.sealed or ())
        if (back := handle(message)) is not None:
            child.send(back, min(rest, ANSWER_S))
    raise JobFailure("time", f"This film takes longer than the {wall_s:g} s that one may take here.")


#: Frames that a film can have: at 60 frames a second, half a year.
MOST_FRAMES = 1_000_000_000
#: What identification can find.
FINDINGS = ("found", "nobody", "inconclusive")


class Unusable(Exception):
    """A process said what no honest one says."""


def frames_of(said: object) -> tuple[int, int | None]:
    """Frames read, and as many as the film says that it has.  Raises: Unusable."""
    if not isinstance(said, list) or len(said) != 2:
        raise Unusable("progress is no pair")
    done, of = said
    if not _count(done) or (of is not None and not _count(of)):
        raise Unusable("progress is of no frames")
    return done, of


def result_of(kind: str, said: object) -> dict[str, Any]:
    """The result of a kind of work: a report for films by the report's own schema.  Raises: Unusable."""
    if not isinstance(said, dict):
        raise Unusable("a result is no object")
    try:
        # Figures that are not finite have no place in an answer.
        json.dumps(said, allow_nan=False)
    except (ValueError, RecursionError) as error:
        raise Unusable("a result cannot be passed on") from error
    if kind == "identify":
        _check_finding(said)
    if kind == "verify" or (kind == "identify" and "verdict" in said):
        if (fault := schema_fault(said, _schema(kind))) is not None:
            raise Unusable(f"a report has a fault: {fault}")
        if said.get("level") == "live":
            raise Unusable("a film is called a live check")
    return said


def check_capture(said: dict[str, Any], badge: Badge) -> None:
    """Raise Unusable unless a result is of figures of this badge, as this version measures them from films."""
    from moireid.verifier.session.known_figures import checked_figures

    try:
        found = checked_figures(said.get("as_built"), badge)
    except MoireIdError as error:
        raise Unusable("figures that are none of this badge") from error
    if said.get("id") != badge.id or found.witnessed:
        raise Unusable("a capture of another kind")


def kept_of(said: dict[str, Any]) -> dict[str, Any]:
    """What a process says of the pictures in its folder: names, titles, and the time of one.  Raises: Unusable."""
    files, plots, frame_s = said.get("files"), said.get("plots"), said.get("frame_s")
    if not (_texts(files) and _texts(plots) and (frame_s is None or _number(frame_s))):
        raise Unusable("pictures without names")
    return {"files": files, "plots": plots, "frame_s": frame_s}


def _check_finding(said: dict[str, Any]) -> None:
    found, reasons = said.get("found_id"), said.get("reasons")
    right = said.get("finding") in FINDINGS and (found is None or isinstance(found, str))
    if not right or not isinstance(reasons, list) or not all(isinstance(reason, dict) for reason in reasons):
        raise Unusable("an identification without a finding")


@cache
def _schema(kind: str) -> str:
    from moireid.verifier.session.result import report_schema

    schema = json.loads(report_schema())
    if kind == "identify":
        # Its reasons are of the finding, and not of the report's verdict.
        del schema["if"], schema["then"]
    return json.dumps(schema)


def _count(value: object) -> bool:
    return type(value) is int and 0 <= value <= MOST_FRAMES


def _number(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]


def _texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(one, str) for one in value)
