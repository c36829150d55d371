"""Jobs done in a separate process: if it crashes, hangs or uses too much memory, only its own job is lost.

Python's process pools break as a whole if one process dies, and cannot stop a job that takes too long.
"""

from __future__ import annotations

import pickle
import time
from dataclasses import dataclass
from typing import Any, Literal

from moireid.sandbox.child import Talk
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits

#: Time for a process to load the program before the time of its job begins.
START_S = 120.0
#: A process without a job for this long ends; another is started when one is needed.
IDLE_S = 300.0
#: Largest result of one job; some results contain a whole film.
ANSWER_BYTES = 1 << 30
#: Why a job was lost.  film: it is too large; program: an error of ours.
Fault = Literal["film", "crash", "time", "memory", "program", "fetch", "worker"]


@dataclass(frozen=True)
class Limits:
    """Limits of one job: seconds, and memory in millions of bytes; and of a fetched film, in millions of bytes."""

    seconds: float = 3600.0
    memory_mb: int = 2048
    film_mb: float = 4096.0


@dataclass(frozen=True)
class LostJob:
    """A job without a result: the reason in words, the seconds it took, and the kind of fault."""

    why: str
    seconds: float
    fault: Fault


def do_jobs(talk: Talk) -> None:
    """The work of the process: jobs one after another, until there are no more."""
    while (asked := talk.next(IDLE_S)) is not None:
        payload, film = asked
        work, job = pickle.loads(payload)
        talk.send({"begun": True})
        talk.send({"result": work(job) if film is None else work(job, film)})


class IsolatedProcess:
    """One process, started with its first job, and restarted after it was lost."""

    def __init__(self, limits: Limits, folder: str | None = None) -> None:
        """Parameters: folder: for the process's temporary files; None: the system's folder."""
        self._limits, self._folder = limits, folder
        self._child: Child | None = None
        self._used_s = 0.0
        self._ended = False
        #: Whether the process is sealed, as those are that read films.
        self._sealed = False

    def do(self, payload: bytes, film: str | None) -> Any | LostJob:
        """The result of one job as JSON gives it, or why there is none; payload: the pickled (work, job)."""
        begun = time.monotonic()
        if self._ended:
            return LostJob("the run was ended", 0.0, "worker")
        child = self._ready(sealed=film is not None)
        try:
            child.send((payload, film), START_S + self._limits.seconds)
            message = child.hear(START_S + self._limits.seconds)
            if message is not None and "begun" in message:
                begun = time.monotonic()
                message = child.hear(self._limits.seconds)
        except ProcessEnd as ended:
            self.stop()
            return self._lost(ended, time.monotonic() - begun)
        self._used_s = time.monotonic()
        if message is None:
            self.stop()
            words = f"it took longer than the {self._limits.seconds:g} s allowed"
            return LostJob(words, time.monotonic() - begun, "time")
        return message.get("result")

    def end(self) -> None:
        """End the process for good; a thread that waits for its result notices by itself."""
        self._ended = True
        if (child := self._child) is not None:
            child.kill()

    def stop(self) -> None:
        """End the process: after a failure its state is unknown."""
        if self._child is not None:
            self._child.kill()
        self._child = None

    def _ready(self, *, sealed: bool) -> Child:
        """The process; a new one if it has ended or may be about to end, or is not the one for such a job."""
        if self._child is not None and sealed == self._sealed and time.monotonic() - self._used_s < IDLE_S / 2:
            try:
                self._child.hear(0.0)
                return self._child
            except ProcessEnd:
                pass
        self.stop()
        limits = ProcessLimits(self._limits.memory_mb * 1_000_000, answer_bytes=ANSWER_BYTES)
        # One process reads film after film, which may lie anywhere; so it may read all files but the private ones.
        within = reach(read=["/"]) if sealed else None
        self._child = start("moireid_lab.archive.isolated:do_jobs", limits, self._folder, within=within)
        self._sealed = sealed
        return self._child

    def _lost(self, ended: ProcessEnd, seconds: float) -> LostJob:
        if ended.kind == "crash":
            return LostJob(f"the process that had it {ended.words}", seconds, "crash")
        if ended.kind == "memory":
            return LostJob(f"it takes more memory than the {self._limits.memory_mb} MB allowed", seconds, "memory")
        return LostJob(f"something went wrong inside moireid ({ended.kind}: {ended.words[:300]})", seconds, "program")
