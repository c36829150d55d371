"""What a user sets once for all commands: a small TOML file in the folder of the user's settings.

Convention: an option of a command comes first, then MOIREID_REGISTRY (for the registry), then this file, then the
default.  The file holds no more than the keys of `KEYS`.  Only its user may read it, as the address of a registry may
hold a password.  A user may have no home folder, as in a container: then there is no file, and each path must be given.
"""

from __future__ import annotations

import difflib
import json
import os
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from moireid.errors import SpecError
from moireid.files import whole_file

#: The environment variable that names the registry.
REGISTRY_VARIABLE = "MOIREID_REGISTRY"
#: Another place for the file.
FILE_VARIABLE = "MOIREID_CONFIG"
#: What can be set, and what it means.
KEYS: dict[str, str] = {
    "registry": "the registry that commands use: a path of an SQLite file, or an SQLAlchemy URL",
    "actor": "who does something, as the registry's log is to name them",
    "lens": "the lens sheet: a label of print-your-badge, or a lens profile (.json)",
    "paper": "a4 or letter",
    "printer-dpi": "the printer's dots per inch",
    "public-url": "the address by which other people reach your studio, for links that you send them",
}


def settings_file() -> Path:
    """The path of the file, which need not exist.  Raises: SpecError for a user without a home folder."""
    if given := os.environ.get(FILE_VARIABLE):
        return Path(given)
    from platformdirs import user_config_path

    if (folder := _found(user_config_path)) is None:
        raise SpecError(f"this user has no home folder for settings; set {FILE_VARIABLE} to the path of a file")
    return folder / "config.toml"


def data_folder() -> Path | None:
    """Where moireid keeps this user's data, which need not exist; None for a user without a home folder."""
    from platformdirs import user_data_path

    return _found(user_data_path)


def _found(folder: Callable[..., Path]) -> Path | None:
    try:
        found = folder("moireid", appauthor=False)
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


def load_settings() -> dict[str, str]:
    """What is set in the file, by key; empty where there is no file.

    Raises
    ------
    SpecError
        If it cannot be read, is no TOML, or holds another key or a value that is neither a text nor a whole number.
    """
    try:
        path = settings_file()
    except SpecError:
        return {}
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except OSError as error:
        raise SpecError(f"{path} cannot be read ({error.strerror}); check its rights") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SpecError(f'{path} is no TOML ({error}); a line of it is such as paper = "a4"') from error
    for key, value in found.items():
        check_key(key, f"{path} has")
        if isinstance(value, bool) or not isinstance(value, str | int):
            raise SpecError(f"{path}: {key} is neither a text nor a whole number; correct it, or take it out")
    return {key: str(value) for key, value in found.items()}


def save_settings(settings: Mapping[str, str]) -> Path:
    """Write the file anew, whole or not at all, for its user alone.  Returns: its path."""
    path = settings_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    # A text of JSON is one of TOML, except that TOML has no bare DEL.
    lines = [f"{key} = {json.dumps(settings[key], ensure_ascii=False)}" for key in KEYS if key in settings]
    with whole_file(path, private=True) as temporary:
        temporary.write_text("".join(f"{line}\n" for line in lines).replace("\x7f", "\\u007F"), encoding="utf-8")
    return path


def check_key(key: str, where: str) -> None:
    """Raise SpecError if nothing of that name can be set."""
    if key not in KEYS:
        raise SpecError(f"{where} no such setting as {key[:40]!r}{nearest(key, KEYS)}; there are {', '.join(KEYS)}")


def nearest(word: str, known: Iterable[str]) -> str:
    """Such as ` (did you mean title?)`; empty where no known word is near."""
    found = difflib.get_close_matches(word.lower(), known, n=1)
    return f" (did you mean {found[0]}?)" if found else ""


def chosen_registry() -> str | None:
    """The registry that the environment names, or else the file; None for neither."""
    return os.environ.get(REGISTRY_VARIABLE) or load_settings().get("registry")
