"""The process that does jobs within limits: `python -m moireid.archive.child FD MEMORY_MB`.

It is a plain program and no process of `multiprocessing`, as Dask's workers are daemons, which that package lets have
no children.  Messages, pickled: (payload, path of the film or None) in, where payload is the pickled (work, job);
("begun",) once the work is loaded, then ("done", result) or ("raised", kind, words) out.

Convention: one thread.  A worker is one processor's work, so that as many workers as processors are as fast as can be.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
import time
from contextlib import suppress
from multiprocessing.connection import Connection

#: A child that nobody has asked anything for so long ends, and another is started when one is needed.
IDLE_S = 300.0
#: Set before the packages are loaded that read them.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)


def main() -> None:
    """Do jobs until the other end is closed."""
    asked = Connection(int(sys.argv[1]))
    # An interrupt reaches every process of the terminal; the one that started this decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with, args=(os.getppid(),), daemon=True).start()
    import cv2

    cv2.setNumThreads(1)
    _limit_memory(int(sys.argv[2]))
    # The other end closes when the worker is done with this process, or is gone.
    with suppress(EOFError, OSError):
        while asked.poll(IDLE_S):
            asked.send_bytes(_outcome(asked, *asked.recv()))


def _outcome(asked: Connection, payload: bytes, film: str | None) -> bytes:
    """The answer to one message, pickled."""
    try:
        work, job = pickle.loads(payload)
        asked.send(("begun",))
        return pickle.dumps(("done", work(job) if film is None else work(job, film)))
    except MemoryError:
        return pickle.dumps(("raised", "memory", ""))
    # A fault of the work is told with its job, and the next job is done all the same.
    except Exception as error:  # noqa: BLE001
        import cv2

        if isinstance(error, cv2.error) and error.code == cv2.Error.StsNoMem:
            return pickle.dumps(("raised", "memory", ""))
        return pickle.dumps(("raised", type(error).__name__, " ".join(str(error).split())[:300]))


def _limit_memory(megabytes: int) -> None:
    """Let this process have so much private memory; where the system holds nobody to it (not Linux), nothing is done.

    RLIMIT_DATA counts what is asked for and can be written, so a bomb fails at its own call before it fills the
    machine; RLIMIT_AS would count the code of shared libraries and the room that threads merely reserve.
    """
    if sys.platform == "linux":
        import resource

        # A lower limit of the system's own stays.
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        most = megabytes * 1_000_000
        resource.setrlimit(resource.RLIMIT_DATA, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _leave_with(parent: int) -> None:
    """End when the worker that started this process has gone: nobody would hear the answer."""
    while os.getppid() == parent:
        time.sleep(0.25)
    os._exit(1)


if __name__ == "__main__":
    main()
