"""Jobs on SQLite and on a real PostgreSQL server, without a studio."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from kit.registries import Server, running_server
from moireid_studio.store.database import Database, database_of
from moireid_studio.store.ledger import Ledger


@pytest.fixture(scope="session")
def postgres() -> Iterator[Server]:
    with running_server() as server:
        yield server


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Database]:
    """An empty database of each kind."""
    state = None if request.param == "sqlite" else request.getfixturevalue("postgres").fresh()
    found = database_of(tmp_path, "jobs.sqlite3", state, log=True)
    yield found
    found.close()


@pytest.fixture
def process(database: Database, tmp_path: Path) -> Callable[[], Ledger]:
    """Another process at the same jobs."""
    return lambda: Ledger(database, tmp_path / "films")
