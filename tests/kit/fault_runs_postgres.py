"""Statements and commits to PostgreSQL fail, one in each run: `python -m kit.fault_runs_postgres FOLDER MOST [NAME…]`.

The operations are those of `fault_runs`, and what must hold afterwards is the same.  The seam is the driver, psycopg:
the call of number `at` is refused, or its connection is lost before it or after it, or the process is killed after it.
After a commit whose answer is lost, the operation has failed and its change is there: the state is that of after.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psycopg

from kit import fault_runs
from kit.fault_runs import DONE, OPERATIONS, checked_point, forked, prepare, report, sampled, state_of
from kit.registries import Server, running_server, tamper

KINDS = ("error", "lost before", "lost after", "kill after")


class Driver:
    """Counts the calls of psycopg that reach the server, and fails one of them."""

    CALLS = ((psycopg.Cursor, "execute"), (psycopg.Cursor, "executemany"), (psycopg.Connection, "commit"))

    def __init__(self, kind: str, at: int) -> None:
        self._kind, self._at, self.calls = kind, at, list[str]()

    def arm(self) -> None:
        """Put this object between SQLAlchemy and the driver, in this process for good."""
        for owner, name in self.CALLS:
            setattr(owner, name, self._failing(name, getattr(owner, name)))

    def _failing(self, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(own: Any, *words: Any, **named: Any) -> Any:
            self.calls.append(name)
            if len(self.calls) != self._at:
                return real(own, *words, **named)
            connection = own if isinstance(own, psycopg.Connection) else own.connection
            if self._kind == "error":
                raise psycopg.OperationalError("out of memory")
            if self._kind == "lost before":
                _cut(connection)
            answer = real(own, *words, **named)
            if self._kind == "kill after":
                os.kill(os.getpid(), signal.SIGKILL)
            if self._kind == "lost after":
                _cut(connection)
                raise psycopg.OperationalError("server closed the connection unexpectedly")
            return answer

        return call


def _cut(connection: Any) -> None:
    """End a connection as a network does: neither side is asked."""
    with socket.socket(fileno=os.dup(connection.fileno())) as line:
        line.shutdown(socket.SHUT_RDWR)


class Place:
    """A registry on a server, with the files next to it; `fresh` puts both back to the state in which they began."""

    def __init__(self, server: Server, folder: Path, name: str) -> None:
        self.url, self.start, self.now = server.fresh(), folder / "start", folder / "now"
        self._empty, self._kept = name == "init", self.url.rpartition("%3D")[2]
        fault_runs.registry_at, fault_runs.keep_registry = lambda folder: self.url, lambda folder: self._keep()
        prepare(self.start, name)
        if not self._empty:
            tamper(self.url, *_copied(self._kept, f"{self._kept}_kept"))

    def _keep(self) -> Callable[[], object]:
        tamper(self.url, *_copied(self._kept, f"{self._kept}_early"))
        return lambda: tamper(self.url, *_copied(f"{self._kept}_early", self._kept))

    def fresh(self) -> None:
        """As it began."""
        shutil.rmtree(self.now, ignore_errors=True)
        shutil.copytree(self.start, self.now)
        # Connections of a process that was killed may still hold locks for a moment.
        tamper(self.url, *_ENDED)
        if self._empty:
            tamper(self.url, f"DROP SCHEMA {self._kept} CASCADE", f"CREATE SCHEMA {self._kept}")
        else:
            tamper(self.url, *_copied(f"{self._kept}_kept", self._kept))


_TABLES = ("badges", "log", "nodes", "actors", "authority", "schema_version")
_ENDED = (
    "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() AND usename = 'moireid'",
)


def _copied(source: str, target: str) -> list[str]:
    """The statements that make one schema's tables those of another."""
    made = [f"DROP SCHEMA IF EXISTS {target} CASCADE", f"CREATE SCHEMA {target}"]
    for table in _TABLES:
        made += [
            f"CREATE TABLE {target}.{table} (LIKE {source}.{table} INCLUDING ALL)",
            f"INSERT INTO {target}.{table} SELECT * FROM {source}.{table}",
        ]
    return made


def failing(name: str, folder: Path, kind: str, at: int) -> tuple[int, Any]:
    """An operation in which call number `at` fails; what it sends is its calls."""

    def work() -> list[str]:
        driver = Driver(kind, at)
        driver.arm()
        OPERATIONS[name](folder)
        return driver.calls

    return forked(work)


def points(name: str, place: Place, most: int, covered: set[tuple[str, str]]) -> Iterator[str | None]:
    """Fail an operation at some calls, as `sampled`; for each point None, or what does not hold."""
    place.fresh()
    code, old = forked(lambda: state_of(place.now))
    assert code == DONE, old
    place.fresh()
    code, calls = failing(name, place.now, "none", -1)
    assert code == DONE, calls
    new = forked(lambda: state_of(place.now))[1]
    every = [(kind, at, call) for kind in KINDS for at, call in enumerate(calls, 1)]
    for kind, at, call in sampled(name, every, most, covered):
        place.fresh()
        ended, said = failing(name, place.now, kind, at)
        yield checked_point(f"{name}, {kind} at call {at}, {call}: ", place.now, (ended, said), old, new)


def main(folder: str, most: str, *names: str) -> None:
    """Write the number of points, and each that does not hold."""
    with running_server() as server:
        found, covered = {}, set[tuple[str, str]]()
        for name in names or OPERATIONS:
            with tempfile.TemporaryDirectory(dir=folder) as own:
                found[name] = list(points(name, Place(server, Path(own), name), int(most), covered))
            sys.stderr.write(f"{name}: {len(found[name])} points\n")
    report(found, covered)


if __name__ == "__main__":
    main(*sys.argv[1:])
