"""Landlock: a process states which files it needs, and the kernel refuses all others to it.

Each right is asked for only where the kernel knows it, so that an older kernel protects as much as it can.
Source: the kernel's documentation "Landlock: unprivileged access control" and landlock(7); the calls have the same
    numbers on every processor.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterable

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_VERSION_FLAG, _PATH_BENEATH = 1, 1

EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = 1 << 0, 1 << 1, 1 << 2, 1 << 3
REMOVE_DIR, REMOVE_FILE, MAKE_DIR, MAKE_REG = 1 << 4, 1 << 5, 1 << 7, 1 << 8
REFER, TRUNCATE = 1 << 13, 1 << 14
#: The rights that each version of the interface added: to files (bits 0 to 12, then one each), to TCP ports (bind and
#: connect), and what is closed to other processes (abstract Unix sockets, signals).
_FILE_RIGHTS = {1: (1 << 13) - 1, 2: REFER, 3: TRUNCATE, 5: 1 << 15}
_PORT_RIGHTS = {4: 0b11}
_SCOPES = {6: 0b11}


class _Rules(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("ports", ctypes.c_uint64), ("scopes", ctypes.c_uint64))


class _PathRule(ctypes.Structure):
    # The kernel's structure has no padding at its end.
    _pack_ = 1
    _fields_ = (("rights", ctypes.c_uint64), ("folder", ctypes.c_int32))


def version() -> int:
    """The version of the kernel's interface; 0 where it has none, or where it is switched off."""
    try:
        return _call(_CREATE_RULESET, None, 0, _VERSION_FLAG)
    except OSError:
        return 0


def restrict(files: Iterable[tuple[str, int]]) -> None:
    """Close all TCP ports, and all files but these, to this thread; it cannot be undone.

    Parameters: files: paths with their rights, such as `READ_FILE | READ_DIR`; one that has gone meanwhile stays
        closed; a right that the kernel does not know is not closed to anybody, and is passed over.
    Raises: OSError where the kernel refuses, and where `version()` is 0.
    """
    known = version()
    file_rights = _of(_FILE_RIGHTS, known)
    rules = _Rules(file_rights, _of(_PORT_RIGHTS, known), _of(_SCOPES, known))
    ruleset = _call(_CREATE_RULESET, ctypes.byref(rules), ctypes.sizeof(rules), 0)
    try:
        for path, rights in files:
            try:
                place = os.open(path, os.O_PATH | os.O_CLOEXEC)
            except FileNotFoundError:
                continue
            try:
                to_path = _PathRule(rights & file_rights, place)
                _call(_ADD_RULE, ruleset, _PATH_BENEATH, ctypes.byref(to_path), 0)
            finally:
                os.close(place)
        _call(_RESTRICT_SELF, ruleset, 0)
    finally:
        os.close(ruleset)


def _of(by_version: dict[int, int], known: int) -> int:
    """All bits that a kernel of that version knows."""
    return sum(bits for since, bits in by_version.items() if since <= known)


def _call(number: int, *arguments: object) -> int:
    """Make a system call.  Raises: OSError."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    done = int(libc.syscall(ctypes.c_long(number), *(ctypes.c_long(a) if isinstance(a, int) else a for a in arguments)))
    if done < 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))
    return done
