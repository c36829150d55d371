"""Judging in a background thread that does not delay the frames, and returning freed memory to the system.

Python runs one thread at a time, and a thread that computes gives way only after `sys.getswitchinterval()`, by default
5 ms.  For each frame, `push` calls OpenCV a dozen times outside the interpreter, and at each return it would wait that
long.  So the interval is shorter while something is judged in the background.

Judging a chapter takes 80 MB for a moment.  The C library keeps freed memory for later use, in pieces between memory
that is still in use and separately for each thread.  So a long film would keep the memory of all its chapters.
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
#: The interval for `sys.setswitchinterval` while something is judged in the background, s.
SWITCH_S = 2e-4

_lock = threading.Lock()
_judging, _before_s = 0, 0.0


class BackgroundExecutor(Executor):
    """Passes work on to another executor, and lets the caller's threads interrupt that work soon.

    Convention: the switch interval is that of the whole process; the last work to end restores it.
    """

    def __init__(self, other: Executor) -> None:
        self._other = other

    def submit(self, fn: Callable[..., Found], /, *args: Any, **kwargs: Any) -> Future[Found]:
        """Start a call, as `Executor.submit` does."""
        return self._other.submit(_call, fn, args, kwargs)


def _call(work: Callable[..., Found], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Found:
    # The matrices are small: a second BLAS thread would take the processor that the frames need.
    with _short_switch_interval(), threadpool_limits(limits=1, user_api="blas"):
        return work(*args, **kwargs)


@contextmanager
def _short_switch_interval() -> Iterator[None]:
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


def return_freed_memory() -> None:
    """Return freed memory to the system by glibc's `malloc_trim`, if the C library has it; takes milliseconds."""
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], Any] | None:
    try:
        found = ctypes.CDLL(None).malloc_trim
    # Windows has no such library, and other C libraries have no such function.
    except (AttributeError, TypeError, OSError):
        return None
    found.argtypes = [ctypes.c_size_t]
    trim: Callable[[int], Any] = found
    return trim
