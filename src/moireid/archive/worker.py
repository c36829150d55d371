"""One task on a worker: its film fetched, its jobs done by a child process, the outcomes handed over.

Convention: a worker begins a task only when what it found in the one before lies with the program that asked, and that
has written it down; so a worker that is killed takes no finished row with it, and repeats at most its own film.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any

from moireid.archive.addresses import FetchError, fetched
from moireid.archive.isolated import Isolated, Limits, Lost
from moireid.errors import MoireIdError, SpecError
from moireid.kept import program_digest

#: A task waits so long at most for the one before to be taken; only a program that went away takes so long.
HANDOVER_S, POLL_S = 60.0, 0.003
HERE = "here"


@dataclass(frozen=True)
class Order:
    """A task as it travels: the pickled (work, job) of each of its jobs, and the address of their film or None.

    run: names the run, whose children are its own; program: the digest of the program that asks.
    """

    payloads: tuple[bytes, ...]
    film: str | None
    limits: Limits
    run: str
    program: str


@dataclass(frozen=True)
class Done:
    """What a task gave: for each job its result or `Lost`, and the name of the worker that did it."""

    outcomes: tuple[Any | Lost, ...]
    worker: str


#: Children by run and thread: a worker of several threads does a film on each.
_children: dict[tuple[str, int], Isolated] = {}
_former = threading.local()


def do(order: Order) -> Done:
    """Do a task, on a Dask worker or in place.

    Raises: SpecError where this is another program than the one that asks.
    """
    worker, begun = _dask_worker(), time.monotonic()
    name = HERE if worker is None else str(worker.name)
    _wait_for_handover(worker)
    if program_digest() != order.program:
        raise SpecError(f"worker {name} has another moireid than this program; install the same on all machines")
    folder = None if worker is None else worker.local_directory
    child = _children.setdefault((order.run, threading.get_ident()), Isolated(order.limits, folder))
    try:
        if order.film is None:
            return Done(tuple(child.do(payload, None) for payload in order.payloads), name)
        with fetched(order.film, most_mb=order.limits.film_mb, folder=folder) as film:
            return Done(tuple(child.do(payload, str(film)) for payload in order.payloads), name)
    except MoireIdError as error:
        lost = Lost(str(error), time.monotonic() - begun, "fetch" if isinstance(error, FetchError) else "film")
        return Done((lost,) * len(order.payloads), name)


def stop_children(run: str) -> None:
    """End the processes of a run on this worker."""
    for key in [key for key in _children if key[0] == run]:
        _children.pop(key).end()


def _wait_for_handover(worker: Any) -> None:
    """Wait until this thread's former result was taken: the program that asked forgets it then, and so the worker."""
    if worker is None:
        return
    former, _former.key = getattr(_former, "key", None), worker.get_current_task()
    last = time.monotonic() + HANDOVER_S
    while former in worker.data and time.monotonic() < last:
        time.sleep(POLL_S)


def _dask_worker() -> Any:
    """The Dask worker that runs this, None where it is called in place."""
    try:
        from distributed import get_worker

        return get_worker()
    except (ImportError, ValueError):
        return None
