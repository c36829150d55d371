"""A process for each film, which may crash, hang or grow without harm to anything but its own job.

Each is forked from one process that has loaded all that the work needs, and nothing else (Python's forkserver): so it
begins within some milliseconds, and bears neither threads, connections nor another film's leavings.
"""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from moireid.web.jobs.task import Task, begin

#: A message larger than this is no result.
MOST_BYTES = 32 << 20
#: How soon a stop is noticed.
LOOK_S = 0.25


class Lost(Exception):
    """A job that ended without its result: a code and a sentence."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


def _context() -> Any:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["__main__", "moireid.web.jobs.work"])
    return context


def warm_up() -> None:
    """Let the process that others are forked from load what it needs; some seconds."""
    process = _context().Process(target=int, daemon=True)
    # A studio that is stopped in these seconds takes that process with it; else the first film starts it again.
    with suppress(EOFError, OSError):
        process.start()
        process.join()


def run_task(
    task: Task, heard: Callable[[dict[str, Any]], None], *, wall_s: float, stopping: Callable[[], bool]
) -> None:
    """Do a task in a process of its own; each of its messages goes to `heard`.

    Raises: Lost where the film is at fault, the process crashes, takes too long, or `stopping` says so; it is ended
        then, whatever it does.
    """
    context = _context()
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=begin, args=(theirs, task), daemon=True)
    try:
        process.start()
        theirs.close()
        _listen(ours, heard, time.monotonic() + wall_s, wall_s, stopping)
    except EOFError as error:
        process.join(5)
        raise Lost("crash", f"The process that read this film ended by itself ({process.exitcode}).") from error
    finally:
        theirs.close()
        ours.close()
        if process.pid is not None:
            # Nobody waits until the system has taken its memory back: the process that forked it sees to that.
            process.kill()


def _listen(
    pipe: Connection,
    heard: Callable[[dict[str, Any]], None],
    deadline: float,
    wall_s: float,
    stopping: Callable[[], bool],
) -> None:
    """Hand messages on until the last one."""
    while True:
        rest = deadline - time.monotonic()
        if rest <= 0:
            raise Lost("time", f"This film takes longer than the {wall_s:g} s that one may take here.")
        if stopping():
            raise Lost("stopped", "The studio was stopped meanwhile.")
        if not pipe.poll(min(rest, LOOK_S)):
            continue
        try:
            message = json.loads(pipe.recv_bytes(MOST_BYTES))
        except (OSError, ValueError) as error:
            raise Lost("crash", "The process that read this film said what cannot be read.") from error
        if "failed" in message:
            raise Lost(*message["failed"])
        if "ended" in message:
            return
        heard(message)
