"""The threads that do jobs, and what becomes of one job (`Doer`).

1 prepare: what the registry knows of the claim     2 the film's process does its work, sealed, here or on a cluster
3 write the verdict down, once      4 settle: the job is over      5 remove the film
A studio that is killed before 4 has the job done again by the next one; the verdict then is in the record already.
"""

from __future__ import annotations

import logging
import os
import shutil
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from moireid.api.asking import with_holder
from moireid.badge import badge_from_json
from moireid.errors import MoireIdError, RegistryError
from moireid.reading.answers import (
    Count,
    MalformedAnswer,
    checked,
    checked_identification,
    checked_report,
    malformed,
)
from moireid.registry import Registry
from moireid.sandbox.seal import ProcessLimits
from moireid.verifier.report.report_page import Pictures
from moireid.verifier.session.known_figures import checked_figures
from moireid_studio.http.metrics import Metrics
from moireid_studio.jobs.child import JobFailure, run_task
from moireid_studio.jobs.cluster import JUDGED, Cluster
from moireid_studio.jobs.task import PACKAGE, SIGNALS, Task
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits
from moireid_studio.store.database import patiently
from moireid_studio.store.job import JOB_ID, Job, Lane
from moireid_studio.store.ledger import Ledger

#: Memory that libraries reserve for each processor: stacks of threads, buffers of linear algebra.
PROCESSOR_BYTES = 64 << 20
#: Greatest size of a file that a job writes.
FILE_BYTES = 256 << 20
#: Least time between two notes of a job's progress in the database, s.
PROGRESS_S = 0.5
BROKEN = ("system", "Something went wrong inside moireid; the server's log says what.")
_log = logging.getLogger(__name__)


class JobWithdrawal(Exception):
    """The job was removed."""


@dataclass
class WorkerMessages:
    """What a job's process has said so far, checked."""

    job: Job
    noted_s: float = field(default_factory=time.monotonic)

    def begin(self) -> None:
        """A process begins with the film, which another one may have had before."""
        self.job.result, self.job.kept, self.job.frames = None, {}, (0, None)


