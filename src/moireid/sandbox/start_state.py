"""What a sealed process has from its start: environment variables, and the folders that it imports from.

Loads nothing but what Python has loaded already.
"""

from __future__ import annotations

import os
import sys

#: A sealed process gets these variables of the environment and no other: any other may hold a password or a key.
KEPT_VARIABLES = ("PATH", "HOME", "LANG", "TZ", "TMPDIR", "LD_LIBRARY_PATH", "VIRTUAL_ENV", "MPLCONFIGDIR")
KEPT_BEGINNINGS = ("LC_", "PYTHON", "OPENCV_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_", "VECLIB_")


def kept_environment(environment: dict[str, str]) -> dict[str, str]:
    """The environment variables that a sealed process gets."""
    return {k: v for k, v in environment.items() if k in KEPT_VARIABLES or k.startswith(KEPT_BEGINNINGS)}


def import_path() -> list[str]:
    """The folders that this program imports from, without the folder of its script, or the one that it was started in.

    Python puts that folder first (`sys.path[0]`).  It may hold anything: keys may be next to a script.  It is kept
    where it is a folder of packages, as in a program that was packed with all that it needs.
    """
    started = sys.path[:1] if not sys.flags.safe_path else []
    closed = {os.path.realpath(one) for one in started if one and not _has_packages(one)}
    return [one for one in sys.path if one and os.path.realpath(one) not in closed]


def _has_packages(folder: str) -> bool:
    try:
        return os.path.isfile(folder) or any(name.endswith(".dist-info") for name in os.listdir(folder))
    except OSError:
        return False
