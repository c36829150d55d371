"""Films judged on other machines, by the workers of a Dask scheduler, each in a sealed process as here.

A worker fetches the film from the studio by HTTP, with a token for this one job (`api.work_api`), and passes on by the
same token what the film's process says.  So the studio checks each message as one of a process of its own; a worker has
no registry, no database and no key.
Dask gives the film of a lost worker to another one, three times (its setting `allowed-failures`).  Where the job was
removed, or the studio has ended, the token opens nothing any more, and the worker ends the film's process.
"""

from __future__ import annotations

import json
import logging
import secrets
import shutil
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from moireid.errors import SpecError
from moireid.result_cache import program_digest
from moireid.sandbox.process import sealed_here
from moireid.sandbox.seal import ProcessLimits, missing
from moireid.scheduler import scheduler_client
from moireid_studio.jobs.child import STOPPED, JobFailure, run_task
from moireid_studio.jobs.task import Task

#: Kinds of jobs that are done there: those of films that need none of this machine's folders.
JUDGED = frozenset({"verify", "identify"})
#: How often a film is begun again that could not be fetched.
RETRIES = 2
#: How long a worker waits for an answer of the studio, s.
ANSWER_S = 90.0
#: A film that no worker has judged by then is given up; time between two looks whether one has, s.
WAIT_S, LOOK_S = 3600.0, 0.05


@dataclass(frozen=True)
class RemoteTask:
    """What a worker is given.

    task: with no folder yet; url, token: by which it reaches the studio; program: digest of the studio's moireid.
    """

    task: Task
    limits: ProcessLimits
    wall_s: float
    url: str
    token: str
    program: str
    unsealed: bool


def judge_there(remote: RemoteTask) -> tuple[str, str] | None:
    """Do a task on a worker; returns code and sentence of what was wrong, None where nothing was.

    Raises: OSError where the film cannot be fetched.
    """
    if program_digest() != remote.program:
        return "system", "A worker has another moireid than the studio."
    if not remote.unsealed and missing(sealed_here()) is not None:
        return "system", "A worker cannot seal the process that reads a film."
    with tempfile.TemporaryDirectory(prefix="moireid-job-", ignore_cleanup_errors=True) as made:
        folder = Path(made)
        try:
            with _ask(remote, "film") as film, (folder / remote.task.video).open("xb") as file:
                shutil.copyfileobj(film, file)
            task = replace(remote.task, folder=folder)
            run_task(task, remote.limits, partial(_hand_on, remote), wall_s=remote.wall_s, stopping=lambda: False)
        except JobFailure as failure:
            return failure.code, failure.text
    return None


def _hand_on(remote: RemoteTask, message: dict[str, Any]) -> None:
    """Give a message to the studio.  Raises: JobFailure where the job is no more."""
    _ask(remote, "message", json.dumps(message).encode()).close()


def _ask(remote: RemoteTask, what: str, content: bytes | None = None) -> Any:
    """The studio's answer.  Raises: JobFailure where it refuses the token; OSError where it cannot be reached."""
    headers = {"Authorization": f"Bearer {remote.token}", "Content-Type": "application/json"}
    try:
        return urllib.request.urlopen(
            urllib.request.Request(f"{remote.url}/work/{what}", content, headers), timeout=ANSWER_S
        )
    except urllib.error.HTTPError as error:
        raise JobFailure(*STOPPED) from error


@dataclass
class Run:
    """A job that is done elsewhere, as the studio has it.

    begin: called as a worker begins; handle: takes each message; fault: what was wrong with one.
    """

    film: Path
    begin: Callable[[], None]
    handle: Callable[[dict[str, Any]], object]
    lock: threading.Lock = field(default_factory=threading.Lock)
    fault: Exception | None = None


class Cluster:
    """The workers of a scheduler, for one studio; safe to use from any thread."""

    def __init__(self, scheduler: str, url: str, *, unsealed: bool) -> None:
        """Connect.

        Parameters
        ----------
        url
            By which the workers reach this studio.
        unsealed
            Whether films are also read where a worker cannot seal their process.

        Raises
        ------
        SpecError
            Where the address is open to others, or no scheduler answers.
        MissingExtraError
        """
        self._scheduler, self._url, self._unsealed = scheduler, url.rstrip("/"), unsealed
        self._runs: dict[str, Run] = {}
        self._lock = threading.Lock()
        self._client = self._connect()

    def _connect(self) -> Any:
        return scheduler_client(self._scheduler, ("cluster", "moireid-studio"))

    @property
    def there(self) -> bool:
        """Whether the scheduler is connected."""
        return bool(self._client.status == "running")

    def close(self) -> None:
        """Leave the scheduler."""
        self._client.close()

    def run_of(self, token: str) -> Run | None:
        """The job of a worker's token."""
        return self._runs.get(token)

    def run(
        self,
        task: Task,
        limits: ProcessLimits,
        handle: Callable[[dict[str, Any]], object],
        begin: Callable[[], None],
        *,
        wall_s: float,
        stopping: Callable[[], bool],
    ) -> None:
        """As `child.run_task`, by a worker.

        Raises: JobFailure; what `handle` raised; OSError.
        """
        token, run = secrets.token_urlsafe(32), Run(task.folder / task.video, begin, handle)
        there = replace(task, folder=Path())
        remote = RemoteTask(there, limits, wall_s, self._url, token, program_digest(), self._unsealed)
        self._runs[token] = run
        try:
            future = self._live().submit(
                judge_there, remote, key=f"moireid-{secrets.token_hex(8)}", retries=RETRIES, pure=False
            )
            try:
                problem = self._end(future, run, stopping)
            finally:
                future.cancel(force=True)
        finally:
            del self._runs[token]
        if problem is not None:
            raise JobFailure(*problem)

    def _live(self) -> Any:
        """The client, connected anew if need be.  Raises: JobFailure, after which the job waits again."""
        with self._lock:
            if not self.there:
                try:
                    self._client.close()
                    self._client = self._connect()
                except SpecError as error:
                    logging.getLogger(__name__).error("%s", error)
                    raise JobFailure(*STOPPED) from error
            return self._client

    def _end(self, future: Any, run: Run, stopping: Callable[[], bool]) -> tuple[str, str] | None:
        """Wait for a worker's end.  Raises: as `run`."""
        from distributed import KilledWorker

        last = time.monotonic() + WAIT_S
        while time.monotonic() < last:
            if run.fault is not None:
                raise run.fault
            if stopping():
                raise JobFailure(*STOPPED)
            if not future.done():
                time.sleep(LOOK_S)
                continue
            try:
                end: tuple[str, str] | None = future.result()
            except KilledWorker as error:
                raise JobFailure("crash", "The workers that had this film were lost one after the other.") from error
            except CancelledError as error:
                # The scheduler went away, or was started anew.
                raise JobFailure(*STOPPED) from error
            except OSError as error:
                raise JobFailure("system", "A worker could not fetch this film; try again later.") from error
            if run.fault is not None:
                raise run.fault
            return end
        raise JobFailure("time", "No worker has judged this film within an hour; send it again.")
