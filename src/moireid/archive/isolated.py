"""Jobs done in a process of its own: one that crashes, hangs or eats memory loses its own job and nothing else.

A pool of Python's own breaks as a whole where one process dies, and cannot stop a job that takes too long.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Literal

from moireid.archive.child import IDLE_S, ONE_THREAD

#: A process has this long to load the program before its job's own time begins.
START_S = 120.0
#: Dask has its workers give memory back early by this, which also takes large arrays out of the heap for good: each
#: picture's would be faulted in page by page again, which took a third of a film's processor time.
NOT_HANDED_ON = frozenset({"MALLOC_TRIM_THRESHOLD_"})
#: What a job was lost to.  film: by itself, as it is too large; program: by a fault of ours.
Fault = Literal["film", "crash", "time", "memory", "program", "fetch", "worker"]


@dataclass(frozen=True)
class Limits:
    """What one job may take: seconds, and millions of bytes of memory; and a fetched film, in millions of bytes."""

    seconds: float = 3600.0
    memory_mb: int = 2048
    film_mb: float = 4096.0


@dataclass(frozen=True)
class Lost:
    """A job that no result came from: why in words, after how many seconds, and to what."""

    why: str
    seconds: float
    fault: Fault


class Isolated:
    """One child process, started with its first job and again after it was lost."""

    def __init__(self, limits: Limits, folder: str | None = None) -> None:
        """Parameters: folder: where the process's temporary files lie, None for the system's place."""
        self._limits, self._folder = limits, folder
        self._scratch: str | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: Connection | None = None
        self._used_s = 0.0
        self._ended = False

    def do(self, payload: bytes, film: str | None) -> Any | Lost:
        """The result of one job, or why there is none; payload: the pickled (work, job)."""
        begun = time.monotonic()
        if self._ended:
            return Lost("the run was ended", 0.0, "worker")
        if self._process is None or self._process.poll() is not None or begun - self._used_s > IDLE_S / 2:
            self._start()
        assert self._pipe is not None
        deadline, told = begun + START_S + self._limits.seconds, None
        try:
            self._pipe.send((payload, film))
            while self._pipe.poll(max(deadline - time.monotonic(), 0.0)):
                told = self._pipe.recv()
                if told[0] != "begun":
                    break
                begun, told = time.monotonic(), None
                deadline = begun + self._limits.seconds
        except (EOFError, OSError):
            return Lost(self._end_of_child(), time.monotonic() - begun, "crash")
        self._used_s = time.monotonic()
        if told is None:
            self.stop()
            words = f"it took longer than the {self._limits.seconds:g} s allowed"
            return Lost(words, time.monotonic() - begun, "time")
        return told[1] if told[0] == "done" else self._raised(told[1], told[2], self._used_s - begun)

    def end(self) -> None:
        """End the process, and do nothing more; a thread that waits for an outcome, if any, sees it by itself."""
        self._ended = True
        if (process := self._process) is not None:
            process.kill()
            process.wait()
        self._clear()

    def stop(self) -> None:
        """End the process."""
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.wait()
            self._pipe.close()
        self._process = self._pipe = None
        self._clear()

    def _clear(self) -> None:
        """Remove what the process has left: one that is killed clears nothing away itself."""
        if self._scratch is not None:
            shutil.rmtree(self._scratch, ignore_errors=True)
            self._scratch = None

    def _start(self) -> None:
        self.stop()
        ours, theirs = socket.socketpair()
        with theirs:
            # The work is found where this process would find it.
            path = os.pathsep.join(name for name in sys.path if name)
            self._scratch = tempfile.mkdtemp(prefix="moireid-", dir=self._folder)
            # -P: what lies in the present folder is not taken for a package.
            command = [
                sys.executable,
                "-P",
                "-m",
                "moireid.archive.child",
                str(theirs.fileno()),
                str(self._limits.memory_mb),
            ]
            self._process = subprocess.Popen(
                command,
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env={name: word for name, word in os.environ.items() if name not in NOT_HANDED_ON}
                | ONE_THREAD
                | {"PYTHONPATH": path, "TMPDIR": self._scratch},
            )
        self._pipe = Connection(ours.detach())

    def _end_of_child(self) -> str:
        """Why the process ended by itself, in words."""
        assert self._process is not None
        try:
            code = self._process.wait(5)
        except subprocess.TimeoutExpired:
            code = 0
        self.stop()
        how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
        return f"the process that had it ended by itself ({how})"

    def _raised(self, kind: str, words: str, seconds: float) -> Lost:
        # What it holds after a failure of ours is not known, and memory that ran out may be in pieces.
        self.stop()
        if kind == "memory":
            return Lost(f"it takes more memory than the {self._limits.memory_mb} MB allowed", seconds, "memory")
        return Lost(f"something went wrong inside moireid ({kind}: {words})", seconds, "program")
