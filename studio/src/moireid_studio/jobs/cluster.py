"""Films judged by a Dask deployment, the same that judges archives.

The database says which jobs there are, and not Dask: a scheduler is only given "do one".  A worker that has such a
task takes the next job as a studio's own thread does, and settles it in the database.  So nothing is lost with a
scheduler, a studio or a worker: a task that comes twice finds nothing to do, and a job whose worker died is taken
again.
All who reach a scheduler can run code on its workers, so it must be on a network of its own, or ask for certificates.
"""

from __future__ import annotations

import logging
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from moireid.errors import MoireIdError, RegistryError, SpecError
from moireid.extras import missing_extra
from moireid.registry import open_registry
from moireid.result_cache import program_digest
from moireid_studio.jobs.child import films
from moireid_studio.jobs.claims import prepared
from moireid_studio.jobs.workers import OVERHEAD_S, Doer
from moireid_studio.settings import Limits
from moireid_studio.store.database import database_of
from moireid_studio.store.ledger import BEAT_S, Ledger
from moireid_studio.store.storage import storage_of
from moireid_studio.store.verdict_store import Verdicts

#: Time for a scheduler to answer, between two tries to reach one, and between two looks for jobs, s.
CONNECT_S, AGAIN_S, LOOK_S = 10.0, 2.0, 0.25
#: Tasks at a scheduler for each of its threads: one at work, and one that waits.
TASKS_A_THREAD = 2
#: Greater than that of archives' films, for which no one waits.
PRIORITY = 10
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Parcel:
    """What a worker must know to do any job: where things are, and the limits; program: digest of the studio's own."""

    # Dask writes a task's arguments to its log where it fails, and these may hold passwords.
    registry_url: str = field(repr=False)
    state: str = field(repr=False)
    storage: str = field(repr=False)
    trust: str | None
    keep_verdicts_days: float
    limits: Limits
    program: str


class Dispatcher:
    """A thread that sees to it that a deployment has as many tasks as there are jobs to do."""

    def __init__(self, scheduler: str, parcel: Parcel, ledger: Ledger) -> None:
        """Raises: MissingExtraError without Dask."""
        try:
            import distributed
        except ImportError as error:
            what, package = "judging films by a scheduler", error.name or "distributed"
            raise missing_extra(what, package, "cluster", "moireid-studio") from error
        self._distributed, self._scheduler, self._parcel, self._ledger = distributed, scheduler, parcel, ledger
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        #: Whether a scheduler answers.
        self.connected = False

    def start(self) -> None:
        """Begin to hand out tasks."""
        self._thread.start()

    def stop(self) -> None:
        """Hand out no more; jobs that workers have go on."""
        self._stopping.set()
        self._thread.join(CONNECT_S)

    def _run(self) -> None:
        # They log tracebacks when a scheduler goes away, each with a level of its own; a sentence of ours is enough.
        for name in [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        while not self._stopping.is_set():
            try:
                with self._distributed.Client(self._scheduler, timeout=CONNECT_S, set_as_default=False) as client:
                    self.connected = True
                    self._serve(client)
            # Each of these means that the scheduler is away, or not there yet.
            except (OSError, TimeoutError, ValueError, RuntimeError) as error:
                _log.warning("no scheduler answers: %s", error)
            self.connected = False
            self._stopping.wait(AGAIN_S)

    def _serve(self, client: Any) -> None:
        """Hand out tasks for as long as the scheduler is there."""
        tasks: list[Any] = []
        while not self._stopping.wait(LOOK_S) and client.status == "running":
            for task in [task for task in tasks if task.done()]:
                tasks.remove(task)
                if task.status == "error" and isinstance(error := task.exception(), MoireIdError):
                    _log.error("a worker cannot judge films: %s", error)
                    self._stopping.wait(AGAIN_S)
            with suppress(RegistryError):
                threads = sum(client.nthreads().values())
                most = min(self._ledger.waiting("judge"), TASKS_A_THREAD * threads)
                for _ in range(most - len(tasks)):
                    tasks.append(client.submit(do_one, self._parcel, pure=False, priority=PRIORITY))


class Seat:
    """A worker's place: the open registry, database and storage, and a thread that reports that it is alive."""

    def __init__(self, parcel: Parcel, folder: Path) -> None:
        """Raises: SpecError where the worker has another program than the studio; RegistryError."""
        if parcel.program != program_digest():
            raise SpecError("the worker has another moireid than the studio; install the same on all machines")
        registry = open_registry(parcel.registry_url, create=False)
        database = database_of(folder, "jobs.sqlite3", parcel.state)
        verdicts = Verdicts(folder, parcel.keep_verdicts_days, parcel.state)
        self.ledger, limits = Ledger(database, folder), parcel.limits
        self.doer = Doer(
            self.ledger,
            storage_of(parcel.storage, folder),
            limits,
            # Badges are made where the keys are: by a studio, and by no worker.
            lambda job: prepared(job, registry, parcel.trust, dict),
            verdicts.note_job,
            registry=registry,
        )
        films.warm_up()
        self._most_s = limits.job_s + OVERHEAD_S
        threading.Thread(target=self._beat, daemon=True).start()

    def _beat(self) -> None:
        while True:
            time.sleep(BEAT_S)
            with suppress(RegistryError):
                self.ledger.beat(self._most_s)


_seats: dict[Parcel, Seat] = {}
_lock = threading.Lock()


def do_one(parcel: Parcel) -> bool:
    """Do the next job, on a Dask worker; False where there was none."""
    from distributed import get_worker

    with _lock:
        if parcel not in _seats:
            _seats[parcel] = Seat(parcel, Path(get_worker().local_directory) / "moireid")
        seat = _seats[parcel]
    job = seat.ledger.take(("judge",))
    if job is not None:
        seat.doer.do(job, lambda: False)
    return job is not None
