"""Memory that was freed, given back to the system.

Judging a chapter takes 80 MB for a moment.  The C library keeps what is freed for later, in pieces between what is
still used and once more for each thread, so a long film would hold what all its chapters once took.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any


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
