"""The registry's URL (the default, reading one, showing one without its password), and connections to its database.

Database errors become our own errors.  SQLite keeps its rollback journal rather than a write-ahead log: the registry
stays one file, which can be copied, put on a network folder or opened read-only.  All our transactions are short, so
two processes take turns; each waits `SQLITE_WAIT_S` for the other before it gives up.
"""

from __future__ import annotations

import os
import re
import sqlite3
import warnings
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from sqlalchemy import Connection, Engine, Row, Select, create_engine, event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, SAWarning, SQLAlchemyError

from moireid.errors import RegistryError
from moireid.extras import missing_extra
from moireid.user_settings import data_folder, expanded

#: How a URL begins, or what was meant as one; a single letter is a drive of Windows.
URL_LIKE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:|[^/]*://|[^/\\]*:[^/\\]*@|$")


def default_url() -> str:
    """The registry that is used if none is given.

    Returns
    -------
    str
        That of MOIREID_REGISTRY, or else the SQLAlchemy URL of `registry.sqlite3` in
        the user's data folder; nothing is made.

    Raises
    ------
    RegistryError
        If none is named, and the user has no home folder.
    """
    if chosen := os.environ.get("MOIREID_REGISTRY"):
        return chosen
    if (folder := data_folder()) is None:
        raise RegistryError("this user has no home folder for a registry; give registry=, or set MOIREID_REGISTRY")
    return URL.create("sqlite", database=str(folder / "registry.sqlite3")).render_as_string(hide_password=False)


def read_url(text: str) -> URL:
    """The URL that `text` writes; an SQLite file's path is made absolute, so that a later chdir moves nothing.

    Convention: a text without a scheme is the path of an SQLite file; postgres:// is another name of postgresql://.
    Raises: RegistryError if it is no URL and no path, an SQLite URL that names no file, or a URL of which it is not
    certain where a password in it ends.
    """
    is_url = URL_LIKE.match(text)
    if is_url and not text.startswith("sqlite:") and _is_ambiguous(text.partition("://")[2]):
        raise RegistryError(
            "the registry's URL can be read in more than one way; percent-encode the password (@ as %40, / as %2F, "
            "% as %25, # as %23, ? as %3F), and any @ after the host"
        )
    try:
        text.encode()
        if is_url:
            url = make_url(re.sub(r"^postgres(?=[:+])", "postgresql", text))
        else:
            url = URL.create("sqlite", database=str(expanded(text)))
    except (ArgumentError, ValueError):
        # The text may contain a password, as may the error's: neither must reach a log through a message.
        raise RegistryError(
            "the registry's URL is no database URL; give one such as sqlite:///people.sqlite3, or a path"
        ) from None
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


def _is_ambiguous(address: str) -> bool:
    """Whether programs differ in where user and password end in what follows "://".

    Convention: RFC 3986, section 3.2: they end at the only "@", before any "/", "?" or "#", and "%" begins an escape.
    """
    authority = re.split("[/?#]", address, maxsplit=1)[0]
    user, at, _ = authority.partition("@")
    return address.count("@") > len(at) or bool(at and re.search("%(?![0-9A-Fa-f]{2})", user))


def sqlite_file(url: URL) -> Path | None:
    """The file of an SQLite URL that `read_url` has read; None for other databases."""
    return Path(url.database) if url.get_backend_name() == "sqlite" and url.database else None


def own_file(url: str | None) -> Path | None:
    """The file of the registry at an SQLAlchemy URL, or at `default_url()` for None; None if it is no file.

    Raises: RegistryError as `read_url`.
    """
    return sqlite_file(read_url(default_url() if url is None else url))


def show_url(url: URL) -> str:
    """The URL for messages: without its password, and without its options, which may hold another."""
    return url.set(query={}).render_as_string(hide_password=True)


#: A row, and a query, of whatever columns.
AnyRow = Row[*tuple[Any, ...]]
AnySelect = Select[*tuple[Any, ...]]

#: How long a process waits for another one's transaction, seconds; `?timeout=` in the URL overrules it.
SQLITE_WAIT_S = 30.0
#: The mark of connections that will write; see `_begin_in_sqlite`.
WRITES = "moireid_writes"

_NOT_OURS = "its tables are not those that moireid made, so restore it from a copy"
#: By SQLite's code, or PostgreSQL's SQLSTATE of a table or a column that is missing.
_HINTS: dict[int | str, str] = {
    sqlite3.SQLITE_ERROR: _NOT_OURS,
    "42P01": _NOT_OURS,
    "42703": _NOT_OURS,
    sqlite3.SQLITE_BUSY: "another program holds it, so try again when that one is done",
    sqlite3.SQLITE_CANTOPEN: "check that the path names a file and that you may open it",
    sqlite3.SQLITE_CORRUPT: "restore the file from a copy",
    sqlite3.SQLITE_FULL: "make room on the disk",
    sqlite3.SQLITE_NOTADB: "the file is of another kind, so give another URL",
    sqlite3.SQLITE_READONLY: "get the right to write the file and its folder",
}


