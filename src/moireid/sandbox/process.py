"""A process within limits, as the one who started it sees it.

It is a plain program and no process of `multiprocessing`: Dask's workers are daemons, which that package lets have no
children, and its fork server takes modules from the present folder.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from moireid.sandbox.limits import ProcessLimits

#: A fork server that takes longer to load its work, or to answer, is given up.
LOAD_S = 120.0
#: Read by libraries as they are loaded; OpenCV's own number is what the decoder goes by.
ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "OPENCV_FOR_THREADS_NUM",
    ),
    "1",
)
#: Dask has its workers give memory back early by this, which also takes large arrays out of the heap for good: each
#: picture's would be faulted in page by page again, which took a third of a film's processor time.
NOT_HANDED_ON = frozenset({"MALLOC_TRIM_THRESHOLD_"})


class Ended(Exception):
    """A process has ended, or has to be ended: kind and words.

    kind: "done" where its work is; "crash" where the process ended by itself; "memory" where it asked for too much;
    else the name of the error that its work raised.  ours: an error that moireid raises on purpose.
    """

    def __init__(self, kind: str, words: str, *, ours: bool = False) -> None:
        super().__init__(words)
        self.kind, self.words, self.ours = kind, words, ours


class Child:
    """One process within limits; whoever has it ends it by `kill`, from any thread."""

    def __init__(self, pipe: Connection, end: Callable[[], int | None], folder: str, limits: ProcessLimits) -> None:
        """Parameters: end: ends the process and tells its exit code; folder: of its temporary files."""
        self._pipe, self._end, self._folder, self._limits = pipe, end, folder, limits
        self._lock, self._over = threading.Lock(), False
        self._code: int | None = None

    def send(self, message: Any) -> None:
        """Send a message.  Raises: Ended where the process has gone."""
        try:
            self._pipe.send(message)
        except OSError as error:
            raise self._gone() from error

    def hear(self, seconds: float | None = None) -> dict[str, Any] | None:
        """What the process says next; None where it says nothing for so long.  Raises: Ended."""
        try:
            if not self._pipe.poll(seconds):
                return None
            told = json.loads(self._pipe.recv_bytes(self._limits.answer_bytes))
            if not isinstance(told, dict):
                raise ValueError("no object")
            if "ended" not in told:
                return told
            kind, words, ours = told["ended"]
        except (EOFError, OSError) as error:
            raise self._gone() from error
        except (ValueError, TypeError, RecursionError) as error:
            raise Ended("crash", "it said what cannot be read") from error
        raise Ended(str(kind), str(words), ours=bool(ours))

    def kill(self) -> None:
        """End the process, and remove its temporary files; again changes nothing.

        A thread that waits to hear it hears that it has ended.
        """
        with self._lock:
            if not self._over:
                self._over, self._code = True, self._end()
                shutil.rmtree(self._folder, ignore_errors=True)

    def _gone(self) -> Ended:
        self.kill()
        if self._code is None:
            return Ended("crash", "ended by itself")
        how = f"by {signal.Signals(-self._code).name}" if self._code < 0 else f"with exit code {self._code}"
        return Ended("crash", f"ended by itself ({how})")


def start(work: str, limits: ProcessLimits, folder: Path | str | None = None) -> Child:
    """A new program that does some work (`module:function`) on one thread.

    Parameters: folder: where its temporary files lie, None for the system's place.
    Raises: OSError where it cannot be started.
    """
    scratch = _scratch(folder)
    program, line = _program(work, _begin(scratch, limits), environment=ONE_THREAD)

    def end() -> int:
        program.kill()
        return program.wait()

    return Child(Connection(line.detach()), end, scratch, limits)


class ForkServer:
    """A program that has loaded some work, of which a process is forked for each time that it is to be done.

    It starts when it is first asked for, and again where it has gone; it ends with this process.
    """

    def __init__(self, work: str) -> None:
        self._work, self._lock = work, threading.Lock()
        self._program: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None

    def warm_up(self) -> None:
        """Let it begin to load the work, if it has not yet."""
        with self._lock:
            self._begun()

    def fork(self, limits: ProcessLimits, folder: Path | str | None = None) -> Child:
        """A process that does the work; folder as in `start`.  Raises: OSError where none can be started."""
        ours, theirs = socket.socketpair()
        with ours, theirs:
            scratch = _scratch(folder)
            with self._lock:
                line = self._begun()
                try:
                    socket.send_fds(line, [_begin(scratch, limits).encode()], [theirs.fileno()])
                    number = _answer(line)
                except OSError:
                    # What it would answer later would be taken for the answer to something else.
                    self._drop()
                    raise
            return Child(Connection(ours.detach()), lambda: self._end(line, number), scratch, limits)

    def _begun(self) -> socket.socket:
        if self._program is not None and self._program.poll() is not None:
            self._drop()
        if self._line is None:
            self._program, self._line = _program(self._work)
            self._line.settimeout(LOAD_S)
        return self._line

    def _drop(self) -> None:
        if self._program is not None and self._line is not None:
            self._line.close()
            self._program.kill()
            self._program.wait()
        self._program = self._line = None

    def _end(self, line: socket.socket, number: int) -> int | None:
        # Processes of a fork server that has gone leave by themselves.
        with self._lock, suppress(OSError):
            line.sendall(str(number).encode())
            return _answer(line)
        return None


def _answer(line: socket.socket) -> int:
    if len(answer := line.recv(8)) < 8:
        raise OSError(0, "the program that others are forked from has ended")
    return int.from_bytes(answer, "big", signed=True)


def _scratch(folder: Path | str | None) -> str:
    # The process may be forked from one that works in another folder.
    return os.path.abspath(tempfile.mkdtemp(prefix="moireid-", dir=folder))


def _begin(scratch: str, limits: ProcessLimits) -> str:
    return json.dumps({"folder": scratch, "limits": asdict(limits)})


def _program(
    *arguments: str, environment: dict[str, str] | None = None
) -> tuple[subprocess.Popen[bytes], socket.socket]:
    """A program with a line to it, which finds modules where this process does, and none in the present folder."""
    kept = {name: word for name, word in os.environ.items() if name not in NOT_HANDED_ON}
    path = os.pathsep.join(name for name in sys.path if name)
    ours, theirs = socket.socketpair()
    with theirs:
        try:
            program = subprocess.Popen(
                # -P: what lies in the present folder is not taken for a package.
                [sys.executable, "-P", "-m", "moireid.sandbox.child", str(theirs.fileno()), *arguments],
                pass_fds=[theirs.fileno()],
                # Decoders talk; what a stranger's film makes them say is not for this process's own streams.
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=kept | {"PYTHONPATH": path} | (environment or {}),
            )
        except OSError:
            ours.close()
            raise
    return program, ours
