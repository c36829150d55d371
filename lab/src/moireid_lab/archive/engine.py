"""All tasks of a run: on this machine by threads, each with a process of its own, or on a Dask deployment by address.

Dask gives the task of a lost worker to another one, three times (its setting `allowed-failures`); then it is `LostJob`.
A run on a deployment stops if no worker is alive (`_next_ended`).
"""

from __future__ import annotations

import logging
import os
import pickle
import time
import uuid
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from moireid.errors import MoireIdError, SpecError
from moireid.result_cache import program_digest
from moireid.scheduler import scheduler_client
from moireid_lab.archive.isolated import Limits, LostJob
from moireid_lab.archive.worker import Done, Order, do, stop_children

#: Tasks queued at the scheduler, at least and for each thread.  So workers never wait for this program, a deployment
#: that grows with its queue sees one, and a hundred thousand films are not queued at once.
WAITING, WAITING_A_THREAD = 64, 4
LOCAL = "local"
#: A run stops if it has had no worker for this long; a deployment that starts workers on demand has this time.
NO_WORKER_S = 300.0
#: Waits: for one result, as its worker may be lost; for the workers' children to end; between two looks for ended
#: tasks; between two looks for workers.
RESULT_S, STOP_S, POLL_S, LOOK_S = 5.0, 5.0, 0.01, 1.0


@dataclass(frozen=True)
class Task:
    """Jobs that one worker does one after another: `work(job)`, or with a film `work(job, path)`.

    film: its path, which every worker must be able to read; name: a process does no tasks of another name.
    """

    jobs: tuple[Any, ...]
    film: str | None = None
    name: str = ""


def run_tasks(
    work: Callable[..., Any],
    tasks: Sequence[Task],
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    limits: Limits | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Generator[tuple[int, Done], None, None]:
    """Yield (index of the task, its results) as tasks end; a job without a result gives `LostJob`.

    Parameters: work: a function at the top of a module, since other processes import it by name, as they do the modules
        of jobs and results. scheduler: address of a Dask scheduler, such as tls://HOST:PORT; None or "local": this
        machine.  workers: number on this machine; None: one for each processor.  stop: whether no further task is
        begun; those that are running end.

        Closing the generator ends the run and its processes.
        Raises: SpecError if no scheduler answers, or a worker has another moireid; MoireIdError if the scheduler went
            away, or no worker was alive for `NO_WORKER_S`.
    """
    if scheduler not in (None, LOCAL) and workers is not None:
        raise SpecError(f"{workers} workers are asked for, but those of {scheduler} are its own; leave out --workers")
    run, program, limits = uuid.uuid4().hex, program_digest(), limits or Limits()
    payloads = [tuple(pickle.dumps((work, job)) for job in task.jobs) for task in tasks]
    orders = [
        Order(work.__module__, jobs, task.film, limits, run, program, task.name)
        for task, jobs in zip(tasks, payloads, strict=True)
    ]
    if not orders:
        return
    if scheduler in (None, LOCAL):
        yield from _on_this_machine(orders, min(workers or os.cpu_count() or 1, len(orders)), run, stop)
        return
    with _connected(str(scheduler)) as client:
        yield from _on_cluster(client, orders, run, stop)


def _on_this_machine(
    orders: Sequence[Order], count: int, run: str, stop: Callable[[], bool]
) -> Generator[tuple[int, Done], None, None]:
    """As `run_tasks`, by so many threads."""
    todo, running = deque(range(len(orders))), dict[Future[Done], int]()
    with ThreadPoolExecutor(count) as pool:
        try:
            while (todo := deque() if stop() else todo) or running:
                while todo and len(running) < count:
                    place = todo.popleft()
                    running[pool.submit(do, orders[place])] = place
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
        finally:
            # A thread that began meanwhile may have started another process.
            while wait(running, timeout=POLL_S).not_done:
                stop_children(run)
            stop_children(run)


def _on_cluster(
    client: Any, orders: Sequence[Order], run: str, stop: Callable[[], bool]
) -> Generator[tuple[int, Done], None, None]:
    """As `run_tasks`, with a client of the cluster."""
    from distributed import as_completed

    todo, ended = deque(range(len(orders))), as_completed(raise_errors=False, loop=client.loop)
    places: dict[Any, int] = {}
    try:
        while (todo := deque() if stop() else todo) or places:
            waiting = max(WAITING, WAITING_A_THREAD * _threads(client)) if todo else 0
            while todo and len(places) < waiting:
                future = client.submit(do, orders[todo[0]], key=f"moireid-{run}-{todo[0]}")
                places[future] = todo.popleft()
                ended.add(future)
            future = _next_ended(client, ended)
            place, done = places[future], None
            if future.status == "finished":
                # A worker may be lost before its result arrives; then Dask repeats the task, and others end meanwhile.
                with suppress(TimeoutError, OSError, CancelledError):
                    done = future.result(RESULT_S)
                if done is None:
                    ended.add(future)
                    continue
            del places[future]
            yield place, done or _lost(future, orders[place])
            # The results are saved by now: the scheduler forgets the task.
            future.release()
    finally:
        if client.status == "running":
            client.cancel(list(places), force=True)
            # A worker that hangs would not answer.
            with suppress(TimeoutError, OSError):
                client.sync(client.run, stop_children, run, on_error="ignore", callback_timeout=STOP_S)


def _next_ended(client: Any, ended: Any) -> Any:
    """The next task that has ended.  Raises: MoireIdError if no worker is alive for `NO_WORKER_S`."""
    alive = looked = time.monotonic()
    while not ended.has_ready():
        time.sleep(POLL_S)
        if (now := time.monotonic()) - looked >= LOOK_S:
            looked, alive = now, now if _threads(client) else alive
        if now - alive > NO_WORKER_S:
            raise MoireIdError(f"no worker has been alive for {NO_WORKER_S:g} s; {AGAIN}")
    future = next(ended)
    if future.status == "cancelled":
        raise MoireIdError(GONE)
    return future


AGAIN = "run the same command again, as finished rows are kept"
GONE = f"the scheduler went away; {AGAIN}"


def _threads(client: Any) -> int:
    """Number of threads of the live workers.  Raises: MoireIdError if the scheduler does not answer."""
    try:
        return sum(client.nthreads().values())
    except (OSError, TimeoutError) as error:
        raise MoireIdError(GONE) from error


def _lost(future: Any, order: Order) -> Done:
    """`LostJob` in place of the results of a task that has none."""
    from distributed import KilledWorker

    error = future.exception()
    if isinstance(error, MoireIdError):
        raise error
    if isinstance(error, KilledWorker):
        lost = LostJob("the worker that had it was lost, and so were those that had it next", 0.0, "worker")
    else:
        lost = LostJob(
            f"its worker could not do it ({type(error).__name__}: {' '.join(str(error).split())[:300]})", 0.0, "program"
        )
    return Done((lost,) * len(order.payloads), "")


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A client of a cluster with the same moireid as this program."""
    client = scheduler_client(address, ("", "moireid-lab"))
    # It logs tracebacks when a scheduler goes away; we give one sentence.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with client:
        own = program_digest()
        found = [client.run_on_scheduler(_digest_there), *client.run(_digest_there, on_error="return").values()]
        if any(digest != own for digest in found):
            raise SpecError(
                f"the scheduler at {address} or one of its workers has no moireid, or another one than this program; "
                "install the same on all machines"
            )
        yield client


def _digest_there() -> str:
    return program_digest()
