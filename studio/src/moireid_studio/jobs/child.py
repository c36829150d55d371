"""A process for each job.  If a film's process crashes, hangs or grows, only its own job is lost."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from moireid import errors
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ForkServer, ProcessEnd
from moireid.sandbox.seal import ProcessLimits
from moireid_studio.jobs.task import Task

#: How soon a stop is noticed.
LOOK_S = 0.25
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
    """Do a task in its own process; `handle` gets each of its messages.

    Raises: JobFailure where the film is at fault, the process crashes or takes too long, or `stopping` says so; the
        process is ended then.  OSError where no process can be started.
    """
    if task.kind in ORDERS:
        child = orders.fork(limits, task.folder)
    else:
        child = films.fork(limits, task.folder, within=reach(read=[task.folder / task.video]))
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
        # How it is sealed is what it reported before it had its film.
        message["sealed"] = list(child.sealed or ())
        handle(message)
    raise JobFailure("time", f"This film takes longer than the {wall_s:g} s that one may take here.")
