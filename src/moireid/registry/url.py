"""The registry's URL: the default one, reading one, and showing one without its password."""

from __future__ import annotations

from pathlib import Path

from platformdirs import user_data_path
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from moireid.errors import RegistryError


def default_url() -> str:
    """Tell where the registry lies unless told otherwise.

    Returns
    -------
    str
        The SQLAlchemy URL of `registry.sqlite3` in the user's data folder; nothing is made.
    """
    path = user_data_path("moireid", appauthor=False) / "registry.sqlite3"
    return URL.create("sqlite", database=str(path)).render_as_string(hide_password=False)


def read_url(text: str) -> URL:
    """The URL that `text` writes; an SQLite file's path is made absolute, so that a later chdir moves nothing.

    Raises: RegistryError where it is no URL (a bare path is none), or an SQLite URL that names no file.
    """
    try:
        text.encode()
        url = make_url(text)
    except (ArgumentError, ValueError) as error:
        # An address with "@" may contain a password, which must not reach a log through a message.
        what = "the registry's URL" if "@" in text else f"registry {text[:200]!r}"
        raise RegistryError(f"{what} is no database URL; give one such as sqlite:///people.sqlite3") from error
    if url.get_backend_name() != "sqlite":
        return url
    database = url.database or ""
    if database in ("", ":memory:") or database.startswith("file:"):
        # A registry in memory would be lost when the command ends, although the command had said "enrolled".
        raise RegistryError(
            f"registry {show_url(url)!r} names no file of its own; give one such as sqlite:///people.sqlite3, "
            "with three slashes before the path"
        )
    path = str(Path(database).absolute())
    try:
        path.encode()
    except UnicodeEncodeError as error:
        raise RegistryError(f"registry path {path!r} is not Unicode text; give a path that is") from error
    return url.set(database=path)


def sqlite_file(url: URL) -> Path | None:
    """The file of an SQLite URL that `read_url` has read; None for other databases."""
    return Path(url.database) if url.get_backend_name() == "sqlite" and url.database else None


def own_file(url: str | None) -> Path | None:
    """The file of the registry at an SQLAlchemy URL, or at `default_url()` for None; None where it is no file.

    Raises: RegistryError as `read_url`.
    """
    return sqlite_file(read_url(default_url() if url is None else url))


def show_url(url: URL) -> str:
    """The URL for messages: without its password, and without its options, which may hold another."""
    return url.set(query={}).render_as_string(hide_password=True)
