"""Memory that was freed, given back to the system.

Judging a chapter takes 80 MB for a moment.  The C library keeps what is freed for later, in pieces between what is
still used and once more for each thread, so a long film would hold what all its chapters once took.

Judging in a thread beside the frames, without holding them up.

Python lets one thread run at a time, and one that computes gives way after `sys.getswitchinterval()`, by default 5 ms.
A frame's `push` leaves the interpreter to OpenCV a dozen times, and would wait so long at each return.  While
something is judged beside it, threads change places sooner.
"""

from __future__ import annotations

import ctypes
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from functools import cache
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

Found = TypeVar("Found")
#: Of `sys.setswitchinterval` meanwhile, s.
SWITCH_S = 2e-4

_lock = threading.Lock()
_judging, _before_s = 0, 0.0


class GivingWay(Executor):
    """Hands work to another executor; the work gives way to the caller's threads.

    Convention: the switch interval is the whole process's; the last work to end puts it back.
    """

    def __init__(self, other: Executor) -> None:
        self._other = other

    def submit(self, fn: Callable[..., Found], /, *args: Any, **kwargs: Any) -> Future[Found]:
        """Begin some work, as `Executor.submit`."""
        return self._other.submit(_done, fn, args, kwargs)


def _done(work: Callable[..., Found], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Found:
    # The matrices are small: a second thread of BLAS would take the processor that the frames need.
    with _switching_soon(), threadpool_limits(limits=1, user_api="blas"):
        return work(*args, **kwargs)


@contextmanager
def _switching_soon() -> Iterator[None]:
    global _judging, _before_s
    with _lock:
        if not _judging:
            _before_s = sys.getswitchinterval()
            sys.setswitchinterval(min(SWITCH_S, _before_s))
        _judging += 1
    try:
        yield
    finally:
        with _lock:
            _judging -= 1
            if not _judging:
                sys.setswitchinterval(_before_s)


def give_back() -> None:
    """Give freed memory back to the system, where the C library can: glibc's `malloc_trim`; takes milliseconds."""
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], Any] | None:
    try:
        found = ctypes.CDLL(None).malloc_trim
    # Windows has no library of that kind, and other C libraries no such function.
    except (AttributeError, TypeError, OSError):
        return None
    found.argtypes = [ctypes.c_size_t]
    trim: Callable[[int], Any] = found
    return trim
