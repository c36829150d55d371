"""The studio's own state, in files and on a real PostgreSQL server."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from kit.registries import Server, running_server


@pytest.fixture(scope="session")
def postgres() -> Iterator[Server]:
    with running_server() as server:
        yield server


@pytest.fixture(params=["sqlite", "postgresql"])
def state(request: pytest.FixtureRequest) -> str | None:
    """An empty database of each kind, as `--state` names it."""
    return None if request.param == "sqlite" else str(request.getfixturevalue("postgres").fresh())
