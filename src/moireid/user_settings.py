"""Where a user's data is, and what a user may have meant.

Convention: a user may have no home folder, as in a container: then each path must be given.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

from moireid.errors import SpecError


def data_folder() -> Path | None:
    """Where moireid keeps this user's data, which need not exist; None for a user without a home folder."""
    from platformdirs import user_data_path

    try:
        found = user_data_path("moireid", appauthor=False)
    except RuntimeError:
        return None
    # Older versions of platformdirs return what begins with "~".
    return found if found.is_absolute() else None


def expanded(path: str) -> Path:
    """The path with `~` replaced.  Raises: SpecError where that user has no home folder."""
    try:
        return Path(path).expanduser()
    except RuntimeError as error:
        raise SpecError(f"{path!r} is in a home folder, and that user has none; give the whole path") from error


def nearest(word: str, known: Iterable[str]) -> str:
    """Such as ` (did you mean title?)`; empty where no known word is near."""
    found = difflib.get_close_matches(word.lower(), known, n=1)
    return f" (did you mean {found[0]}?)" if found else ""
