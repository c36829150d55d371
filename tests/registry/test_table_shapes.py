"""A database whose tables are not those that moireid made is named as such, in one sentence, whatever is read of it."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from kit.registries import badge_of, url_of
from moireid.errors import RegistryError
from moireid.registry import claimed, open_registry

#: What is done to the tables: a column of another type or gone, a table that is gone, or is a view.
CHANGES = {
    "another type": "ALTER TABLE log RENAME TO was; CREATE TABLE log AS SELECT CAST(seq AS TEXT) AS seq, time, action, "
    "subject, record_sha256, actor, hash, signature FROM was; DROP TABLE was;",
    "a head of text": "ALTER TABLE authority RENAME TO was; CREATE TABLE authority AS SELECT one, public_key, "
    "CAST(head_seq AS TEXT) AS head_seq, head_hash, head_signature FROM was; DROP TABLE was;",
    "no log": "DROP TABLE log;",
    "log as a view": "ALTER TABLE log RENAME TO was; CREATE VIEW log AS SELECT * FROM was;",
    "a column less": "ALTER TABLE badges DROP COLUMN revoked_reason;",
}


def _made(path: Path) -> str:
    with open_registry(url_of(path), create=True) as registry:
        registry.enroll(badge_of("Ada"))
        registry.enroll(badge_of("Bo"))
    return url_of(path)


def _script(path: Path, script: str) -> None:
    with sqlite3.connect(path) as database:
        database.executescript(script)


@pytest.mark.parametrize("change", CHANGES)
def test_tables_of_another_shape_are_named(tmp_path: Path, change: str) -> None:
    """Catches: a TypeError out of an audit; `no such table: log; check the URL`, which no URL would help."""
    url = _made(tmp_path / "people.sqlite3")
    _script(tmp_path / "people.sqlite3", CHANGES[change])
    with (
        pytest.raises(RegistryError, match="restore it from a copy") as caught,
        open_registry(url, create=False) as own,
    ):
        own.enroll(badge_of("Cy"))
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500


@pytest.mark.parametrize("change", CHANGES)
def test_an_audit_names_tables_that_changed_since_it_was_opened(tmp_path: Path, change: str) -> None:
    """Catches: a look at the tables when a registry is opened alone, as a studio keeps it open for weeks."""
    with open_registry(_made(tmp_path / "people.sqlite3"), create=False) as own:
        _script(tmp_path / "people.sqlite3", CHANGES[change])
        if change == "log as a view":
            assert own.audit().sound
        else:
            with pytest.raises(RegistryError, match="restore it from a copy"):
                own.audit()


@pytest.mark.parametrize("change", ["no log", "another type", "a head of text"])
def test_a_claim_from_tables_that_changed_ends_in_a_sentence(tmp_path: Path, change: str) -> None:
    """Catches: numbers of entries compared as text, out of which an error of Python comes; words about the URL."""
    with open_registry(_made(tmp_path / "people.sqlite3"), create=False) as own:
        _script(tmp_path / "people.sqlite3", CHANGES[change])
        with pytest.raises(RegistryError, match="restore it from a copy"):
            claimed(own, "Ada")


def test_an_audit_names_an_entry_without_a_number(tmp_path: Path) -> None:
    """Catches: a TypeError out of an audit of tables that let a number be absent."""
    url = _made(tmp_path / "people.sqlite3")
    change = (
        "ALTER TABLE log RENAME TO was; CREATE TABLE log AS SELECT nullif(seq, 3) AS seq, time, action, subject, "
        "record_sha256, actor, hash, signature FROM was; DROP TABLE was;"
    )
    _script(tmp_path / "people.sqlite3", change)
    with open_registry(url, create=False) as own:
        assert "entry_missing" in [one.code for one in own.audit().findings]


def test_a_last_entry_that_is_there_twice_ends_in_a_sentence(tmp_path: Path) -> None:
    """Catches: an IndexError in a studio that read the log before its last entry was doubled."""
    change = "ALTER TABLE log RENAME TO was; CREATE TABLE log AS SELECT * FROM was; INSERT INTO log SELECT * FROM was "
    with open_registry(_made(tmp_path / "people.sqlite3"), create=False) as own:
        claimed(own, "Bo")
        _script(tmp_path / "people.sqlite3", f"{change} ORDER BY seq DESC LIMIT 1;")
        with pytest.raises(RegistryError, match="restore it from a copy"):
            claimed(own, "Bo")


def test_a_column_and_a_table_of_someone_else_are_no_fault(tmp_path: Path) -> None:
    """Catches: a registry that is refused because its operator keeps notes of their own in the same database."""
    url = _made(tmp_path / "people.sqlite3")
    _script(tmp_path / "people.sqlite3", "ALTER TABLE badges ADD COLUMN note TEXT; CREATE TABLE notes (a);")
    with open_registry(url, create=False) as own:
        own.enroll(badge_of("Cy"))
        assert own.audit().sound


@pytest.mark.parametrize("column", ["log.signature", "log.actor"])
def test_bytes_in_a_column_of_text_end_in_a_sentence(tmp_path: Path, column: str) -> None:
    """Catches: `Object of type bytes is not JSON serializable`: SQLite keeps a value of any kind in any column."""
    url, (table, name) = _made(tmp_path / "people.sqlite3"), column.split(".")
    _script(tmp_path / "people.sqlite3", f"UPDATE {table} SET {name} = X'FF00';")
    with open_registry(url, create=False) as own, pytest.raises(RegistryError, match="; restore it from a copy"):
        own.export(tmp_path / "people.out")
    with open_registry(url, create=False) as own:
        try:
            assert not own.audit().sound
        except RegistryError as error:
            assert error.details["code"] == "tables"
