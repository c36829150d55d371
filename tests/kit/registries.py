"""What the registry's tests share: URLs, badges, a hand in the database, and a PostgreSQL server of their own."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from sqlalchemy import create_engine, text

from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.registry import Registry

TABLES = {
    "badges": "id",
    "log": "seq",
    "authority": "one",
    "schema_version": "version",
}


def url_of(path: Path, **options: object) -> str:
    query = "&".join(f"{key}={value}" for key, value in options.items())
    return f"sqlite:///{path}" + ("?" + query if query else "")


@cache
def badge_of(name: str, payload: bytes | None = None, **request: object) -> Badge:
    """A badge of that name, of the family with few cells unless the payload is a longer one: a registry reads none."""
    # Here, because the processes that the tests start import this module and design nothing.
    from kit.payloads import payload_for_name
    from moireid.designer import Order, design_badge

    payload = payload or payload_for_name(name, family="pitch")
    return design_badge(Order(name, **{"lens": "50lpi"} | request), payload)  # type: ignore[arg-type]


def run(*words: object, code: int = 0) -> Result:
    """Run `moireid` with these words, which must leave with that exit code."""
    from moireid.cli.main import moireid

    done = CliRunner().invoke(moireid, [str(word) for word in words])
    assert done.exit_code == code, done.output
    return done


def code_of(registry: Registry, trust: str | None = None) -> str | None:
    """The code by which a registry is refused for what was seen of it before; None if it is not."""
    try:
        registry.standing(trust)
    except RegistryError as error:
        assert "\n" not in str(error) and ";" in str(error)
        return str(error.details["code"])
    return None


def stop_clock(patch: pytest.MonkeyPatch, now: str) -> None:
    """Let every change of a registry be made at that time."""
    for module in ("store", "changes"):
        patch.setattr(f"moireid.registry.{module}.utc_now", lambda: now)


def tamper(url: str, *statements: str, **values: object) -> int:
    """Change the database behind the registry's back; returns how many rows the last statement changed."""
    engine = create_engine(url)
    try:
        with engine.begin() as connection:
            for statement in statements:
                names = {name: value for name, value in values.items() if f":{name}" in statement}
                changed = connection.execute(text(statement), names).rowcount
        return changed
    finally:
        engine.dispose()


def rows_of(url: str, query: str) -> list[dict[str, object]]:
    engine = create_engine(url)
    try:
        with engine.connect() as connection:
            return [dict(row._mapping) for row in connection.execute(text(query))]
    finally:
        engine.dispose()


def state_of(url: str) -> dict[str, list[dict[str, object]]]:
    """Everything in the registry's tables."""
    return {table: rows_of(url, f"SELECT * FROM {table} ORDER BY {key}") for table, key in TABLES.items()}


class Server:
    """A PostgreSQL server that somebody started; each call of `fresh` gives the URL of an empty schema."""

    def __init__(self, socket: Path) -> None:
        self._url, self._made = f"postgresql+psycopg://moireid@/postgres?host={socket}", 0

    def fresh(self) -> str:
        # A schema, because a database of its own takes twenty times as long.
        self._made += 1
        tamper(self._url, f"CREATE SCHEMA people{self._made}")
        return f"{self._url}&options=-csearch_path%3Dpeople{self._made}"


@contextmanager
def running_server() -> Iterator[Server]:
    """A throw-away server in a temporary folder, on a Unix socket in it, under an account that is not root's."""
    binaries = _binaries()
    if binaries is None:
        pytest.skip("no PostgreSQL server is installed (Debian: apt-get install postgresql)")
    prefix, owner = _account()
    # Not pytest's folder: that one is closed to other accounts, and its path too long for a socket's.
    folder = Path(tempfile.mkdtemp(prefix="moireid-pg-"))
    try:
        if owner is not None:
            os.chown(folder, *owner)
        data = folder / "data"
        make = [binaries / "initdb", "-D", data, "-U", "moireid", "-A", "trust", "-E", "UTF8", "--locale=C", "-N"]
        _run(prefix, *make, folder=folder)
        # Nothing here outlives the tests, so nothing need reach the disk.
        options = f"-k {folder} -c listen_addresses='' -c fsync=off -c max_connections=50"
        control = (binaries / "pg_ctl", "-D", data, "-w", "-l", folder / "server.log")
        control = (*control, "-o", options)
        _run(prefix, *control, "start", folder=folder)
        try:
            yield Server(folder)
        finally:
            _run(prefix, *control, "-m", "immediate", "stop", folder=folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _binaries() -> Path | None:
    """The folder of the newest server's programs."""
    versions = [path for path in Path("/usr/lib/postgresql").glob("*/bin") if (path / "initdb").exists()]
    if versions:
        return max(versions, key=lambda path: float(path.parent.name))
    found = shutil.which("initdb")
    return Path(found).resolve().parent if found else None


def _account() -> tuple[list[str], tuple[int, int] | None]:
    """What to put before a command so that it does not run as root, which the server refuses; and whose folder then."""
    if os.getuid() != 0:
        return [], None
    for name in ("postgres", "nobody"):
        try:
            entry = pwd.getpwnam(name)
        except KeyError:
            continue
        if shutil.which("setpriv"):
            ids = [f"--reuid={entry.pw_uid}", f"--regid={entry.pw_gid}", "--clear-groups"]
            return ["setpriv", *ids], (entry.pw_uid, entry.pw_gid)
        if shutil.which("runuser"):
            return ["runuser", "-u", name, "--"], (entry.pw_uid, entry.pw_gid)
    pytest.skip("the PostgreSQL server cannot run as root, and there is no other account to run it under")


def _run(prefix: list[str], *command: object, folder: Path) -> None:
    """Run a command; where it fails, so does the test, with what it said."""
    # No pipe: the server would inherit it, and a reader to its end would wait for the server.
    said = folder.with_suffix(".said")
    with said.open("wb") as stream:
        done = subprocess.run(
            [*prefix, *map(str, command)], cwd="/", stdin=subprocess.DEVNULL, stdout=stream, stderr=stream, check=False
        )
    text = said.read_text(errors="replace")
    said.unlink()
    if done.returncode:
        log = folder / "server.log"
        text += log.read_text(errors="replace") if log.exists() else ""
        pytest.fail(f"{Path(str(command[0])).name} failed: {text[-2000:]}", pytrace=False)
