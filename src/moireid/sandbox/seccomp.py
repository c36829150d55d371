"""Seccomp: a filter of the system calls that a process may make, built by libseccomp.

The library knows the numbers of the calls on each processor.
Source: libseccomp's manual pages seccomp_init(3), seccomp_rule_add(3), seccomp_attr_set(3) and seccomp_load(3).
"""

from __future__ import annotations

import ctypes
import os
from functools import cache
from types import TracebackType

ALLOW = 0x7FFF0000
#: Of comparisons of an argument: equal, and equal in the bits of a mask.
EQ, MASKED_EQ = 4, 7
#: Attributes: what becomes of a call by the numbers of another processor (x32, i386); load the filter into all threads.
_OTHER_NUMBERS, _ALL_THREADS = 2, 4
#: End the whole process: if only the thread that called ends, the others wait for it.
_END_PROCESS = 0x80000000
_NO_SUCH_CALL = -1


def refuse(error: int) -> int:
    """The action by which a call fails with that number of errno."""
    return 0x00050000 | error


class Argument(ctypes.Structure):
    """A condition on the argument `place` of a call: compared with `first`, or under the mask `first` with `second`."""

    _fields_ = (
        ("place", ctypes.c_uint),
        ("comparison", ctypes.c_int),
        ("first", ctypes.c_uint64),
        ("second", ctypes.c_uint64),
    )


class Filter:
    """A filter as it is built, from `with` to `load`.

    Parameters: default: the action for calls without a rule.
    Raises: OSError where the system has no libseccomp, or where it fails.
    """

    def __init__(self, default: int) -> None:
        self._library = library()
        self._context = ctypes.c_void_p(self._library.seccomp_init(ctypes.c_uint32(default)))
        if not self._context:
            raise OSError("libseccomp made no filter")

    def __enter__(self) -> Filter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._library.seccomp_release(self._context)

    def add(self, action: int, name: str, *conditions: Argument) -> None:
        """Add a rule for a call by its name; all conditions must hold.  Raises: OSError; LookupError for a call that
        this library or processor does not have.
        """
        number = self._library.seccomp_syscall_resolve_name(name.encode())
        if number == _NO_SUCH_CALL:
            raise LookupError(name)
        several = (Argument * len(conditions))(*conditions)
        _checked(
            self._library.seccomp_rule_add_array(
                self._context, ctypes.c_uint32(action), number, len(conditions), several
            )
        )

    def load(self) -> None:
        """Put the filter in force for all threads of this process; it cannot be undone.  Raises: OSError."""
        for attribute, value in ((_ALL_THREADS, 1), (_OTHER_NUMBERS, _END_PROCESS)):
            _checked(self._library.seccomp_attr_set(self._context, attribute, ctypes.c_uint32(value)))
        _checked(self._library.seccomp_load(self._context))


@cache
def library() -> ctypes.CDLL:
    """libseccomp.  Raises: OSError where it is absent."""
    found = ctypes.CDLL("libseccomp.so.2")
    found.seccomp_init.restype = ctypes.c_void_p
    return found


def _checked(done: int) -> None:
    if done < 0:
        raise OSError(-done, os.strerror(-done))
