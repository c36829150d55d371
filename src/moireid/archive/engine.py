"""All tasks of a run, on a local cluster, on any Dask deployment by address, or in place where one worker is enough.

In place is the same code without a cluster around it: `worker.do`, called by turns.  It is there because a cluster
takes seconds to start, as a film does, and because films in memory:// lie in this process alone.

Dask gives the task of a lost worker to another one, three times (its setting `allowed-failures`); then it is `Lost`.
"""

from __future__ import annotations

import logging
import pickle
import uuid
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from moireid.archive import worker
from moireid.archive.isolated import Limits, Lost
from moireid.archive.worker import Done, Order, do, stop_children
from moireid.errors import MissingExtraError, MoireIdError, SpecError
from moireid.kept import program_digest

#: Tasks that wait at the scheduler, at least and for each thread: workers never wait for this program, a deployment
#: that grows by what waits sees it, and a hundred thousand films are not held there at once.
WAITING, WAITING_A_THREAD = 64, 4
CONNECT_S = 10.0
LOCAL = "local"


@dataclass(frozen=True)
class Task:
    """Jobs that are done one after another by one worker: `work(job)`, or with a film `work(job, path)`.

    film: its address, fetched once for all of them.
    """

    jobs: tuple[Any, ...]
    film: str | None = None


def run_tasks(
    work: Callable[..., Any], tasks: Sequence[Task], *, scheduler: str | None = None, workers: int | None = None,
    limits: Limits | None = None,
) -> Generator[tuple[int, Done], None, None]:  # fmt: skip
    """Yield (place of the task, what it gave) as tasks end; a job without a result gives `Lost`.

    Parameters: work: a function at the top of a module, which other processes import by its name, as they do the
        modules of jobs and results.  scheduler: address of a Dask scheduler, such as tcp://HOST:PORT; None or "local":
        this machine.  workers: of this machine; None: one for each processor.  One is done in place.
    A worker does the next task when the generator is asked again, so what it gave is to be kept before that.
    Closing the generator ends the run and its processes.
    Raises: SpecError where no scheduler answers, or a worker has another moireid; MoireIdError where it went away.
    """
    if scheduler not in (None, LOCAL) and workers is not None:
        raise SpecError(f"{workers} workers are asked for, but those of {scheduler} are its own; leave out --workers")
    run, program, limits = uuid.uuid4().hex, program_digest(), limits or Limits()
    orders = [
        Order(tuple(pickle.dumps((work, job)) for job in task.jobs), task.film, limits, run, program) for task in tasks
    ]
    if not orders:
        return
    count = min(workers or _processors(), len(orders))
    if scheduler in (None, LOCAL) and count == 1:
        try:
            for place, order in enumerate(orders):
                yield place, do(order)
        finally:
            stop_children(run)
        return
    with _client(scheduler, count) as client:
        yield from _on_cluster(client, orders, run)


def _on_cluster(client: Any, orders: Sequence[Order], run: str) -> Generator[tuple[int, Done], None, None]:
    """As `run_tasks`, with a client of the cluster."""
    from distributed import as_completed

    todo, ended = deque(range(len(orders))), as_completed(raise_errors=False, loop=client.loop)
    places: dict[Any, int] = {}
    try:
        while todo or places:
            waiting = max(WAITING, WAITING_A_THREAD * sum(client.nthreads().values())) if todo else 0
            while todo and len(places) < waiting:
                future = client.submit(do, orders[todo[0]], key=f"moireid-{run}-{todo[0]}")
                places[future] = todo.popleft()
                ended.add(future)
            future = next(ended)
            place = places.pop(future)
            yield place, _done(future, orders[place])
            # Now it is kept: the scheduler forgets the task, and its worker goes on.
            future.release()
    finally:
        if client.status == "running":
            client.cancel(list(places), force=True)
            client.run(stop_children, run, on_error="ignore")


def _done(future: Any, order: Order) -> Done:
    """What a task that has ended gave."""
    from distributed import KilledWorker

    if future.status == "finished":
        return future.result()
    if future.status != "error":
        raise MoireIdError("the scheduler went away; run the same command again, as finished rows are kept")
    error = future.exception()
    if isinstance(error, MoireIdError):
        raise error
    if isinstance(error, KilledWorker):
        lost = Lost("the worker that had it was lost, and so were those that had it next", 0.0, "worker")
    else:
        lost = Lost(f"its worker could not do it ({type(error).__name__}: {' '.join(str(error).split())[:300]})",
                    0.0, "program")  # fmt: skip
    return Done((lost,) * len(order.payloads), "")


@contextmanager
def _client(scheduler: str | None, workers: int) -> Iterator[Any]:
    """A client of the cluster that is asked for."""
    try:
        import distributed
    except ImportError as error:
        raise MissingExtraError("several workers need more packages; pip install 'moireid[archive]'") from error
    if scheduler not in (None, LOCAL):
        with _connected(distributed, str(scheduler)) as client:
            yield client
        return
    # A cluster does what it is told by whoever reaches it, so this one listens here alone and asks for a certificate.
    with (
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, host="127.0.0.1", security=True,
            scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
            # Films lie in the memory of the workers' children, which have a limit of their own.
            memory_limit=None, silence_logs=logging.CRITICAL, preload=[worker.__name__],
        ) as cluster,
        cluster.get_client() as client,
    ):  # fmt: skip
        yield client


@contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    """A client of somebody's cluster, which has the same moireid as this program."""
    try:
        # A client of an address that is none leaves its own thread in a state from which no other client starts.
        distributed.comm.get_address_host_port(address)
        client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError, RuntimeError, NotImplementedError) as error:
        words = " ".join(str(error).split())[:150] or type(error).__name__
        raise SpecError(
            f"no Dask scheduler answers at {address[:100]!r} ({words}); give tcp://HOST:PORT as `dask scheduler` "
            "tells it, or local"
        ) from error
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


def _processors() -> int:
    """Those that this program may use, a container's share included."""
    try:
        from dask.system import CPU_COUNT
    except ImportError as error:
        raise MissingExtraError("several workers need more packages; pip install 'moireid[archive]'") from error
    return int(CPU_COUNT)
