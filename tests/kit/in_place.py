"""The archive's engine without its processes, for tests of what it is used for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from moireid_lab.archive.engine import Task
from moireid_lab.archive.worker import Done


def in_place(work: Callable[..., Any], tasks: Sequence[Task], **_: Any) -> Iterator[tuple[int, Done]]:
    """As `run_tasks`, in this process, which has loaded everything already."""
    for place, task in enumerate(tasks):
        yield place, Done(tuple(work(job) for job in task.jobs), "here")
