"""Numba's compiler with types, and with a cache on disk that survives changed and renamed files.

For a type checker, a compiled function has the type of the plain one.

Numba keeps compiled functions next to their source, and looks for changes in that one file.  But these functions are
compiled with those of other files inside; and what is kept names the modules of its arguments' types, so that it cannot
be read once a module is renamed.  `KernelCache` covers both: what was compiled of other sources is compiled anew.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
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
        import numba
        from numba import prange
        from numba.core.caching import FunctionCache
    except ImportError as missing:  # pragma: no cover
        raise missing_extra("simulating", "numba", "simulate") from missing

    class KernelCache(FunctionCache):
        """Numba's cache of one function; entries of other sources are not used, and unreadable ones are dropped."""

        def load_overload(self, sig, target_context):
            """The compiled function of that signature, None where it must be compiled."""
            try:
                return super().load_overload(sig, target_context)
            except (ImportError, AttributeError):
                self.flush()
                return None

        def _index_key(self, sig, codegen):
            return (*super()._index_key(sig, codegen), kernel_digest())

    def njit(*, cache=False, **options):
        """As `numba.njit`, for numbers that divide as NumPy's do; cache: keep the result in a `KernelCache`."""

        def compiled(function):
            kernel = numba.njit(error_model="numpy", **options)(function)
            if cache:
                kernel._cache = KernelCache(function)
            return kernel

        return compiled


@cache
def kernel_digest() -> str:
    """Digest of all files of this package that hold compiled functions."""
    texts = [path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py"))]
    return hashlib.sha256(b"".join(text for text in texts if b"@njit(" in text)).hexdigest()
