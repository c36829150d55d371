"""The work of a process that makes badges and issues them.  It reads the registry, and no film."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from moireid.sandbox.child import Talk
from moireid_studio.jobs.issue_work import issue_badge, issue_event
from moireid_studio.jobs.task import Task

#: Kinds of work by name, called as those in `work.py`, with the file of an order in the place of a film.
WORK: dict[str, Callable[..., None]] = {"badge": issue_badge, "event": issue_event}


def make(talk: Talk) -> None:
    """Do a task in this process, which then ends."""
    task: Task | None = talk.next()
    if task is None:
        return

    def progress(done: int, of: int | None) -> None:
        talk.tell({"progress": [done, of]})

    os.chdir(task.folder)
    WORK[task.kind](Path(task.video), progress, talk.tell, **task.arguments)
