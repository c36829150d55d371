"""The threads of one process that do jobs, report that it is alive, and tidy up after processes that were lost.

One job, from the moment that it was taken to its end, on any machine (`Doer`):

1 prepare: what the registry knows of the claim     2 the film's process does its work, sealed
3 keep its pictures      4 settle: the result counts, if the job is still this worker's
5 write the verdict down, once      6 remove the film, and close
If a worker dies after 4, the process that finds the job does 5 and 6 (`finish`); before it, the job is done again.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from moireid.badge import badge_from_json
from moireid.errors import MoireIdError, RegistryError
from moireid.registry import Registry
from moireid.sandbox.seal import ProcessLimits
from moireid.verifier.report.report_page import NAME
from moireid.verifier.session.claim import with_badge_notes
from moireid_studio.http.metrics import Metrics
from moireid_studio.jobs.child import JobFailure, Unusable, check_capture, frames_of, kept_of, result_of, run_task
from moireid_studio.jobs.claims import PreparedJob
from moireid_studio.jobs.task import PACKAGE, SIGNALS, Task, answer_to, with_name
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits
from moireid_studio.store.database import patiently
from moireid_studio.store.job import Job, Lane
from moireid_studio.store.ledger import BEAT_S, Ledger
from moireid_studio.store.storage import Storage, StorageError

#: Memory that libraries reserve for each processor: stacks of threads, buffers of linear algebra.
PROCESSOR_BYTES = 64 << 20
#: Greatest size of a file that a job writes.
FILE_BYTES = 256 << 20
#: Least time between two notes of a job's progress in the database, s.
PROGRESS_S = 0.5
STOPPED = ("stopped", "The studio was stopped meanwhile.")
BROKEN = ("system", "Something went wrong inside moireid; the server's log says what.")
_log = logging.getLogger(__name__)


class JobWithdrawal(Exception):
    """The job was removed, or another worker has it."""


@dataclass
class WorkerMessages:
    """What a job's process has said so far, checked."""

    job: Job
    ready: PreparedJob
    questions: int = 0
    noted_s: float = field(default_factory=time.monotonic)


