"""The studio's own databases, files of SQLite or one of PostgreSQL; and the table of jobs, which is always a file.

A database that is away is no verdict on a film: a job waits for it, and a visitor is asked to come again.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, TypeVar

from sqlalchemy import (
    JSON,
    BigInteger,
    Column,
    Connection,
    Engine,
    Executable,
    Float,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
    create_engine,
    event,
    func,
    select,
)
from sqlalchemy.engine import URL
from sqlalchemy.exc import ArgumentError, DBAPIError, InterfaceError, OperationalError, SQLAlchemyError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from moireid.errors import RegistryError, SpecError
from moireid.extras import missing_extra
from moireid.registry.engine import read_url, show_url

Got = TypeVar("Got")
#: How long those who work wait for a database that is away, and between two tries, s.
PATIENCE_S, PAUSE_S = 60.0, 0.5
#: How long a connection may take, and how long a writer waits for another one in SQLite, s.
CONNECT_S, SQLITE_WAIT_S = 5, 30.0
#: Connections that one process holds, and those that it may open in addition for a while.
POOL, POOL_MORE = 10, 30
#: The mark of connections that will write, as in `registry.engine`.
WRITES = "studio_writes"
#: The name of a lock, which PostgreSQL knows as a number: who makes tables.
TABLES_LOCK = 0x6D6F6972


class Away(RegistryError):
    """The studio's database cannot be reached just now."""


class Database:
    """One database; safe to use from any thread."""

    def __init__(self, url: URL, *, log: bool = False) -> None:
        """Prepare connections; none is opened yet.

        Parameters
        ----------
        log
            Let SQLite write ahead, for tables that change often.

        Raises
        ------
        SpecError
            Where it is neither SQLite nor PostgreSQL.
        MissingExtraError
        """
        self.shown = show_url(url)
        self.shared = url.get_backend_name() == "postgresql"
        if not self.shared and url.get_backend_name() != "sqlite":
            raise SpecError(f"{self.shown} is no database for a studio; give postgresql+psycopg://..., or leave it out")
        try:
            self.engine: Engine = _postgres(url) if self.shared else _sqlite(url, log=log)
        except ImportError as error:
            raise missing_extra("a studio on PostgreSQL", error.name or "psycopg", "postgres") from error
        except (ArgumentError, TypeError, ValueError) as error:
            raise SpecError(f"{self.shown} cannot be opened; check the address") from error

    def make(self, metadata: MetaData) -> None:
        """Make the tables that are absent; one process at a time."""
        with self.writing() as connection:
            if self.shared:
                connection.execute(select(func.pg_advisory_xact_lock(TABLES_LOCK)))
            metadata.create_all(connection)

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """A transaction that writes: committed at the end, rolled back where an exception leaves it."""
        with self.translated(), self.engine.execution_options(**{WRITES: True}).begin() as connection:
            yield connection

    def rows(self, query: Executable) -> list[dict[str, Any]]:
        """The rows of a query, by the names of their columns."""
        with self.translated(), self.engine.connect() as connection:
            return [dict(row) for row in connection.execute(query).mappings()]

    def change(self, statement: Executable) -> int:
        """Run a statement in a transaction of its own; returns how many rows it changed."""
        with self.writing() as connection:
            return connection.execute(statement).rowcount

    @contextmanager
    def translated(self) -> Iterator[None]:
        """Turn what SQLAlchemy raises into a RegistryError of one sentence, an `Away` where it may come back."""
        try:
            yield
        except SQLAlchemyError as error:
            words = str(getattr(error, "orig", None) or error).strip().splitlines() or ["no reason"]
            text = f"the studio's database {self.shown} cannot be used ({words[0].rstrip(' .:')})"
            if _gone(error):
                raise Away(f"{text}; try again in a moment") from error
            raise RegistryError(f"{text}; check it") from error

    def close(self) -> None:
        """Close the connections."""
        self.engine.dispose()


