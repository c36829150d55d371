"""Limits of a process, and how the system enforces them."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ProcessLimits:
    """Limits of a process; None: no limit.

    memory_bytes: private memory beyond that at its start; cpu_s: processor time of all its threads; file_bytes: size of
    one file that it writes; answer_bytes: size of one answer.  Its parent reads that as JSON, which takes up to thirty
    times as much memory; a report of an hour of film is much smaller.
    """

    memory_bytes: int
    cpu_s: int | None = None
    file_bytes: int | None = None
    answer_bytes: int = 4 << 20


def confine(limits: ProcessLimits) -> None:
    """Set the limits of this process; a lower limit of the system stays.

    Private memory is limited (RLIMIT_DATA, on Linux only), so that a request for too much memory fails at its own call.
    A limit of address space would also count shared libraries and unused reservations of threads.
    """
    import resource

    _lower(resource.RLIMIT_CORE, 0)
    if limits.file_bytes is not None:
        _lower(resource.RLIMIT_FSIZE, limits.file_bytes)
    if limits.cpu_s is not None:
        _lower(resource.RLIMIT_CPU, limits.cpu_s)
    if sys.platform == "linux":
        _lower(resource.RLIMIT_DATA, limits.memory_bytes + _held_bytes())


def _lower(which: int, most: int) -> None:
    import resource

    hard = resource.getrlimit(which)[1]
    most = most if hard == resource.RLIM_INFINITY else min(most, hard)
    resource.setrlimit(which, (most, most))


def _held_bytes() -> int:
    """Private memory that this process has."""
    import resource

    return int(Path("/proc/self/statm").read_text().split()[5]) * resource.getpagesize()
