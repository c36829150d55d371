"""The jobs of one studio: a limited number waits, threads judge them, and results are kept for a while.

A table says which jobs there are (`store.ledger`).  A film is in the folder of its job until it is judged, and what is
kept of it then is there too.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
from collections.abc import AsyncIterator, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import anyio
from starlette.concurrency import run_in_threadpool

from moireid_studio.auth.tokens import Role
from moireid_studio.http.server import Rates, fits
from moireid_studio.jobs.child import films
from moireid_studio.jobs.workers import Doer, Workers
from moireid_studio.problems import Refusal
from moireid_studio.store.database import patiently
from moireid_studio.store.job import JOB_ID, Job, Lane

__all__ = ["Job", "Jobs"]
#: Time between two looks at a job that is waited for, s.
LOOK_S = 0.2


class Jobs:
    """The jobs of one studio; safe to use from any thread."""

    def __init__(self, folder: Path, doer: Doer) -> None:
        """Hold the jobs of a folder; none is begun before `start`."""
        # Made absolute, because a job's process begins in another folder.
        self._folder, self.doer, self._limits = folder.absolute(), doer, doer.limits
        self.ledger, self.rates = doer.ledger, Rates(doer.limits)
        self.workers = Workers(doer)
        #: Bytes of films on their way here, by job; and those of all that are stored, by owner, as of the last look.
        self._coming: dict[str, tuple[str, int]] = {}
        self._there: dict[str, int] = {}

    def start(self) -> None:
        """Begin to work, with what a studio that was killed has left."""
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.ledger.recover()
        self.workers.sweep()
        films.warm_up()
        both: Sequence[Lane] = ("issue", "judge")
        # One that takes no film, so that no verifier's film keeps an issuer waiting.
        self.workers.start([both] * self._limits.workers + [("issue",)])

    def stop(self) -> None:
        """End the work: films that are not judged yet wait for the next start, results are kept."""
        self.workers.stop()
        # A folder that holds other files stays.
        with contextlib.suppress(OSError):
            self._folder.rmdir()

    @property
    def at_work(self) -> bool:
        """Whether there are workers that take jobs."""
        return bool(self.workers.threads) and not self.workers.stopping.is_set()

    def admit(self, kind: str, owner: str, role: Role = "verifier") -> Job:
        """A new job, with a folder for its film.

        Raises: Refusal 503 where too many wait already; 429 where the token sends too many.
        """
        self.rates.upload(owner, role)
        self._there = self.ledger.stored()
        job = self.ledger.admit(kind, owner, role, lambda held: fits(held, owner, role, self._limits))
        if job is None:
            text = "Too many films wait to be judged; try again in a minute."
            raise Refusal(503, "busy", text, headers={"Retry-After": "60"})
        try:
            job.folder.mkdir(mode=0o700)
        except OSError as error:
            self.remove(job)
            raise Refusal(503, "disk", f"The film cannot be stored ({error.strerror}); try again later.") from error
        return job

    @contextlib.contextmanager
    def receiving(self, kind: str, owner: str, role: Role = "verifier") -> Iterator[Job]:
        """Like `admit`, while the film is received: if anything goes wrong, the received part is removed."""
        job = self.admit(kind, owner, role)
        try:
            yield job
        except BaseException:
            self.remove(job)
            raise
        finally:
            self._coming.pop(job.id, None)

    @contextlib.asynccontextmanager
    async def coming(self, kind: str, owner: str, role: Role) -> AsyncIterator[Job]:
        """Like `receiving`, for a route that waits for a visitor's bytes; the database is asked in another thread.

        A visitor who leaves counts as a fault too, because the route is cancelled then.
        """
        job = await run_in_threadpool(self.admit, kind, owner, role)
        try:
            yield job
        except BaseException:
            with anyio.CancelScope(shield=True):
                await run_in_threadpool(self.remove, job)
            raise
        finally:
            self._coming.pop(job.id, None)

    def stored(self, job: Job, size: int) -> None:
        """So many bytes of a job's film have come.  Raises: Refusal 503 where that is more than the disk's share."""
        job.bytes = size
        self._coming[job.id] = job.owner, size
        there = self._there
        coming = list(self._coming.values())
        own = there.get(job.owner, 0) + sum(size for owner, size in coming if owner == job.owner)
        if sum(there.values()) + sum(size for _, size in coming) > self._limits.disk_bytes or (
            own > self._limits.disk_bytes // 2
        ):
            text = "The place for films is full; try again when others are judged."
            raise Refusal(503, "disk", text, headers={"Retry-After": "60"})

    def submit(self, job: Job, video: Path, wish: dict[str, Any] | None = None) -> None:
        """Let a job begin as soon as a worker is free; the wish is JSON and depends on the kind of work.

        Raises: Refusal 404 where the job was removed meanwhile.
        """
        job.video, job.wish = video.name, wish or {}
        if not self.ledger.submit(job):
            self.remove(job)
            raise Refusal(404, "no_job", "This job was removed meanwhile; send the film again.")
        job.state = "waiting"
        self.workers.wake()

    def keep(self, job: Job) -> None:
        """Keep what a job brings that no thread does.  Raises: Refusal 404 where the job was removed meanwhile."""
        if not self.ledger.keep(job):
            raise Refusal(404, "no_job", "This was removed meanwhile; send it again.")
        job.state = "done"

    def find(self, job_id: str, owner: str, *kinds: str) -> Job:
        """The job with that id, if it belongs to `owner` and is of one of `kinds` (none named: of any kind).

        Raises: Refusal 404 otherwise.
        """
        job = self.ledger.find(job_id) if JOB_ID.fullmatch(job_id) else None
        if job is None or job.owner != owner or (kinds and job.kind not in kinds):
            raise Refusal(404, "no_job", "There is no such job, or its results were removed already.")
        return job

    async def changes(self, job: Job) -> AsyncIterator[tuple[Job, bool]]:
        """The job each time that its state or progress changed, wherever it is done; and whether that is the last, as
        it is over, was removed, or this studio stops.
        """
        seen: object = None
        look = partial(self.ledger.find, job.id)
        while True:
            # A database that is away for some seconds says nothing of any job.
            now = await run_in_threadpool(patiently, look)
            job, over = now or job, now is None or now.over or self.workers.stopping.is_set()
            if over or (job.state, job.frames) != seen:
                seen = job.state, job.frames
                yield job, over
            if over:
                return
            await asyncio.sleep(LOOK_S)

    def remove(self, job: Job) -> None:
        """Forget a job, and remove all its files."""
        self._coming.pop(job.id, None)
        self.ledger.remove(job.id)
        shutil.rmtree(job.folder, ignore_errors=True)

    def check(self) -> dict[str, bool]:
        """Of the folder of films, the threads and the scheduler, whether they are there."""
        found = {"storage": os.access(self._folder, os.W_OK), "at_work": self.at_work}
        return found if self.doer.cluster is None else found | {"scheduler": self.doer.cluster.there}
