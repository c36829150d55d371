"""Keeps the scheduling class of this program's threads while a library starts that would raise it.

Run by the superuser, SVT-AV1 turns its own threads and the calling thread into real-time threads (first in, first out,
priority 99), and does not turn the caller back.  Processes started later inherit that.  Then threads that wait by
spinning, such as those of BLAS, keep all processors from the threads that they wait for, and programs hang for ever.

Source: sched(7).
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

TASKS = "/proc/self/task"


@contextlib.contextmanager
def scheduling_kept() -> Iterator[None]:
    """Let the body call a library; afterwards threads that it raised or started are as the caller was before.

    Convention: where the system has no such classes, or names no threads (anything but Linux), nothing is done.
    """
    if not hasattr(os, "sched_getscheduler") or not os.path.isdir(TASKS):
        yield
        return
    before = {thread: _class_of(thread) for thread in _threads()}
    own = (os.sched_getscheduler(0), os.sched_getparam(0))
    try:
        yield
    finally:
        for thread in _threads():
            policy, parameters = before.get(thread) or own
            if _class_of(thread) not in (None, (policy, parameters)):
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.sched_setscheduler(thread, policy, parameters)


def _threads() -> list[int]:
    return [int(name) for name in os.listdir(TASKS)]


def _class_of(thread: int) -> tuple[int, os.sched_param] | None:
    """Policy and parameters; None of a thread that has ended."""
    try:
        return os.sched_getscheduler(thread), os.sched_getparam(thread)
    except ProcessLookupError:
        return None
