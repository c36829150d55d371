"""Numba's compiler, with types: for a type checker, a compiled function has the type of the plain one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from moireid.extras import missing_extra

__all__ = ["njit", "prange"]

if TYPE_CHECKING:
    Function = TypeVar("Function", bound=Callable[..., Any])
    prange = range

    def njit(**options: Any) -> Callable[[Function], Function]:
        """What `numba.njit` is, called with options."""

else:
    try:
        from numba import njit, prange
    except ImportError as missing:  # pragma: no cover
        raise missing_extra("simulating", "numba", "simulate") from missing