def connect(url: URL, *, create: bool = False) -> Engine:
    """An engine for `url` that has reached its database once; with `create` an SQLite file is made for its owner alone.

    Raises: RegistryError if no such database or driver is known, an option is not understood, or no server answers.
    """
    shown = show_url(url)
    waits = url.get_backend_name() == "sqlite" and "timeout" not in url.query
    try:
        with warnings.catch_warnings():
            # SQLAlchemy only warns of options that SQLite's driver does not know, and then ignores them.
            warnings.simplefilter("error", SAWarning)
            # After a server was restarted, the first query already succeeds, and not only the second.
            tried = url.get_backend_name() != "sqlite"
            engine = create_engine(url, pool_pre_ping=tried, connect_args={"timeout": SQLITE_WAIT_S} if waits else {})
    except ImportError as error:
        if error.name == "psycopg":
            raise missing_extra("a registry on PostgreSQL", error.name, "postgres") from error
        raise RegistryError(
            f"registry {shown} needs the Python package {error.name!r}, which is not installed; install it, "
            "or give an SQLite URL such as sqlite:///people.sqlite3"
        ) from error
    except (ArgumentError, SAWarning, TypeError, ValueError) as error:
        # The value of an option may be a password, and so be in the error's text.
        why = f"one of its options {', '.join(url.query)} is wrong" if url.query else _first_line(error)
        raise RegistryError(
            f"registry {shown} cannot be opened ({why}); give a URL such as sqlite:///people.sqlite3"
        ) from error
    if url.get_backend_name() == "sqlite":
        event.listen(engine, "begin", _begin_in_sqlite)
        event.listen(engine, "connect", _set_up_sqlite)
    path, reached = sqlite_file(url), False
    made = path is not None and _reach_file(path, shown, create=create)
    try:
        with translated(url), engine.connect():
            reached = True
    except (OSError, TypeError, ValueError) as error:
        # Errors that a driver does not wrap: a malformed address, or an option of the wrong type.
        raise RegistryError(f"registry {shown} cannot be opened ({_first_line(error)}); check the URL") from error
    finally:
        if made and path is not None and not reached:
            path.unlink(missing_ok=True)
    return engine


@contextmanager
def writing(engine: Engine) -> Iterator[Connection]:
    """A transaction that writes: committed at the end, rolled back if an exception leaves it."""
    with engine.execution_options(**{WRITES: True}).begin() as connection:
        yield connection


@contextmanager
def snapshot(engine: Engine) -> Iterator[Connection]:
    """A transaction that only reads, and sees one state of the database however many queries it makes.

    SQLite always does this, and writers wait meanwhile; PostgreSQL must be asked for it, and no writer waits.
    """
    level = {"isolation_level": "REPEATABLE READ"} if engine.dialect.name == "postgresql" else {}
    with engine.execution_options(**level).begin() as connection:
        yield connection


@contextmanager
def translated(url: URL) -> Iterator[None]:
    """Turn what SQLAlchemy raises inside into a RegistryError of one sentence that names the registry."""
    try:
        yield
    except SQLAlchemyError as error:
        foreign = error.orig if isinstance(error, DBAPIError) and error.orig is not None else error
        # The low byte is the kind of error; SQLite keeps details of it in the others.
        kind = getattr(foreign, "sqlstate", None) or getattr(foreign, "sqlite_errorcode", 0) & 0xFF
        hint = _HINTS.get(kind, "check the URL and that the database can be reached")
        raise RegistryError(f"registry {show_url(url)} cannot be used ({_first_line(foreign)}); {hint}") from error


#: Rows that are written or looked up at a time.
CHUNK = 500
Item = TypeVar("Item")


def chunks(items: Iterable[Item]) -> Iterator[list[Item]]:
    """Items in lists of at most `CHUNK`."""
    items = iter(items)
    while chunk := list(islice(items, CHUNK)):
        yield chunk


def clean(engine: Engine) -> bool:
    """Write the tables with names anew; returns whether it worked: not if others use the database, or it is full."""
    try:
        if engine.dialect.name == "sqlite":
            # Not by SQLAlchemy's connection: it begins a transaction, in which SQLite refuses this.
            with closing(engine.raw_connection()) as raw:
                assert raw.driver_connection is not None
                raw.driver_connection.execute("VACUUM")
        else:
            with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
                connection.exec_driver_sql("VACUUM (FULL, ANALYZE) badges")
    except (sqlite3.Error, SQLAlchemyError):
        return False
    return True


def _reach_file(path: Path, shown: str, *, create: bool) -> bool:
    """Check that an SQLite file exists, because SQLite would create a missing one; or make it with its folder.

    Badges can be printed from it, so it is its owner's alone; SQLite gives its journal the same rights.
    Returns: whether it was made.
    """
    try:
        if not create:
            path.stat()
            return False
        path.parent.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        if not create and isinstance(error, (FileNotFoundError, NotADirectoryError)):
            raise RegistryError(
                f"there is no registry at {shown}; enroll someone first, or run `moireid registry init`"
            ) from error
        reason = error.strerror if isinstance(error, OSError) else error
        what = f"folder {path.parent} cannot be made" if create else f"registry {shown} cannot be reached"
        raise RegistryError(f"{what} ({reason}); give another URL") from error
    # Where it is there already, or cannot be made, SQLite says so.
    with suppress(OSError, ValueError):
        os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))
        return True
    return False


def _set_up_sqlite(raw: sqlite3.Connection, record: object) -> None:
    """Let SQLite fill what it deletes with zeros; else an erased name stays in the file until its place is needed.

    And let a commit reach the disk with its folder: else a power cut may bring the journal back, and undo what was
    remembered as done.  And run no function of doubtful effect that a stranger's file has in its own schema.
    """
    raw.execute("PRAGMA secure_delete = ON")
    raw.execute("PRAGMA synchronous = EXTRA")
    raw.execute("PRAGMA trusted_schema = OFF")


def _begin_in_sqlite(connection: Connection) -> None:
    """Begin a transaction; writers take the write lock at once.  Python's sqlite3 begins too late for CREATE TABLE.

    If two transactions read first and ask for the lock later, SQLite refuses one of them without waiting.
    """
    writes = connection.get_execution_options().get(WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _first_line(error: BaseException) -> str:
    """The first line of an error's text, for use within a sentence."""
    lines = str(error).strip().splitlines()
    return lines[0].rstrip(" .:") if lines else type(error).__name__
