"""The threads of one process that do jobs, say that it lives, and tidy up after processes that were lost."""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from moireid.errors import RegistryError
from moireid_studio.jobs.job_runner import Doer
from moireid_studio.settings import Limits
from moireid_studio.store.job import Job, Lane
from moireid_studio.store.ledger import BEAT_S, Ledger
from moireid_studio.store.storage import Storage, StorageError

#: How often old results, and jobs of lost processes, are looked for.
SWEEP_S = 10.0
#: How often the storage is listed, s.
CLEAR_S = 600.0
#: How soon a job is found that another process has submitted; one of this process is found at once.
POLL_S = 1.0
#: A film waits for this long at least, however soon results are removed.
WAIT_S = 3600.0
#: What a job may take beside its process's time, for storage and databases that are slow, s.
BESIDE_S = 900.0
_log = logging.getLogger(__name__)


class Workers:
    """Threads over one ledger; `start`, `wake` as a job was submitted, `stop`."""

    def __init__(
        self, ledger: Ledger, storage: Storage, doer: Doer, limits: Limits, ended: Callable[[str], None]
    ) -> None:
        """Parameters: ended: told the id of each job that was ended here."""
        self._ledger, self._storage, self._doer, self._limits = ledger, storage, doer, limits
        self._ended = ended
        #: No more is begun; and what goes on is given back.
        self.stopping, self._hurry = threading.Event(), threading.Event()
        self._news, self._number = threading.Condition(), 0
        self.threads: list[threading.Thread] = []
        self._working = 0

    def start(self, lanes: Sequence[Sequence[Lane]]) -> None:
        """Begin to work: a thread for each of these, which takes jobs of these lanes; and those that look after all."""
        self.stopping.clear()
        self._hurry.clear()
        works = [threading.Thread(target=self._work, args=(one,), daemon=True) for one in lanes]
        steps = ((BEAT_S, self._beat), (SWEEP_S, self.sweep), (CLEAR_S, self.clear))
        self.threads = works + [threading.Thread(target=self._every, args=step, daemon=True) for step in steps]
        for thread in self.threads:
            thread.start()

    def stop(self) -> None:
        """Begin nothing more; what goes on may end within `stop_s`, and is given back then."""
        self.stopping.set()
        self.wake()
        last = time.monotonic() + self._limits.stop_s
        while self._working and time.monotonic() < last:
            time.sleep(0.02)
        self._hurry.set()
        for thread in self.threads:
            thread.join()
        self.threads = []

    def wake(self) -> None:
        """A job was submitted."""
        with self._news:
            self._number += 1
            self._news.notify_all()

    def _work(self, lanes: Sequence[Lane]) -> None:
        while not self.stopping.is_set():
            number = self._number
            try:
                job = self._ledger.take(lanes)
                if job is not None:
                    self._do(job)
                    continue
            except RegistryError as error:
                # The job of this thread, if it has one, is done again by whoever finds it.
                _log.error("no job could be taken or ended: %s", error)
            with self._news:
                self._news.wait_for(partial(self._is_new, number), POLL_S)

    def _is_new(self, seen: int) -> bool:
        """Whether a job was submitted since, or the end was announced."""
        return self._number != seen

    def _do(self, job: Job) -> None:
        with self._news:
            self._working += 1
        try:
            self._doer.do(job, self._hurry.is_set)
        finally:
            with self._news:
                self._working -= 1
        self._ended(job.id)

    def _every(self, seconds: float, step: Callable[[], None]) -> None:
        """Do a step again and again, as long as jobs may go on."""
        while not self._hurry.wait(seconds):
            try:
                step()
            except RegistryError as error:
                _log.error("jobs could not be looked after: %s", error)

    def _beat(self) -> None:
        self._ledger.beat(self._limits.job_s + BESIDE_S)

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
        """Forget a job, with all that lies there of it."""
        self._ledger.remove(job_id)
        # What is left is found by a later sweep, as no job knows of it.
        with suppress(StorageError):
            self._storage.remove(job_id)

    def clear(self) -> None:
        """Remove what lies there of no job: listed first, as each job is known before anything lies there of it."""
        try:
            there = self._storage.ids()
            known = self._ledger.states(there) if there else {}
            for job_id in there:
                if job_id not in known:
                    self._storage.remove(job_id)
        except StorageError as error:
            _log.error("the storage could not be tidied up: %s", error)