class Doer:
    """Does jobs that were taken, one at a time in each thread that calls it."""

    def __init__(
        self,
        ledger: Ledger,
        limits: Limits,
        prepare: Callable[[Job], Task],
        *,
        registry: Registry | None = None,
        metrics: Metrics | None = None,
        cluster: Cluster | None = None,
    ) -> None:
        """Hold what each job needs.

        Parameters
        ----------
        registry
            Says what else is known of a badge that was found.
        cluster
            Judges films in the place of this machine.
        """
        self.prepare = prepare
        self.ledger, self.limits, self.cluster = ledger, limits, cluster
        self._registry, self.metrics = registry, metrics or Metrics()
        memory = limits.memory_bytes + PROCESSOR_BYTES * (os.cpu_count() or 1)
        self._of_one = ProcessLimits(memory, cpu_s=int(limits.job_s * 4) + 1, file_bytes=FILE_BYTES)

    def do(self, job: Job, stopping: Callable[[], bool]) -> None:
        """Do a job; whatever goes wrong ends this job, with a sentence, and nothing else.

        stopping: whether the work is to be given back at once.
        """
        begun_s = time.monotonic()
        try:
            problem = self._work(job, stopping)
        except JobWithdrawal:
            shutil.rmtree(job.folder, ignore_errors=True)
            return
        # The boundary between a stranger's film and all others: an unexpected error must not end the
        # thread, which has the next visitor's film to judge.
        except Exception:
            logging.getLogger(__name__).exception("a job failed inside moireid")
            problem = BROKEN
        # A finished verdict counts, even if its report could not be drawn.
        if job.result is None:
            if problem is not None and problem[0] == "stopped":
                self.ledger.give_back(job)
                return
            job.problem = problem or ("crash", "The process that read this film ended without a result.")
            job.bytes = 0
        if self.ledger.settle(job) and job.result is not None:
            remove_file(job.folder / job.video)
        else:
            # A process may have put anything into its folder.
            shutil.rmtree(job.folder, ignore_errors=True)
        self.metrics.working.labels(job.kind).observe(time.monotonic() - begun_s)
        self.metrics.ended.labels(job.kind, "failed" if job.problem else "done").inc()

    def _work(self, job: Job, stopping: Callable[[], bool]) -> tuple[str, str] | None:
        """Let a job's process do its work; returns what was wrong, as code and sentence."""
        if not (job.folder / job.video).is_file():
            return "storage", "The film is here no more; send it again."
        try:
            task = patiently(lambda: self.prepare(job), stopping=stopping)
            said = WorkerMessages(job)
            said.begin()
            handle = partial(self._handle, said)
            if self.cluster is not None and job.kind in JUDGED:
                self.cluster.run(task, self._of_one, handle, said.begin, wall_s=self.limits.job_s, stopping=stopping)
            else:
                run_task(task, self._of_one, handle, wall_s=self.limits.job_s, stopping=stopping)
            job.bytes = sum((job.folder / name).lstat().st_size for name in _kept_names(job))
        except JobFailure as lost:
            return lost.code, lost.text
        except MalformedAnswer as error:
            _log.warning("a job was ended: its process was not honest (%s)", error)
            return "crash", "The process that read this film said what cannot be used; the film may be damaged."
        except Refusal as refusal:
            return refusal.code, refusal.text
        except RegistryError as error:
            _log.error("the registry could not be asked: %s", error)
            return "registry", "The registry cannot be asked just now; try again later."
        except MoireIdError as error:
            return type(error).__name__, str(error)
        except OSError as error:
            return "system", f"No process could be started ({error.strerror}); try again later."
        return None

    def _handle(self, said: WorkerMessages, message: dict[str, Any]) -> None:
        """Take a message in.  Raises: MalformedAnswer, RegistryError, JobWithdrawal."""
        job, film = said.job, said.job.video
        if "progress" in message:
            job.frames = checked(message["progress"], tuple[Count, Count | None], film)
            if time.monotonic() - said.noted_s > PROGRESS_S:
                said.noted_s = time.monotonic()
                if not self.ledger.progress(job):
                    raise JobWithdrawal
        elif "result" in message:
            if job.result is not None:
                raise malformed(film, "a second result")
            result = checked(message["result"], dict[str, Any], film)
            if job.kind in JUDGED:
                result["sealed"] = message["sealed"]
            job.result = self._own_words(job, checked_result(job, result))
        else:
            if job.kept:
                raise malformed(film, "pictures twice")
            pictures = checked(message.get("pictures"), Pictures, film)
            job.kept = keep_pictures(job, pictures)

    def _own_words(self, job: Job, result: dict[str, Any]) -> dict[str, Any]:
        """A result with the server's own word, and not that of the process that reads the film."""
        if job.standing is not None:
            result["registry"] = job.standing.to_json()
        if job.film_sha256 is not None and isinstance(result.get("input"), dict):
            result["input"]["sha256"] = job.film_sha256
        registry = self._registry
        if job.kind == "identify" and registry is not None:
            return patiently(lambda: with_holder(result, registry))
        return result


def checked_result(job: Job, result: dict[str, Any]) -> dict[str, Any]:
    """What a process found, as it must be; it can still be untrue.  Raises: MalformedAnswer."""
    if job.kind == "verify":
        checked_report(result, job.video, job.barred)
    elif job.kind == "identify":
        checked_identification(result, job.video)
    elif job.kind == "capture":
        try:
            figures = checked_figures(result, badge_from_json(job.wish["badge_json"]))
        except MoireIdError as error:
            raise malformed(job.video, "figures that are none of this badge") from error
        if figures.witnessed:
            raise malformed(job.video, "a live check")
        return {"kind": "capture", "id": figures.badge_id, "as_built": result}
    return result


