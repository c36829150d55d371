"""Mitsuba's module, in the variant that every machine runs.

Its compiled variant needs the machine's own libLLVM.  An old one (Debian's 14 and 15 were tried) does not refuse the
code but aborts the process, so it is taken only where the user names a library that serves.

Convention: variants end in `_rgb`, because `mitsuba` uses the three colours as three channels of figures.
Source: Mitsuba 3.9.1 and Dr.Jit, which reads the library's path from DRJIT_LIBLLVM_PATH.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from moireid.extras import missing_extra

LIBRARY_VARIABLE = "DRJIT_LIBLLVM_PATH"


@contextmanager
def loaded_mitsuba() -> Iterator[Any]:
    """Mitsuba's module with a variant set; the caller's own is set again afterwards.

    Convention: module docstring.
    Raises: MissingExtraError without mitsuba.
    Source: Mitsuba keeps one variant for each process.
    """
    try:
        import mitsuba as mi
    except ImportError as missing:
        raise missing_extra("this renderer", "mitsuba", "simulate") from missing
    before = mi.variant()
    mi.set_variant("llvm_ad_rgb" if os.environ.get(LIBRARY_VARIABLE) else "scalar_rgb")
    # A library must not print by itself, and Mitsuba would print on stdout.
    loudness = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)
    try:
        yield mi
    finally:
        mi.set_log_level(loudness)
        if before is not None:
            mi.set_variant(before)
