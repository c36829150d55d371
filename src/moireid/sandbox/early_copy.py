"""A copy of a program that is made before the program knows anything private.

A copy by fork begins at once, as all is loaded; but it has in memory what the program has there: passwords among the
arguments and in the environment, say.  So the program starts twice:

1. `restart` writes arguments and environment into a file in memory, and starts the program anew in this same process
   (execve), with neither of them.
2. The program loads its work and makes the copy (`EarlyCopy`).
3. `resume` reads what `restart` wrote.

The first start loads nothing, so it costs some 10 ms.  Only on Linux.
"""

from __future__ import annotations

import marshal
import os
import sys
from typing import TYPE_CHECKING

from moireid.sandbox.start_state import import_path, kept_environment

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from moireid.sandbox.child import Talk
    from moireid.sandbox.file_access import Reach
    from moireid.sandbox.process import Child
    from moireid.sandbox.seal import ProcessLimits


def restart(module: str) -> None:
    """Start this program anew, as `python -m MODULE HANDLE`, with no argument and no variable of its own.

    Returns where the system cannot do that, Python is not to look at the environment, or its flags are not known;
    nothing has changed then.
    """
    if sys.platform != "linux" or not sys.executable or getattr(sys, "frozen", False) or sys.flags.ignore_environment:
        return
    flags = sys.orig_argv[1 : len(sys.orig_argv) - len(sys.argv)]
    if flags[-1:] in (["-m"], ["-c"]):
        flags.pop()
    elif sys.orig_argv[len(flags) + 1] != sys.argv[0]:
        # No script; -m or -c is in one word with other flags, or with what it starts.
        return
    import fcntl
    import signal

    variables = kept_environment(dict(os.environ)) | {"PYTHONPATH": os.pathsep.join(import_path())}
    try:
        with os.fdopen(os.memfd_create("arguments"), "wb") as file:
            file.write(marshal.dumps((sys.argv, dict(os.environb))))
            file.flush()
            # Unlike os.dup, the copy stays open in the second start.
            handle = fcntl.fcntl(file, fcntl.F_DUPFD, 3)
        # -P: do not import from the current folder.
        command = [sys.executable, *flags, "-P", "-m", module, str(handle)]
        for stream in filter(None, (sys.stdout, sys.stderr)):
            stream.flush()
        # An interrupt waits until the second start can end by it without a traceback.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        os.execve(sys.executable, command, variables)
    except OSError:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def resume(handle: int) -> None:
    """Give this program the arguments and the environment that `restart` wrote."""
    with os.fdopen(handle, "rb") as file:
        file.seek(0)
        sys.argv[:], variables = marshal.load(file)
    os.environb.clear()
    os.environb.update(variables)


class EarlyCopy:
    """A copy of this program that waits for its limits and its reach.

    Attributes
    ----------
    waiting : EarlyCopy or None
        The one that this program has made and not begun yet.
    """

    waiting: EarlyCopy | None = None

    def __init__(self, work: Callable[[Talk], None]) -> None:
        """Parameters: work: what the copy does.  Raises: OSError if there can be no copy."""
        import gc
        import socket

        from moireid.sandbox.child import run_copy

        self._line, theirs = socket.socketpair()
        with theirs:
            # What the garbage collector visits is copied page by page.
            gc.freeze()
            self._number = os.fork()
            if not self._number:
                try:
                    run_copy(theirs.fileno(), work)
                finally:
                    os._exit(1)

    def begin(self, limits: ProcessLimits, folder: Path | str | None = None, *, within: Reach | None) -> Child:
        """The process within its limits; folder and within as in `process.start`.

        Raises: ProcessEnd if it has gone.
        """
        from moireid.sandbox.line import MessageChannel
        from moireid.sandbox.process import LOAD_S, Child, beginning, scratch_folder

        scratch = scratch_folder(folder)
        child = Child(MessageChannel(self._line), self._end, scratch, limits)
        child.send(beginning(scratch, limits, within), LOAD_S)
        return child

    def _end(self) -> int:
        import signal

        os.kill(self._number, signal.SIGKILL)
        return os.waitstatus_to_exitcode(os.waitpid(self._number, 0)[1])