class Doer:
    """Does jobs that were taken, one at a time in each thread that calls it."""

    def __init__(
        self,
        ledger: Ledger,
        storage: Storage,
        limits: Limits,
        prepare: Callable[[Job], PreparedJob],
        note: Callable[[Job], None],
        *,
        registry: Registry | None = None,
        metrics: Metrics | None = None,
    ) -> None:
        """Hold what each job needs.

        Parameters
        ----------
        note
            Writes the verdict of a job down, and nothing where it did so before.
        registry
            Says what else is known of a badge that was found.
        """
        self.prepare, self._note = prepare, note
        self.ledger, self.storage, self.limits = ledger, storage, limits
        self._registry, self.metrics = registry, metrics or Metrics()
        memory = limits.memory_bytes + PROCESSOR_BYTES * (os.cpu_count() or 1)
        self._of_one = ProcessLimits(memory, cpu_s=int(limits.job_s * 4) + 1, file_bytes=FILE_BYTES)

    def do(self, job: Job, stopping: Callable[[], bool]) -> None:
        """Do a job; whatever goes wrong ends this job, with a sentence, and nothing else.

        stopping: whether the work is to be given back at once.
        Raises: RegistryError where the database stays away; then others do the job again.
        """
        begun_s = time.monotonic()
        try:
            problem = self._work(job, stopping)
        except JobWithdrawal:
            self._clear(job)
            return
        # The boundary between a stranger's film and all others: an unexpected error must not end the
        # thread, which has the next visitor's film to judge.
        except Exception:
            logging.getLogger(__name__).exception("a job failed inside moireid")
            problem = BROKEN
        again = problem is not None and problem[0] in ("stopped", "storage", "registry")
        if problem is not None and again and self._given_back(job, problem[0]):
            return
        # A finished verdict counts, even if its report could not be drawn.
        if job.result is None:
            job.problem = problem or ("crash", "The process that read this film ended without a result.")
        if not patiently(lambda: self.ledger.settle(job)):
            _log.warning("a job's result came too late: another worker has the job, or it was removed")
            self._clear(job)
            return
        self.finish(job)
        self.metrics.working.labels(job.kind).observe(time.monotonic() - begun_s)
        self.metrics.ended.labels(job.kind, "failed" if job.problem else "done").inc()

    def finish(self, job: Job) -> None:
        """What remains once a job is settled; doing it again changes nothing."""
        if job.result is not None:
            patiently(lambda: self._note(job))
        try:
            if job.result is None:
                job.bytes = 0
                # A process may have put anything into its folder.
                self.storage.remove(job.id)
            else:
                self.storage.drop(job.id, job.video)
        except StorageError as error:
            # The sweep finds it, and tries again.
            _log.error("a film that was judged could not be removed: %s", error)
            return
        patiently(lambda: self.ledger.drop_film(job))
        patiently(lambda: self.ledger.close(job))

    def _clear(self, job: Job) -> None:
        """Remove the files of a job that was removed; not of one that another worker has."""
        if patiently(lambda: self.ledger.find(job.id)) is None:
            with suppress(StorageError):
                self.storage.remove(job.id)

    def _given_back(self, job: Job, why: str) -> bool:
        """Whether others do the job: after a stop always, after a fault of ours if it may be begun once more."""
        counts = why != "stopped"
        if job.tries == 1 or (counts and job.taken - job.kills >= job.tries):
            return False
        return patiently(lambda: self.ledger.give_back(job, counts=counts)) or True

    def _work(self, job: Job, stopping: Callable[[], bool]) -> tuple[str, str] | None:
        """Let a job's process do its work; returns what was wrong, as code and sentence."""
        try:
            ready = patiently(lambda: self.prepare(job), stopping=stopping)
            _know(job, ready)
            with self.storage.at_work(job.id, job.video) as folder:
                said = WorkerMessages(job, ready, ready.questions)
                self._run(said, folder, stopping)
                names = _kept_names(job, folder)
                self.storage.keep(job.id, folder, names)
                job.bytes = sum((folder / name).lstat().st_size for name in names)
        except JobFailure as lost:
            return lost.code, lost.text
        except Unusable as error:
            _log.warning("a job was ended: its process was not honest (%s)", error)
            return "crash", "The process that read this film said what cannot be used; the film may be damaged."
        except Refusal as refusal:
            return refusal.code, refusal.text
        except (StorageError, FileNotFoundError):
            return "storage", "The film could not be fetched; send it again."
        except RegistryError as error:
            _log.error("the registry could not be asked: %s", error)
            return "registry", "The registry cannot be asked just now; try again later."
        except MoireIdError as error:
            return type(error).__name__, str(error)
        except OSError as error:
            return "system", f"No process could be started ({error.strerror}); try again later."
        return None

    def _run(self, said: WorkerMessages, folder: Path, stopping: Callable[[], bool]) -> None:
        job = said.job
        task = Task(job.kind, folder, job.video, said.ready.arguments, said.ready.write)
        run_task(task, self._of_one, partial(self._handle, said), wall_s=self.limits.job_s, stopping=stopping)

    def _handle(self, said: WorkerMessages, message: dict[str, Any]) -> object:
        """Take a message in; returns the answer to a question.  Raises: Unusable, RegistryError, JobWithdrawal."""
        job, people = said.job, said.ready.people
        if "ask" in message:
            said.questions -= 1
            if said.questions < 0:
                raise Unusable("it asked the registry more than a film needs")
            return patiently(lambda: answer_to(message["ask"], people))
        if "progress" in message:
            job.frames = frames_of(message["progress"])
            if time.monotonic() - said.noted_s > PROGRESS_S:
                said.noted_s = time.monotonic()
                self._note_progress(job)
        elif "result" in message:
            result = result_of(job.kind, message["result"])
            if job.kind == "capture":
                check_capture(result, badge_from_json(job.wish["badge_json"]))
            job.result = self._own_words(said, result)
        else:
            job.kept = kept_of(message)
        return None

    def _own_words(self, said: WorkerMessages, result: dict[str, Any]) -> dict[str, Any]:
        """A result with the server's own word, and not that of the process that reads the film."""
        job, people = said.job, said.ready.people
        if job.standing is not None:
            result["registry"] = job.standing.to_json()
        if job.film_sha256 is not None and isinstance(result.get("input"), dict):
            result["input"]["sha256"] = job.film_sha256
        if people is not None:
            result = patiently(lambda: with_name(result, people))
        if job.kind == "identify" and self._registry is not None:
            result = with_notes(self._registry, result)
        return result

    def _note_progress(self, job: Job) -> None:
        """Note how far a job has come.  Raises: JobWithdrawal where it is no longer this worker's."""
        try:
            if not self.ledger.progress(job):
                raise JobWithdrawal
        except RegistryError:
            # Progress can wait; the result cannot.
            return


def with_notes(registry: Registry, result: dict[str, Any]) -> dict[str, Any]:
    """An identification with what is to be said of the badge that was found, of which the decoder knows nothing."""
    found = result.get("found_id")
    if not isinstance(found, str) or not isinstance(result.get("reasons"), list):
        return result
    try:
        record = registry.by_id(found)
    except RegistryError as error:
        _log.error("%s", error)
        return result
    if record is None:
        return result
    return with_badge_notes(result, measured=record.as_built is not None)


def _know(job: Job, ready: PreparedJob) -> None:
    """Note in a job what was found to be claimed."""
    job.standing = ready.standing
    if ready.found is not None:
        job.claimed_id, job.claim_source = ready.found.badge.id, ready.found.provenance.source
        job.barred = ready.found.barred