def keep_pictures(job: Job, pictures: Pictures) -> dict[str, Any]:
    """Write the pictures and signals into a job's folder, to which no film's process writes; returns what they are."""
    for name, content in pictures.files.items():
        (job.folder / name).write_bytes(content)
    (job.folder / SIGNALS).write_text(pictures.signals, encoding="utf-8")
    return {"files": list(pictures.files), "frame_s": pictures.frame_s}


def _kept_names(job: Job) -> list[str]:
    """The files of a job's folder that are kept: those of which a process may say that they are there."""
    return [name for name in (*job.kept.get("files", ()), SIGNALS, PACKAGE) if (job.folder / name).is_file()]


def remove_file(path: Path) -> None:
    """Remove a film; a process may have put a folder in its place."""
    try:
        path.unlink(missing_ok=True)
    except OSError:
        shutil.rmtree(path, ignore_errors=True)


#: How often old results are looked for, s.
SWEEP_S = 10.0
#: How soon a job is found that was given back; one that is submitted is found at once, s.
POLL_S = 1.0
#: A film waits for this long at least, however soon results are removed.
WAIT_S = 3600.0


class Workers:
    """Threads that do the jobs of one ledger; `start`, `wake` as a job was submitted, `stop`."""

    def __init__(self, doer: Doer) -> None:
        self._doer, self._ledger, self._limits = doer, doer.ledger, doer.limits
        #: No more is begun; and what goes on is given back.
        self.stopping, self._hurry = threading.Event(), threading.Event()
        #: A permit for each thread to look for a job at once.
        self._news = threading.Semaphore(0)
        self.threads: list[threading.Thread] = []

    def start(self, lanes: Sequence[Sequence[Lane]]) -> None:
        """Begin to work; lanes: for each thread, of which lanes it takes jobs."""
        self.stopping.clear()
        self._hurry.clear()
        self.threads = [threading.Thread(target=self._work, args=(one,), daemon=True) for one in lanes]
        self.threads.append(threading.Thread(target=self._tidy, daemon=True))
        for thread in self.threads:
            thread.start()

    def stop(self) -> None:
        """Begin nothing more; what goes on may end within `stop_s`, and is given back then."""
        self.stopping.set()
        self.wake()
        last = time.monotonic() + self._limits.stop_s
        for thread in self.threads[:-1]:
            thread.join(max(last - time.monotonic(), 0.0))
        self._hurry.set()
        for thread in self.threads:
            thread.join()
        self.threads = []

    def wake(self) -> None:
        """A job was submitted."""
        self._news.release(max(len(self.threads), 1))

    def _work(self, lanes: Sequence[Lane]) -> None:
        while not self.stopping.is_set():
            try:
                job = self._ledger.take(lanes)
                if job is not None:
                    self._doer.do(job, self._hurry.is_set)
                    continue
            except RegistryError as error:
                _log.error("no job could be taken or ended: %s", error)
            self._news.acquire(timeout=POLL_S)

    def _tidy(self) -> None:
        while not self._hurry.wait(SWEEP_S):
            try:
                self.sweep()
            except RegistryError as error:
                _log.error("old results could not be removed: %s", error)

    def sweep(self) -> None:
        """End and remove what is too old."""
        self._ledger.end_old(max(self._limits.keep_s, WAIT_S))
        seen = Counter[str]()
        for job_id, owner, age_s in self._ledger.over():
            # Counted for each owner, so that one visitor's films never remove another's results.
            seen[owner] += 1
            if age_s > self._limits.keep_s or seen[owner] > self._limits.kept:
                self._ledger.remove(job_id)
        self.clear()

    def clear(self) -> None:
        """Remove the folders of jobs that are no more, and films of jobs that are over.

        The folders are listed first, as each job is known before it has one.
        """
        root = self._ledger.folder
        there = [entry for entry in (root.iterdir() if root.is_dir() else ()) if JOB_ID.fullmatch(entry.name)]
        known = self._ledger.old_films() if there else {}
        for folder in there:
            if folder.name not in known:
                shutil.rmtree(folder, ignore_errors=True)
            elif film := known[folder.name]:
                remove_file(folder / film)
