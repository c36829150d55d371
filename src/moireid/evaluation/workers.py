"""Jobs done in processes of their own: one that crashes or hangs loses its own job, and the others go on.

A pool of Python's own breaks as a whole where one process dies, and cannot stop a job that takes too long.  Here each
worker has a pipe; the run waits for whichever speaks first, falls silent, or is late.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

#: A process has this long to load the program before its job's own time begins.
START_S = 120.0
BEGUN = "begun"


@dataclass(frozen=True)
class Lost:
    """A job that no result came from, and why."""

    why: str
    seconds: float


def run_jobs(
    work: Callable[[Any], Any], jobs: Sequence[Any], *, workers: int, timeout_s: float
) -> Generator[tuple[int, Any], None, None]:
    """Yield (place of the job, its result) as jobs end; a job that crashed or took too long gives `Lost`.

    Parameters: work: a function at the top of a module, as other processes import it by name; timeout_s: of one job.
    Closing the generator ends all its processes.
    """
    todo, crew = deque(range(len(jobs))), [_Worker() for _ in range(min(workers, len(jobs)))]
    try:
        while todo or any(worker.busy for worker in crew):
            for worker in crew:
                if todo and not worker.busy:
                    worker.begin(work, todo.popleft(), jobs, workers, timeout_s)
            busy = [worker for worker in crew if worker.busy]
            rest = min(worker.deadline for worker in busy) - time.monotonic()
            heard = wait([worker.pipe for worker in busy if worker.pipe], timeout=max(rest, 0.0))
            for worker in busy:
                outcome = worker.hear(timeout_s) if worker.pipe in heard else worker.late(timeout_s)
                if outcome is not None:
                    yield worker.done(), outcome[0]
    finally:
        for worker in crew:
            worker.stop()


class _Worker:
    """One process, started with its first job and again after it was lost."""

    def __init__(self) -> None:
        self.pipe: Connection | None = None
        self._process: Any = None
        self._job: int | None = None
        self._since = 0.0
        self.deadline = math.inf

    @property
    def busy(self) -> bool:
        """Whether it has a job."""
        return self._job is not None

    def begin(self, work: Callable[[Any], Any], job: int, jobs: Sequence[Any], workers: int, timeout_s: float) -> None:
        """Hand it a job."""
        self._job, self._since = job, time.monotonic()
        if self.pipe is None:
            # Forking would copy threads' locks in whatever state they are.
            context = multiprocessing.get_context("spawn")
            self.pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs, work, workers), daemon=True)
            self._process.start()
            theirs.close()
        self.deadline = self._since + START_S + timeout_s
        try:
            self.pipe.send(jobs[job])
        except OSError:
            # It died meanwhile; listening tells so.
            return

    def hear(self, timeout_s: float) -> tuple[Any] | None:
        """What it says: the outcome in a tuple, or None where it only says that it began."""
        assert self.pipe is not None
        try:
            kind, outcome = self.pipe.recv()
        except (EOFError, OSError):
            seconds = time.monotonic() - self._since
            self._process.join(5)
            code = self._process.exitcode
            self.stop()
            return (Lost(f"the process that scored it ended by itself (exit code {code})", seconds),)
        if kind == BEGUN:
            self._since = time.monotonic()
            self.deadline = self._since + timeout_s
            return None
        return (outcome,)

    def late(self, timeout_s: float) -> tuple[Lost] | None:
        """The outcome of a job whose time is over, else None."""
        if time.monotonic() < self.deadline:
            return None
        self.stop()
        return (Lost(f"it took longer than the {timeout_s:g} s allowed", time.monotonic() - self._since),)

    def done(self) -> int:
        """The job that it had; it has none from now on."""
        assert self._job is not None
        job, self._job = self._job, None
        return job

    def stop(self) -> None:
        """End the process."""
        if self.pipe is not None:
            self.pipe.close()
            self._process.kill()
            self._process.join()
        self.pipe = None


def _serve(pipe: Connection, work: Callable[[Any], Any], workers: int) -> None:
    """Do jobs until nobody asks for more."""
    import cv2

    # An interrupt reaches every process of the terminal; the one that started this decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if workers > 1:
        cv2.setNumThreads(max(1, (os.cpu_count() or 1) // workers))
    while True:
        try:
            job = pipe.recv()
            pipe.send((BEGUN, None))
            pipe.send(("done", work(job)))
        except (EOFError, OSError):
            return