def database_of(folder: Path, name: str, state: str | None, *, log: bool = False) -> Database:
    """The database at the address `state`; without one the file of that name in a studio's folder, closed to others.

    Raises: RegistryError, SpecError where it cannot be used.
    """
    if state is not None:
        found = Database(read_url(state))
        if not found.shared:
            raise SpecError(f"{found.shown} is a file; give postgresql+psycopg://..., or leave it out")
        return found
    path = folder.absolute() / name
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))
    except OSError as error:
        raise RegistryError(f"{path} cannot be used ({error.strerror}); give another folder (data)") from error
    return Database(URL.create("sqlite", database=str(path)), log=log)


def utc_text(wait: timedelta = timedelta()) -> str:
    """Now, or so long after it, as ISO 8601 in UTC: text, whose order is that of time."""
    return (datetime.now(UTC) + wait).strftime("%Y-%m-%dT%H:%M:%SZ")


def secret_digest(secret: str) -> str:
    """What is kept of a secret of 256 random bits: its SHA-256, as no one can guess so many."""
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()


def is_away(error: BaseException | None) -> bool:
    """Whether an error, ours or the registry's, is that of a database that may come back."""
    while error is not None:
        if isinstance(error, Away) or (isinstance(error, SQLAlchemyError) and _gone(error)):
            return True
        error = error.__cause__
    return False


def patiently(call: Callable[[], Got], *, stopping: Callable[[], bool] = lambda: False) -> Got:
    """What a call returns; where its database is away, it is called again for `PATIENCE_S`.  Raises: as the call."""
    last = time.monotonic() + PATIENCE_S
    while True:
        try:
            return call()
        except RegistryError as error:
            if not is_away(error) or time.monotonic() > last or stopping():
                raise
        time.sleep(PAUSE_S)


def _gone(error: SQLAlchemyError) -> bool:
    if isinstance(error, PoolTimeout):
        return True
    lost = isinstance(error, DBAPIError) and error.connection_invalidated
    return lost or isinstance(error, (OperationalError, InterfaceError))


def _postgres(url: URL) -> Engine:
    # A connection is tried before it is used, so the first request after an outage does not fail.
    return create_engine(
        url,
        pool_pre_ping=True,
        pool_size=POOL,
        max_overflow=POOL_MORE,
        connect_args={"connect_timeout": CONNECT_S} if "connect_timeout" not in url.query else {},
    )


def _sqlite(url: URL, *, log: bool) -> Engine:
    engine = create_engine(url, connect_args={"timeout": SQLITE_WAIT_S}, pool_size=POOL, max_overflow=POOL_MORE)
    event.listen(engine, "connect", lambda raw, _: raw.execute("PRAGMA secure_delete = ON"))
    if log:
        # A step of a job then waits for no disk.  After a loss of power the last ones may be missing, none is half.
        event.listen(engine, "connect", _write_ahead)
    event.listen(engine, "begin", _begin_in_sqlite)
    return engine


def _write_ahead(raw: sqlite3.Connection, record: object) -> None:
    raw.execute("PRAGMA journal_mode = WAL")
    raw.execute("PRAGMA synchronous = NORMAL")


def _begin_in_sqlite(connection: Connection) -> None:
    """Writers take the lock at once: two that read first and ask for it later would be refused without waiting."""
    writes = connection.get_execution_options().get(WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


metadata = MetaData()
#: `lane`: "issue" or "judge"; `turn`: how many jobs of the owner were there before it; `wish`, `about`, `result`,
#: `kept`, `problem`: what a job is and has made; `taken`: how often it was begun; `made`, `ended`: s since 1970.
jobs = Table(
    "jobs",
    metadata,
    Column("id", Text, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("lane", Text, nullable=False),
    Column("owner", Text, nullable=False),
    Column("role", Text, nullable=False),
    Column("state", Text, nullable=False),
    Column("turn", Integer, nullable=False),
    Column("made", Float(53), nullable=False),
    Column("taken", Integer, nullable=False),
    Column("ended", Float(53)),
    Column("video", Text),
    Column("bytes", BigInteger, nullable=False),
    Column("read", Integer, nullable=False),
    Column("expected", Integer),
    Column("wish", JSON, nullable=False),
    Column("about", JSON, nullable=False),
    Column("result", JSON(none_as_null=True)),
    Column("kept", JSON(none_as_null=True)),
    Column("problem", JSON(none_as_null=True)),
)
Index("jobs_by_state", jobs.c.state)
