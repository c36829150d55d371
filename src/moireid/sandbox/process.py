"""A process within limits, from its parent's side.

It is a plain program and does not use `multiprocessing`: that package allows Dask's workers, which are daemons, no
children, and its fork server imports modules from the current folder.
"""

from __future__ import annotations

import json
import os
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import msgspec

from moireid.sandbox.file_access import Reach, reach
from moireid.sandbox.line import MessageChannel
from moireid.sandbox.seal import ProcessLimits

#: Longest time for a fork server to load its work, or to answer.
LOAD_S = 120.0
#: Libraries read these when they are loaded; by OpenCV's number a process decodes ahead or not (`video.one_thread`).
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
#: Dask sets this so that its workers return memory early.  It also keeps large arrays out of the heap, so that the
#: memory of each picture is mapped again page by page, which took a third of a film's processor time.
NOT_HANDED_ON = frozenset({"MALLOC_TRIM_THRESHOLD_"})
#: A sealed process gets these variables of the environment and no other: any other may hold a password or a key.
KEPT_VARIABLES = ("PATH", "HOME", "LANG", "TZ", "TMPDIR", "LD_LIBRARY_PATH", "VIRTUAL_ENV", "MPLCONFIGDIR")
KEPT_BEGINNINGS = ("LC_", "PYTHON", "OPENCV_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_", "VECLIB_")


class ProcessEnd(Exception):
    """A process has ended, or must be ended: kind and words.

    kind: "done" if its work is done; "crash" if the process ended by itself; "memory" if it needed too much; otherwise
    the name of the error that its work raised.  ours: whether moireid raised that error on purpose.
    """

    def __init__(self, kind: str, words: str, *, ours: bool = False) -> None:
        super().__init__(words)
        self.kind, self.words, self.ours = kind, words, ours


class Child:
    """One process within limits; its owner ends it by `kill`, from any thread."""

    def __init__(self, line: MessageChannel, end: Callable[[], int | None], folder: str, limits: ProcessLimits) -> None:
        """Parameters: end: ends the process and returns its exit code; folder: for its temporary files."""
        self._line, self._end, self._folder, self._limits = line, end, folder, limits
        self._lock, self._over = threading.Lock(), False
        self._code: int | None = None
        #: The parts of its seal that hold, as in `seal.MEANS`; None until it has reported them, and where it has none.
        self.sealed: tuple[str, ...] | None = None

    def send(self, message: Any, seconds: float | None = None) -> None:
        """Send a message, which the process must have taken within `seconds`; None: no limit.

        Raises: ProcessEnd where the process has gone, or took too long; then nothing more can be sent to it.
        """
        try:
            taken = self._line.send(pickle.dumps(message), seconds)
        except OSError as error:
            raise self._gone() from error
        if not taken:
            raise ProcessEnd("crash", "does not read what it is sent")

    def hear(self, seconds: float | None = None) -> dict[str, Any] | None:
        """The next answer of the process; None if there is no whole one for `seconds`.  Raises: ProcessEnd."""
        last = None if seconds is None else time.monotonic() + seconds
        try:
            while True:
                rest = None if last is None else max(last - time.monotonic(), 0.0)
                if (body := self._line.receive(self._limits.answer_bytes, rest)) is None:
                    return None
                answer = msgspec.json.decode(body)
                if not isinstance(answer, dict):
                    raise ValueError("no object")
                # Only the first message is of a process that has read nothing untrusted yet.
                if "sealed" not in answer or self.sealed is not None:
                    break
                self.sealed = tuple(map(str, answer["sealed"]))
            if "ended" not in answer:
                return answer
            kind, words, ours = answer["ended"]
        except (EOFError, OSError) as error:
            raise self._gone() from error
        except (ValueError, TypeError, RecursionError) as error:
            raise ProcessEnd("crash", "it said what cannot be read") from error
        raise ProcessEnd(str(kind), str(words), ours=bool(ours))

    def kill(self) -> None:
        """End the process, and remove its temporary files; a second call changes nothing.

        A thread that waits in `hear` or `send` gets `ProcessEnd`.
        """
        with self._lock:
            if not self._over:
                self._over, self._code = True, self._end()
                shutil.rmtree(self._folder, ignore_errors=True)

    def _gone(self) -> ProcessEnd:
        self.kill()
        if self._code is None:
            return ProcessEnd("crash", "ended by itself")
        how = f"by {signal.Signals(-self._code).name}" if self._code < 0 else f"with exit code {self._code}"
        return ProcessEnd("crash", f"ended by itself ({how})")


def start(work: str, limits: ProcessLimits, folder: Path | str | None = None, *, within: Reach | None = None) -> Child:
    """A new program that does some work (`module:function`) on one thread.

    Parameters: folder: for its temporary files; None: the system's folder.  within: what it may open, as it is to seal
        itself; None: it is not sealed.
    Raises: OSError if it cannot be started.
    """
    scratch = _scratch_folder(folder)
    own = _environment(sealed=within is not None)
    program, line = _program(work, _beginning(scratch, limits, within), environment=own | ONE_THREAD)

    def end() -> int:
        program.kill()
        return program.wait()

    return Child(MessageChannel(line), end, scratch, limits)


