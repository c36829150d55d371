"""Jobs done in a separate process: if it crashes, hangs or uses too much memory, only its own job is lost.

Python's process pools break as a whole if one process dies, and cannot stop a job that takes too long.
Jobs without a film are done by one process, one after another.  Each job with a film has a process of its own, which is
sealed and may open that film alone: a film that takes it over reaches no other film of the collection.  These are
forked from a program that has loaded the work, as loading takes longer than many a film.
"""

from __future__ import annotations

import pickle
import time
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

from moireid.sandbox.child import Talk
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ForkServer, ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits

#: Time for a process to load the program before the time of its job begins.
START_S = 120.0
#: A process without a job for this long ends; another is started when one is needed.
IDLE_S = 300.0
#: Largest result of one job: some results contain a whole film, but none that was made of an untrusted one.
ANSWER_BYTES, FILM_ANSWER_BYTES = 1 << 30, 1 << 20
#: Files that a process may have open that reads a film, and processor time as a multiple of its limit of time.
OPEN_FILES, PROCESSOR_TIMES = 256, 2
WORK = "moireid_lab.archive.isolated:do_jobs"
#: Why a job was lost.  film: it cannot be read; program: an error of ours.
Fault = Literal["film", "crash", "time", "memory", "program", "worker"]


@dataclass(frozen=True)
class Limits:
    """Limits of one job: seconds, and memory in millions of bytes."""

    seconds: float = 3600.0
    memory_mb: int = 2048


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


@cache
def _readers(module: str) -> ForkServer:
    """Where processes that read films are forked: they have loaded the module of their work."""
    # The decoder is loaded with a first film otherwise, in each process anew.
    return ForkServer(f"{module},av,{WORK}", sealed=True, one_thread=True)


class IsolatedProcess:
    """One process at a time: for a film, or for all jobs without one until it is lost."""

    def __init__(self, module: str, limits: Limits, folder: str | None = None) -> None:
        """Parameters: module: of the work; folder: for the process's temporary files; None: the system's folder."""
        self._module, self._limits, self._folder = module, limits, folder
        self._child: Child | None = None
        self._used_s = 0.0
        self._ended = False
        self._name = ""

    def rename(self, name: str) -> None:
        """Have a new process for tasks of another name."""
        if name != self._name:
            self.stop()
        self._name = name

    def do(self, payload: bytes, film: str | None) -> Any | LostJob:
        """The result of one job as JSON gives it, or why there is none; payload: the pickled (work, job).

        A result about a film that is an object gets `sealed`, the parts of the seal that held while it was read: this
        process states them, as the one that read the film may be in its hands.
        """
        begun = time.monotonic()
        if self._ended:
            return LostJob("the run was ended", 0.0, "worker")
        child = self._ready() if film is None else self._reader(film)
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
        if message is None or film is not None:
            self.stop()
        if message is None:
            words = f"it took longer than the {self._limits.seconds:g} s allowed"
            return LostJob(words, time.monotonic() - begun, "time")
        found = message.get("result")
        return found | {"sealed": list(child.sealed or ())} if film is not None and isinstance(found, dict) else found

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

    def _ready(self) -> Child:
        """The process for jobs without a film; a new one if it has ended or may be about to end."""
        if self._child is not None and time.monotonic() - self._used_s < IDLE_S / 2:
            try:
                self._child.hear(0.0)
                return self._child
            except ProcessEnd:
                pass
        self.stop()
        limits = ProcessLimits(self._limits.memory_mb * 1_000_000, answer_bytes=ANSWER_BYTES)
        self._child = start(WORK, limits, self._folder)
        return self._child

    def _reader(self, film: str) -> Child:
        """A process that may open this film, and no other file of the user."""
        self.stop()
        limits = ProcessLimits(
            self._limits.memory_mb * 1_000_000,
            cpu_s=int(PROCESSOR_TIMES * self._limits.seconds) + 1,
            file_bytes=0,
            answer_bytes=FILM_ANSWER_BYTES,
            open_files=OPEN_FILES,
        )
        self._child = _readers(self._module).fork(limits, self._folder, within=reach(read=[film]))
        return self._child

    def _lost(self, ended: ProcessEnd, seconds: float) -> LostJob:
        if ended.kind == "crash":
            return LostJob(f"the process that had it {ended.words}", seconds, "crash")
        if ended.kind == "memory":
            return LostJob(f"it takes more memory than the {self._limits.memory_mb} MB allowed", seconds, "memory")
        return LostJob(f"something went wrong inside moireid ({ended.kind}: {ended.words[:300]})", seconds, "program")
