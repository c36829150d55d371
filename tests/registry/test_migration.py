"""A registry that version 2 of the schema wrote (tests/data/registry).  Each test says what it catches."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text

from kit.registries import badge_of, rows_of, url_of
from moireid.errors import RegistryError
from moireid.registry import import_registry, open_registry
from moireid.registry.checkpoints.sources import checkpoints_from

DATA = Path(__file__).parents[1] / "data" / "registry"
FINGERPRINT = "367db9c85d05112f7ea7635a0860a1f7"
CYRILLIC = "\u0410d\u0430 L\u043ev\u0435l\u0430\u0441\u0435"


@pytest.fixture
def old_file(path: Path, keys: Path) -> Path:
    """The registry of version 2, and its key."""
    keys.mkdir(parents=True)
    shutil.copy(DATA / "version2.key.pem", keys / f"{FINGERPRINT}.pem")
    (keys / f"{FINGERPRINT}.pem").chmod(0o600)
    shutil.copy(DATA / "version2.sqlite3", path)
    return path


@pytest.fixture
def old(url: str, old_file: Path) -> str:
    """The same on either kind of database."""
    if url.startswith("sqlite"):
        return url
    copied = url_of(DATA / "version2.sqlite3")
    engine = create_engine(url)
    with engine.begin() as connection:
        for statement in (DATA / "version2.postgresql.sql").read_text(encoding="utf-8").split(";\n"):
            if statement.strip():
                connection.execute(text(statement))
        for table in ("schema_version", "authority", "badges", "log"):
            for row in rows_of(copied, f"SELECT * FROM {table}"):
                places = ", ".join(f":{key}" for key in row)
                connection.execute(text(f"INSERT INTO {table} ({', '.join(row)}) VALUES ({places})"), row)
    engine.dispose()
    return url


def test_an_old_registry_is_brought_to_this_version_and_stays_sound(old):
    """Catches: a chain or a signature that changed; a checkpoint of before that holds no more; figures lost."""
    before = rows_of(old, "SELECT seq, hash, signature FROM log ORDER BY seq")
    with open_registry(old, create=False) as registry:
        assert [record.name for record in registry.records()] == ["Ada Lovelace", "Bo", "Zo\u00eb"]
        assert registry.find("Bo").revoked_reason == "lost on the train"
        assert registry.find("Ada Lovelace").as_built == '{"tilt_rad":0.01}'
        seen = registry.audit(since=checkpoints_from(str(DATA / "version2.checkpoint")))
        assert (seen.sound, seen.entries, seen.unnamed, seen.actors) == (True, 6, 6, {})
    assert rows_of(old, "SELECT seq, hash, signature FROM log ORDER BY seq") == before
    assert rows_of(old, "SELECT version FROM schema_version") == [{"version": 5}]


def test_it_can_be_written_and_grows_as_a_new_one(old):
    """Catches: old entries and new ones that do not chain; a record without a salt after it changed; names of before
    that no search for look-alikes finds."""
    with open_registry(old, create=False, actor="Bob") as registry:
        assert registry.look_alikes([CYRILLIC])[CYRILLIC][0].name == "Ada Lovelace"
        registry.enroll(badge_of("Di"))
        assert registry.revoke("Ada Lovelace", "lost").salt is not None and registry.find("Zo\u00eb").salt is None
        seen = registry.audit(since=checkpoints_from(str(DATA / "version2.checkpoint")))
        assert (seen.sound, seen.unnamed, seen.actors) == (True, 6, {"Bob": 2})


def test_what_is_asked_for_by_both_has_the_same_indexes(old_file, tmp_path):
    """Catches: a column or an index that a new registry has and an old one lacks, so that it is slow for ever."""
    with open_registry(url_of(old_file), create=False) as registry:
        registry.enroll(badge_of("Di"))
    fresh = tmp_path / "fresh.sqlite3"
    open_registry(url_of(fresh), create=True).close()

    def made(file: Path) -> tuple[set[str], set[tuple[str, str]]]:
        with sqlite3.connect(file) as raw:
            indexes = {name for (name,) in raw.execute("SELECT name FROM sqlite_master WHERE sql LIKE 'CREATE INDEX%'")}
            tables = [name for (name,) in raw.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
            return indexes, {(t, row[1]) for t in tables for row in raw.execute(f"PRAGMA table_info({t})")}

    assert made(old_file) == made(fresh)


def test_where_it_cannot_be_written_the_reason_is_said(old_file):
    """Catches: a half-changed file, and a database's own error, where somebody else writes."""
    before = old_file.read_bytes()
    holder = sqlite3.connect(old_file, isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with pytest.raises(RegistryError, match=r"version 2 and must be brought to 5 once, which failed \(.*locked"):
        open_registry(url_of(old_file, timeout=0.05), create=False)
    holder.close()
    assert old_file.read_bytes() == before


def test_a_step_that_fails_leaves_all_as_it_was(old, monkeypatch):
    """Catches: columns without their contents after a program was killed in between."""

    def broken(connection):
        raise KeyboardInterrupt

    monkeypatch.setattr("moireid.registry.opening.write_skeletons", broken)
    with pytest.raises(KeyboardInterrupt):
        open_registry(old, create=False)
    assert rows_of(old, "SELECT version FROM schema_version") == [{"version": 2}]
    monkeypatch.undo()
    assert "salt" not in rows_of(old, "SELECT * FROM badges LIMIT 1")[0]


def test_an_export_of_before_is_taken_in(url, keys):
    """Catches: a reader that knows the new form alone, so that a backup of before is lost."""
    assert import_registry(DATA / "export1.json", url).added == 3
    with open_registry(url, create=False) as registry:
        assert registry.fingerprint == FINGERPRINT and registry.audit().sound
        assert registry.look_alikes([CYRILLIC])[CYRILLIC][0].name == "Ada Lovelace"
