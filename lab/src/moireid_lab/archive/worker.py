"""One task on a worker: have a child process do its jobs, return the results."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

from moireid.errors import SpecError
from moireid.result_cache import program_digest
from moireid_lab.archive.isolated import IsolatedProcess, Limits, LostJob

HERE = "here"


@dataclass(frozen=True)
class Order:
    """A task as it is sent: the pickled (work, job) of each of its jobs, and the path of their film or None.

    module: of the work; run: name of the run, which has its own children; program: digest of the requesting program;
    name: of the task.
    """

    module: str
    payloads: tuple[bytes, ...]
    film: str | None
    limits: Limits
    run: str
    program: str
    name: str


@dataclass(frozen=True)
class Done:
    """The results of a task: for each job its result or `LostJob`, and the name of the worker."""

    outcomes: tuple[Any | LostJob, ...]
    worker: str


#: Children by run and thread: a worker with several threads processes one film on each.
_children: dict[tuple[str, int], IsolatedProcess] = {}


def do(order: Order) -> Done:
    """Do a task, on a Dask worker or in this process.

    Raises: SpecError if the worker's program differs from the requesting one.
    """
    worker = _dask_worker()
    name = HERE if worker is None else str(worker.name)
    if program_digest() != order.program:
        raise SpecError(f"worker {name} has another moireid than this program; install the same on all machines")
    folder = None if worker is None else worker.local_directory
    made = IsolatedProcess(order.module, order.limits, folder)
    child = _children.setdefault((order.run, threading.get_ident()), made)
    child.rename(order.name)
    return Done(tuple(child.do(payload, order.film) for payload in order.payloads), name)


def stop_children(run: str) -> None:
    """End the processes of a run on this worker."""
    for key in [key for key in _children if key[0] == run]:
        _children.pop(key).end()


def _dask_worker() -> Any:
    """The Dask worker that runs this; None without a cluster."""
    try:
        from distributed import get_worker

        return get_worker()
    except (ImportError, ValueError):
        return None
