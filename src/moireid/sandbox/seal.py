"""How a process limits its resources, and how it seals itself before it reads an untrusted file.

Limits (setrlimit): memory, processor time, and sizes of files.
The seal has three parts, each used where the system has it: no new privileges (prctl), a filter of system calls
(seccomp), and a list of allowed paths (Landlock).  All three are of Linux; other systems have none.  The process
reports which parts hold, and none is assumed to hold.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from moireid.sandbox import landlock, seccomp
from moireid.sandbox.calls import filter_calls
from moireid.sandbox.file_access import NULL, Reach, open_parts, program_folders


@dataclass(frozen=True)
class ProcessLimits:
    """Limits of a process; None: no limit.

    memory_bytes: private memory beyond that at its start; cpu_s: processor time of all its threads; file_bytes: size of
    one file that it writes; open_files: descriptors that it may have at once; answer_bytes: size of one answer.  Its
    parent reads that as JSON, which takes up to thirty times as much memory; a report of an hour of film is much
    smaller.
    """

    memory_bytes: int
    cpu_s: int | None = None
    file_bytes: int | None = None
    answer_bytes: int = 4 << 20
    open_files: int | None = None


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
    if limits.open_files is not None:
        _lower(resource.RLIMIT_NOFILE, limits.open_files)
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


#: The parts of the seal, in words for people; and what a process could do where a part does not hold.
PRIVILEGES, CALLS, FILES = "no_new_privileges", "calls", "files"
MEANS = {
    PRIVILEGES: "gains no privileges",
    CALLS: "reaches no network, no program and no other process",
    FILES: "opens no file but its film and the program's own",
}
LACKING = {
    PRIVILEGES: "could gain privileges",
    CALLS: "could reach the network, programs and other processes",
    FILES: "could open this user's other files, private keys among them",
}


def load_means() -> None:
    """Load libseccomp, which a sealed process cannot; a process that is forked for many films loads it once."""
    if sys.platform == "linux":
        # Its absence is found when it is called for.
        with suppress(OSError):
            seccomp.library()


def seal(reach: Reach, scratch: str) -> tuple[str, ...]:
    """Close to this process all that its work does not need; this cannot be undone.

    Parameters: scratch: its folder for temporary files.
    Returns: the parts of the seal that hold now, as in `MEANS`; empty on systems without any.
    """
    if sys.platform != "linux":
        return ()
    load_means()
    held = [PRIVILEGES] if _no_new_privileges() else []
    # A thread that runs already would keep its own reach.
    if len(os.listdir("/proc/self/task")) == 1 and _close_files(reach, scratch):
        held.append(FILES)
    try:
        filter_calls()
        held.append(CALLS)
    except OSError:
        # No libseccomp here, or a kernel or container that allows no filter.  Then Landlock alone protects the film.
        # It forbids to truncate a file that may only be read since version 3, Linux 6.2 (its "Truncating files").
        if FILES in held and landlock.version() < 3:
            held.remove(FILES)
    return tuple(name for name in MEANS if name in held)


def missing(held: tuple[str, ...]) -> str | None:
    """What a process could do apart from reading its film, in words; None where no part of the seal is missing."""
    lacking = [words for name, words in LACKING.items() if name not in held]
    if not lacking:
        return None
    return f"{', '.join(lacking[:-1])} and {lacking[-1]}" if lacking[1:] else lacking[0]


def _no_new_privileges() -> bool:
    """Source: prctl(2), PR_SET_NO_NEW_PRIVS; libseccomp and Landlock ask for it, too."""
    import ctypes

    return bool(ctypes.CDLL(None).prctl(38, 1, 0, 0, 0) == 0)


def _close_files(reach: Reach, scratch: str) -> bool:
    """Close all files but those in reach; returns whether the kernel does that."""
    if not landlock.version():
        return False
    of_file = landlock.READ_FILE | landlock.WRITE_FILE | landlock.TRUNCATE
    look = landlock.READ_FILE | landlock.READ_DIR
    change = landlock.MAKE_REG | landlock.MAKE_DIR | landlock.REMOVE_FILE | landlock.REMOVE_DIR | landlock.REFER
    own = [part for root in program_folders(reach.imports) for part in open_parts(root, reach.keep_out)]
    # The environment of other processes is a file, too.
    closed = (*reach.keep_out, "/proc")
    # A file that is named is meant, wherever it is.
    given = [part for root in reach.read for part in ([root] if os.path.isfile(root) else open_parts(root, closed))]
    rules = [(part, look) for part in (*own, *given)]
    rules += [(path, of_file | look | change) for path in (*reach.write, scratch)]
    rules.append((NULL, landlock.READ_FILE | landlock.WRITE_FILE))
    # What is absent cannot be opened anyway; the kernel refuses rights of folders to what is none.
    there = [(path, rights) for path, rights in rules if os.path.exists(path)]
    landlock.restrict([(path, rights if os.path.isdir(path) else rights & of_file) for path, rights in there])
    return True
