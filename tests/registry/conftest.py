"""Each test has its own folder for private keys; most run once on SQLite and, as slow ones, once on PostgreSQL."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from kit.registries import Server, badge_of, running_server, url_of
from moireid.registry import Registry, engine, open_registry
from moireid.registry.canonical import sha256_hex
from moireid.registry.log import Head
from moireid.registry.seen import recall


def fill(registry: Registry) -> None:
    """Enroll three badges, revoke one and measure one."""
    for name in ("Ada", "Bo", "Zo\u00eb"):
        registry.enroll(badge_of(name))
    registry.store_as_built(registry.find("Ada").id, '{"tilt_rad": 0.01, "at": [1, 2.5]}')
    registry.revoke("Bo", "lost on the train — twice")


@pytest.fixture(autouse=True)
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where private keys go; child processes inherit it."""
    folder = tmp_path / "private" / "keys"
    monkeypatch.setenv("MOIREID_KEYS", str(folder))
    return folder


@pytest.fixture(autouse=True)
def seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where it is kept what was seen of registries, so that one test's registries are not another's."""
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    return tmp_path / "seen.sqlite3"


@pytest.fixture(autouse=True)
def unsynced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing outlives a test, so nothing need reach the disk; `test_faults` works in processes of its own."""
    set_up = engine._set_up_sqlite

    def fast(raw: sqlite3.Connection, record: object) -> None:
        set_up(raw, record)
        # EXTRA: a commit reaches the disk with its folder.
        assert raw.execute("PRAGMA synchronous").fetchone() == (3,)
        raw.execute("PRAGMA synchronous = OFF")

    monkeypatch.setattr(engine, "_set_up_sqlite", fast)


@pytest.fixture
def machines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each registry is on a machine of its own: what is seen of one there is not known to those who open another."""

    def of_its_own(place: str) -> tuple[str | None, dict[str, Head]]:
        monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen" / sha256_hex(place.encode())))
        return recall(place)

    monkeypatch.setattr("moireid.registry.rollback.recall", of_its_own)


@pytest.fixture(scope="session")
def postgres() -> Iterator[Server]:
    with running_server() as server:
        yield server


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """An SQLite file, the only one in its folder."""
    folder = tmp_path / "registry"
    folder.mkdir()
    return folder / "people.sqlite3"


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.slow)])
def url(request: pytest.FixtureRequest, path: Path) -> str:
    """An empty database of each kind."""
    return url_of(path) if request.param == "sqlite" else request.getfixturevalue("postgres").fresh()


@pytest.fixture
def registry(url: str) -> Iterator[Registry]:
    with open_registry(url, create=True) as opened:
        yield opened


@pytest.fixture
def full(registry: Registry) -> Registry:
    """Three badges, one of them revoked and one measured."""
    fill(registry)
    return registry


@pytest.fixture
def exported(full: Registry, tmp_path: Path) -> Path:
    assert full.export(tmp_path / "out" / "export.sqlite3") == 3
    return tmp_path / "out" / "export.sqlite3"


@pytest.fixture
def target(request: pytest.FixtureRequest, url: str, tmp_path: Path) -> str:
    """The URL of an empty database to import into, of the kind that `url` is not: so each kind is read and written."""
    if url.startswith("sqlite"):
        return request.getfixturevalue("postgres").fresh()
    return url_of(tmp_path / "target.sqlite3")
