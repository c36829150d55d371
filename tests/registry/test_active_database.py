"""A database that works against its registry: triggers, an index that hides rows (SQLite).

Each test says what it catches; in each, a revoked badge counted again, or a false root was signed.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from kit.registries import badge_of, rows_of, tamper, url_of
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import Registry, claimed, open_registry
from moireid.registry.log import entry_hash

LOG = "time, action, subject, record_sha256, actor, hash, signature"


@pytest.fixture
def url(tmp_path: Path) -> str:
    return url_of(tmp_path / "people.sqlite3")


@pytest.fixture
def own(url: str) -> Iterator[Registry]:
    """Three entries: the key, Ada, Bo."""
    with open_registry(url, create=True, actor="Alice") as registry:
        registry.enroll(badge_of("Ada"))
        registry.enroll(badge_of("Bo"))
        yield registry


def _row(url: str, query: str) -> dict[str, Any]:
    (row,) = rows_of(url, query)
    return dict(row)


def _script(url: str, script: str) -> None:
    with sqlite3.connect(url.removeprefix("sqlite:///")) as database:
        database.executescript(script)


def _put_back(url: str, record: dict[str, Any]) -> None:
    """The record of Bo as it was before its revocation."""
    names = ", ".join(record)
    tamper(url, "DELETE FROM badges WHERE name_nfc = 'Bo'")
    tamper(url, f"INSERT INTO badges ({names}) VALUES ({', '.join(f':{name}' for name in record)})", **record)


def _forged(url: str, seq: int) -> dict[str, Any]:
    """An entry by which the record of Bo before its revocation would be the newest; its signature is none."""
    first = _row(url, "SELECT * FROM log WHERE seq = 3")
    entry = first | {"seq": seq, "action": "revoke"}
    return entry | {"hash": entry_hash(entry), "signature": "00" * 64}


def _values(entry: dict[str, Any]) -> str:
    return ", ".join(f"'{entry[name.strip()]}'" for name in LOG.split(","))


def _refused(what: Callable[[], object]) -> str:
    with pytest.raises(RegistryError) as caught:
        what()
    return str(caught.value.details["code"])


def test_an_entry_that_the_database_adds_is_not_signed(own: Registry, url: str) -> None:
    """Catches: a root over entries as they are read back, among them one that the authority never wrote."""
    record = _row(url, "SELECT * FROM badges WHERE name_nfc = 'Bo'")
    own.revoke("Bo", "stolen")
    insert = f"INSERT INTO log (seq, {LOG}) VALUES (6, {_values(_forged(url, 6))});"
    _script(url, f"CREATE TRIGGER t AFTER INSERT ON log WHEN NEW.seq = 5 BEGIN {insert} END;")
    assert _refused(lambda: own.enroll(badge_of("Cy"))) == "log_longer"
    _script(url, "DROP TRIGGER t;")
    _put_back(url, record)
    assert _refused(lambda: claimed(own, "Bo")) == "record_stale"
    assert own.enroll(badge_of("Cy")).name == "Cy" and own.audit().found == 1


def test_an_entry_that_the_database_rewrites_is_not_signed(own: Registry, url: str) -> None:
    """Catches: a revocation that is reported as done, and that the database turned into something else."""
    forged = _forged(url, 4)
    changed = ", ".join(f"{name} = '{forged[name]}'" for name in ("action", "record_sha256", "hash"))
    _script(url, f"CREATE TRIGGER t AFTER INSERT ON log BEGIN UPDATE log SET {changed} WHERE seq = NEW.seq; END;")
    assert _refused(lambda: own.revoke("Bo", "stolen")) == "head_hash"


def test_a_change_that_the_database_undoes_is_not_reported_as_done(own: Registry, url: str) -> None:
    """Catches: a revocation without effect that ends without an error, after which no audit finds anything."""
    back = "head_seq = {head_seq}, head_hash = '{head_hash}', head_signature = '{head_signature}'"
    before = back.format(**_row(url, "SELECT * FROM authority"))
    _script(
        url,
        "CREATE TABLE kept AS SELECT * FROM badges;"
        "CREATE TRIGGER t AFTER UPDATE ON authority BEGIN DELETE FROM log WHERE seq = 4;"
        "DELETE FROM badges; INSERT INTO badges SELECT * FROM kept;"
        f"UPDATE authority SET {before}; END;",
    )
    assert _refused(lambda: own.revoke("Bo", "stolen")) == "head_hash"


def _hide(url: str, seq: int) -> None:
    """Leave an entry out of the index by subject; the table and the text of the index stay as they were."""
    text = _row(url, "SELECT sql FROM sqlite_master WHERE name = 'log_by_subject'")["sql"]
    _script(url, f"DROP INDEX log_by_subject; CREATE INDEX log_by_subject ON log (subject, seq) WHERE seq <> {seq};")
    with sqlite3.connect(url.removeprefix("sqlite:///")) as database:
        database.execute("PRAGMA writable_schema = ON")
        database.execute("UPDATE sqlite_master SET sql = ? WHERE name = 'log_by_subject'", (text,))


@pytest.mark.parametrize("end", ["revoked", "erased"])
def test_an_index_that_hides_the_newest_entry_changes_nothing(
    own: Registry, url: str, end: str, tmp_path: Path
) -> None:
    """Catches: a newest entry that is looked up and never looked for among the entries that follow."""
    record = _row(url, "SELECT * FROM badges WHERE name_nfc = 'Bo'")
    if end == "revoked":
        own.revoke("Bo", "stolen")
    else:
        own.erase("Bo")
    _put_back(url, record)
    _hide(url, 4)
    with open_registry(url, create=False, actor="Alice") as registry:
        assert registry.find("Bo").barred() is None
        ways: dict[str, Callable[[], object]] = {
            "claim": lambda: claimed(registry, "Bo"),
            "bundle": lambda: registry.publish(tmp_path / "people.bundle", specimen_of, days=1),
            "export": lambda: registry.export(tmp_path / "people.out"),
            "figures": lambda: registry.store_as_built(record["id"], '{"a": 1}'),
            "revocation": lambda: registry.revoke("Bo", "lost"),
        }
        assert {name: _refused(way) for name, way in ways.items()} == dict.fromkeys(ways, "record_stale")
        assert {one.code for one in registry.audit().findings} == {"record_stale"}


def test_an_erased_badge_that_an_index_hid_is_found_by_the_audit(own: Registry, url: str) -> None:
    """Catches: an id that is issued again, as its erasure was hidden from enrolment, and that no one ever notices."""
    badge = own.find("Bo").badge
    own.erase("Bo")
    _hide(url, 4)
    with open_registry(url, create=False, actor="Alice") as registry:
        registry.enroll(badge)
        assert {one.code for one in registry.audit().findings} == {"erased_again"}


def test_no_change_signs_a_stale_record(own: Registry, url: str) -> None:
    """Catches: figures that are stored with a record from before its revocation, which are then its newest version."""
    record = _row(url, "SELECT * FROM badges WHERE name_nfc = 'Bo'")
    own.revoke("Bo", "stolen")
    _put_back(url, record)
    tamper(url, "UPDATE log SET subject = '00' WHERE seq = 4")
    assert _refused(lambda: own.store_as_built(record["id"], '{"a": 1}')) == "entry_hash"
