"""What a process may take, and how the system holds it to that."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ProcessLimits:
    """What a process may take; None: no limit.

    memory_bytes: private memory beside what the process holds as it begins; cpu_s: processor time of all its threads;
    file_bytes: of one file that it writes; answer_bytes: of one answer, which its starter holds in memory.
    """

    memory_bytes: int
    cpu_s: int | None = None
    file_bytes: int | None = None
    answer_bytes: int = 32 << 20


def confine(limits: ProcessLimits) -> None:
    """Hold this process to its limits; a lower limit of the system's own stays.

    Private memory is what counts (RLIMIT_DATA, on Linux alone): it is what is asked for and can be written, so that a
    bomb fails at its own call.  Address space also counts shared libraries and what threads reserve and never use.
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
