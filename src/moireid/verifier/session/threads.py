"""Judging in a background thread that does not delay the frames, and returning freed memory to the system.

Python runs one thread at a time, and a thread that computes gives way only after `sys.getswitchinterval()`, by default
5 ms.  For each frame, `push` calls OpenCV a dozen times outside the interpreter, and at each return it would wait that
long.  So the interval is shorter in a process that judges a live picture.

Judging a chapter takes 80 MB for a moment.  The C library keeps freed memory for later use, in pieces between memory
that is still in use and separately for each thread.  So a long film would keep the memory of all its chapters.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from typing import Any

from threadpoolctl import threadpool_limits

#: The interval for `sys.setswitchinterval` in such a process, s.
SWITCH_S = 2e-4


@contextmanager
def live_executor() -> Iterator[Executor]:
    """A thread for the verdicts on a live picture; it sets this whole process up for that."""
    sys.setswitchinterval(SWITCH_S)
    # The matrices are small: a second BLAS thread would take the processor that the frames need.
    with threadpool_limits(limits=1, user_api="blas"), ThreadPoolExecutor(1, "verdict") as executor:
        yield executor


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