def _kept_names(job: Job, folder: Path) -> list[str]:
    """The files of a job's folder that are kept: those of which a process may say that they are there."""
    named = [name for name in job.kept.get("files", []) if NAME.fullmatch(name)]
    there = [name for name in (*named, SIGNALS, PACKAGE) if (folder / name).is_file()]
    return there if job.result is not None else []


#: How often old results, and jobs of lost processes, are looked for.
SWEEP_S = 10.0
#: How often the storage is listed, s.
CLEAR_S = 600.0
#: How soon a job is found that another process has submitted; one of this process is found at once.
POLL_S = 1.0
#: A film waits for this long at least, however soon results are removed.
WAIT_S = 3600.0
#: What a job may take in addition to its process's time, for storage and databases that are slow, s.
OVERHEAD_S = 900.0


class Workers:
    """Threads that do the jobs of one ledger; `start`, `wake` as a job was submitted, `stop`."""

    def __init__(self, doer: Doer) -> None:
        self._doer, self._ledger, self._storage, self._limits = doer, doer.ledger, doer.storage, doer.limits
        #: No more is begun; and what goes on is given back.
        self.stopping, self._hurry = threading.Event(), threading.Event()
        #: A permit for each thread to look for a job at once.
        self._news = threading.Semaphore(0)
        self._working: list[threading.Thread] = []
        self._caring: list[threading.Thread] = []

    @property
    def threads(self) -> list[threading.Thread]:
        """Those that work, and those that look after the jobs; none before the start and after the end."""
        return self._working + self._caring

    def start(self, lanes: Sequence[Sequence[Lane]], *, tidy: bool = True) -> None:
        """Begin to work.

        Parameters
        ----------
        lanes
            For each thread, of which lanes it takes jobs.
        tidy
            Whether to remove old results too, after as long as this process's limits say; studios alone do.
        """
        self.stopping.clear()
        self._hurry.clear()
        steps = [(BEAT_S, self._beat)] + ([(SWEEP_S, self.sweep), (CLEAR_S, self.clear)] if tidy else [])
        self._working = [threading.Thread(target=self._work, args=(one,), daemon=True) for one in lanes]
        self._caring = [threading.Thread(target=self._every, args=step, daemon=True) for step in steps]
        for thread in self.threads:
            thread.start()

    def stop(self) -> None:
        """Begin nothing more; what goes on may end within `stop_s`, and is given back then."""
        self.stopping.set()
        self.wake()
        last = time.monotonic() + self._limits.stop_s
        for thread in self._working:
            thread.join(max(last - time.monotonic(), 0.0))
        self._hurry.set()
        for thread in self.threads:
            thread.join()
        self._working, self._caring = [], []

    def wake(self) -> None:
        """A job was submitted."""
        self._news.release(max(len(self._working), 1))

    def _work(self, lanes: Sequence[Lane]) -> None:
        while not self.stopping.is_set():
            try:
                job = self._ledger.take(lanes)
                if job is not None:
                    self._doer.do(job, self._hurry.is_set)
                    continue
            except RegistryError as error:
                # The job of this thread, if it has one, is done again by the process that finds it.
                _log.error("no job could be taken or ended: %s", error)
            self._news.acquire(timeout=POLL_S)

    def _every(self, seconds: float, step: Callable[[], None]) -> None:
        """Do a step again and again, as long as jobs may go on."""
        while not self._hurry.wait(seconds):
            try:
                step()
            except RegistryError as error:
                _log.error("jobs could not be looked after: %s", error)

    def _beat(self) -> None:
        self._ledger.beat(self._limits.job_s + OVERHEAD_S)

    def sweep(self) -> None:
        """End what was lost, and remove what is too old; several processes may do so side by side."""
        for job in self._ledger.lost(max(self._limits.keep_s, WAIT_S)):
            self._doer.finish(job)
        for job in self._ledger.abandoned():
            self.remove(job.id)
        seen = Counter[str]()
        for job_id, owner, age_s in self._ledger.over():
            # Counted for each owner, so that one visitor's films never remove another's results.
            seen[owner] += 1
            if age_s > self._limits.keep_s or seen[owner] > self._limits.kept:
                self.remove(job_id)

    def remove(self, job_id: str) -> None:
        """Forget a job, and remove all its files."""
        self._ledger.remove(job_id)
        # What is left is found by a later sweep, as no job knows of it.
        with suppress(StorageError):
            self._storage.remove(job_id)

    def clear(self) -> None:
        """Remove files that belong to no job; they are listed first, as each job is known before it has files."""
        try:
            there = self._storage.ids()
            known = self._ledger.states(there) if there else {}
            for job_id in there:
                if job_id not in known:
                    self._storage.remove(job_id)
        except StorageError as error:
            _log.error("the storage could not be tidied up: %s", error)
