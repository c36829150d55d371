"""The process within limits: `python -m moireid.sandbox.child HANDLE WORK [BEGIN]`.

WORK is `module:function`, after further modules to load if there are any, separated by commas; the function is called
with a `Talk`.  With BEGIN (JSON: limits, a folder for temporary
files, and what may be opened) this process does the work.  Without it the work is loaded, and a process is forked for
each request.  Such a process begins within some milliseconds, and has no state of the others or of the requesting
program.
Where BEGIN says what may be opened, the process seals itself (`seal.py`) after the work is loaded, and reports which
parts of the seal hold.
"""

from __future__ import annotations

import gc
import json
import os
import signal
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from importlib import import_module
from multiprocessing.connection import Connection
from pkgutil import resolve_name
from typing import Any

from moireid.errors import MoireIdError
from moireid.sandbox.file_access import Reach
from moireid.sandbox.seal import ProcessLimits, confine, load_means, seal

#: Least time between two reports of progress, s.
PROGRESS_S = 0.1


class Talk:
    """The child's end of the connection to its parent."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe, self._reported_s = pipe, 0.0

    def next(self, idle_s: float | None = None) -> Any:
        """The next message; None at the end, or after `idle_s` without one."""
        try:
            return self._pipe.recv() if self._pipe.poll(idle_s) else None
        except (EOFError, OSError):
            return None

    def send(self, answer: dict[str, Any]) -> None:
        """Send an answer as JSON.  Raises: ValueError, TypeError if that is impossible; OSError without a parent."""
        # A file's name may have bytes that are no UTF-8; no reader of JSON takes what Python makes of them.
        text = json.dumps(answer, allow_nan=False, ensure_ascii=False)
        self._pipe.send_bytes(text.encode(errors="replace"))

    def progress(self, done: int, of: int | None) -> None:
        """Report progress, but not more often than each `PROGRESS_S`."""
        if time.monotonic() - self._reported_s >= PROGRESS_S:
            self._reported_s = time.monotonic()
            self.send({"progress": [done, of]})


def rest(talk: Talk) -> None:
    """Work that sends one message: its starter only wants to know which parts of the seal hold."""
    talk.send({"rest": True})


def main() -> None:
    """Do the work, or fork a process for each request until the other end is closed."""
    # An interrupt reaches every process of a terminal; the parent decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    handle, work = int(sys.argv[1]), sys.argv[2]
    if len(sys.argv) > 3:
        _run(handle, work, sys.argv[3])
    else:
        _fork_for_each(socket.socket(fileno=handle), work)


def _fork_for_each(asked: socket.socket, work: str) -> None:
    """Answer requests: for a handle, fork a process that works at it, and return its number; for such a number, end
    that process and return how it ended.
    """
    _loaded(work)
    load_means()
    # A collection writes to every object that it looks at, and each page written to is in memory twice.
    gc.freeze()
    while True:
        message, handles, _, _ = socket.recv_fds(asked, 1 << 16, 1)
        if not message:
            return
        if not handles:
            os.kill(int(message), signal.SIGKILL)
            answer = os.waitstatus_to_exitcode(os.waitpid(int(message), 0)[1])
        elif not (answer := os.fork()):
            try:
                asked.close()
                _run(handles[0], work, message.decode())
            finally:
                os._exit(1)
        for handle in handles:
            os.close(handle)
        asked.sendall(answer.to_bytes(8, "big", signed=True))


def _run(handle: int, work: str, begin: str) -> None:
    """Do the work within limits, report how it ended, and exit."""
    parent, order, talk = os.getppid(), json.loads(begin), Talk(Connection(handle))
    os.environ["TMPDIR"] = tempfile.tempdir = order["folder"]
    if "current" in order:
        os.chdir(order["current"])
    confine(ProcessLimits(**order["limits"]))
    try:
        act = _loaded(work)
        if order["reach"] is not None:
            # Without other threads: each of them would keep its own reach.
            talk.send({"sealed": seal(Reach(**order["reach"]), order["folder"])})
        threading.Thread(target=_leave_with, args=(parent,), daemon=True).start()
        act(talk)
        ended = ["done", "", True]
    # Any error is reported; this process ends with it, so nothing can be left behind.
    except Exception as error:  # noqa: BLE001
        kind = "memory" if _lacks_memory(error) else type(error).__name__
        ended = [kind, " ".join(str(error).split())[:2000], isinstance(error, MoireIdError)]
    talk.send({"ended": ended})
    # Do not wait for threads of libraries.
    os._exit(0)


def _loaded(work: str) -> Callable[[Talk], None]:
    *before, last = work.split(",")
    for module in before:
        import_module(module)
    found: Callable[[Talk], None] = resolve_name(last)
    return found


def _lacks_memory(error: Exception) -> bool:
    cv2 = sys.modules.get("cv2")
    failed = cv2 is not None and isinstance(error, cv2.error) and error.code == cv2.Error.StsNoMem
    return failed or isinstance(error, MemoryError)


def _leave_with(parent: int) -> None:
    """Make this process end with its parent, as no one would read its answer."""
    while os.getppid() == parent:
        time.sleep(0.25)
    os._exit(1)


if __name__ == "__main__":
    main()