@cache
def sealed_here() -> tuple[str, ...]:
    """The parts of the seal that hold on this system, as in `seal.MEANS`, as a process that sealed itself reports them.

    Raises: OSError if none can be started.
    """
    child = start("moireid.sandbox.child:rest", ProcessLimits(1 << 28), within=reach())
    with suppress(ProcessEnd):
        child.hear(LOAD_S)
    child.kill()
    return child.sealed or ()


class ForkServer:
    """A program that has loaded some work, and forks a process for each request.

    It starts with the first request, and again if it has gone; it ends with this process.
    """

    def __init__(self, work: str, *, sealed: bool = False, one_thread: bool = False) -> None:
        """Parameters: work: `module:function`, after the names of further modules to load, separated by commas.
        sealed: its processes seal themselves, so it has nothing in its environment that is private.  one_thread: they
        work on one thread, as with `start`.
        """
        self._work, self._lock, self._sealed = work, threading.Lock(), sealed
        self._fixed = ONE_THREAD if one_thread else {}
        self._program: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None

    def warm_up(self) -> None:
        """Begin to load the work, if that has not begun yet."""
        with self._lock:
            self._begun()

    def close(self) -> None:
        """End the program, and wait for it."""
        with self._lock:
            self._drop()

    def fork(self, limits: ProcessLimits, folder: Path | str | None = None, *, within: Reach | None = None) -> Child:
        """A process that does the work; folder and within as in `start`.  Raises: OSError if none can be started."""
        ours, theirs = socket.socketpair()
        with ours, theirs:
            scratch = _scratch_folder(folder)
            with self._lock:
                line = self._begun()
                try:
                    socket.send_fds(line, [_beginning(scratch, limits, within).encode()], [theirs.fileno()])
                    number = _answer(line)
                except OSError:
                    # A late answer would be taken for the answer to another request.
                    self._drop()
                    raise
            return Child(MessageChannel(ours.dup()), lambda: self._end(line, number), scratch, limits)

    def _begun(self) -> socket.socket:
        if self._program is not None and self._program.poll() is not None:
            self._drop()
        if self._line is None:
            environment = _environment(sealed=self._sealed) | self._fixed
            self._program, self._line = _program(self._work, environment=environment)
            self._line.settimeout(LOAD_S)
        return self._line

    def _drop(self) -> None:
        if self._program is not None and self._line is not None:
            self._line.close()
            self._program.kill()
            self._program.wait()
        self._program = self._line = None

    def _end(self, line: socket.socket, number: int) -> int | None:
        # If the fork server has gone, its processes end by themselves.
        with self._lock, suppress(OSError):
            line.sendall(str(number).encode())
            return _answer(line)
        return None


def _answer(line: socket.socket) -> int:
    if len(answer := line.recv(8)) < 8:
        raise OSError(0, "the program that others are forked from has ended")
    return int.from_bytes(answer, "big", signed=True)


def _environment(*, sealed: bool) -> dict[str, str]:
    """The environment variables that a process gets."""
    kept = {k: v for k, v in os.environ.items() if k in KEPT_VARIABLES or k.startswith(KEPT_BEGINNINGS)}
    # A film's matrices are small: further threads of BLAS cost a fifth of loading NumPy, and nothing uses them.
    return kept | {"OPENBLAS_NUM_THREADS": "1"} if sealed else dict(os.environ)


def _scratch_folder(folder: Path | str | None) -> str:
    """A new folder for the temporary files of a process, in `folder` or the system's."""
    # The fork server may have another current folder.
    return os.path.abspath(tempfile.mkdtemp(prefix="moireid-", dir=folder))


def _beginning(scratch: str, limits: ProcessLimits, within: Reach | None) -> str:
    """What a process needs to limit and to seal itself, as JSON; it works in this program's current folder."""
    order = {"folder": scratch, "limits": asdict(limits), "reach": None if within is None else asdict(within)}
    # The current folder may have been removed.
    with suppress(OSError):
        order["current"] = os.getcwd()
    return json.dumps(order)


def _program(*arguments: str, environment: dict[str, str]) -> tuple[subprocess.Popen[bytes], socket.socket]:
    """A program and a connection to it; it imports as this process does, but never from the current folder."""
    kept = {name: word for name, word in environment.items() if name not in NOT_HANDED_ON}
    path = os.pathsep.join(name for name in sys.path if name)
    ours, theirs = socket.socketpair()
    with theirs:
        try:
            program = subprocess.Popen(
                # -P: do not import from the current folder.
                [sys.executable, "-P", "-m", "moireid.sandbox.child", str(theirs.fileno()), *arguments],
                pass_fds=[theirs.fileno()],
                # Decoders print messages; those about an untrusted film must not reach our own streams.
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=kept | {"PYTHONPATH": path},
            )
        except OSError:
            ours.close()
            raise
    return program, ours
