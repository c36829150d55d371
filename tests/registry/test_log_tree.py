"""The tree over the log: each known attack of one who writes the database without the key, and what one root costs.

Each test says what it catches.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kit.registries import badge_of, code_of, rows_of, run, tamper
from kit.witnesses import consistent, root_of
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import Registry, claimed, open_registry
from moireid.registry.log import Head, entry_hash, leaf_of
from moireid.registry.merkle import consistency_proof

BACK = "UPDATE badges SET revoked_at = NULL, revoked_reason = NULL, signature = :signature WHERE name_nfc = 'Ada'"


@pytest.fixture
def revoked(registry: Registry, url: str) -> dict[str, Any]:
    """Seven entries: the key, Ada, Bo, Ada revoked, Cy, Di, Ed.  Returns the row of authority at the third, and Ada's.

    An attacker has kept both.
    """
    registry.enroll(badge_of("Ada"))
    registry.enroll(badge_of("Bo"))
    (top,) = rows_of(url, "SELECT * FROM authority")
    (row,) = rows_of(url, "SELECT signature FROM badges WHERE name_nfc = 'Ada'")
    registry.revoke("Ada", "stolen")
    for name in ("Cy", "Di", "Ed"):
        registry.enroll(badge_of(name))
    return top | row


def last_rows_deleted(url: str) -> None:
    tamper(url, "DELETE FROM log WHERE seq > 3", "DELETE FROM badges WHERE name_nfc IN ('Cy', 'Di', 'Ed')")


def two_rows_swapped(url: str) -> None:
    """The revocation and the entry before it, in each other's place."""
    tamper(url, *(f"UPDATE log SET seq = {new} WHERE seq = {old}" for old, new in ((3, 99), (4, 3), (99, 4))))


def numbers_swapped_and_hashed_anew(url: str) -> None:
    two_rows_swapped(url)
    for row in rows_of(url, "SELECT * FROM log WHERE seq IN (3, 4)"):
        tamper(url, "UPDATE log SET hash = :hash WHERE seq = :seq", hash=entry_hash(row), seq=row["seq"])


def row_altered(url: str) -> None:
    tamper(url, "UPDATE log SET subject = 'ff', action = 'enroll' WHERE seq = 4")


def row_altered_and_hashed_anew(url: str) -> None:
    row_altered(url)
    (row,) = rows_of(url, "SELECT * FROM log WHERE seq = 4")
    tamper(url, "UPDATE log SET hash = :hash WHERE seq = 4", hash=entry_hash(row))


def row_taken_out(url: str) -> None:
    tamper(url, "DELETE FROM log WHERE seq = 4", "UPDATE log SET seq = seq - 1 WHERE seq > 4")


HIDDEN = [
    last_rows_deleted,
    two_rows_swapped,
    numbers_swapped_and_hashed_anew,
    row_altered,
    row_altered_and_hashed_anew,
    row_taken_out,
]


@pytest.mark.claim("A revocation cannot be taken from the log")
@pytest.mark.parametrize("hide", HIDDEN)
def test_a_revocation_cannot_be_hidden_without_the_key(
    url: str, registry: Registry, revoked: dict[str, Any], hide: Callable[[str], None], tmp_path: Path
) -> None:
    """Catches: entries that commit to nothing before them."""
    hide(url)
    tamper(url, BACK, signature=revoked["signature"])
    with pytest.raises(RegistryError, match=r"tampered|rolled back"):
        claimed(registry, "Ada")
    assert "tampered" in run("registry", "show", "Ada", "--registry", url, code=2).stderr
    assert not registry.audit().sound
    with pytest.raises(RegistryError, match="tampered"):
        registry.publish(tmp_path / "bundle", specimen_of, days=1)
    assert not (tmp_path / "bundle").exists()


def test_the_log_of_before_with_its_signed_head_is_a_rollback(
    url: str, registry: Registry, revoked: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: more trust in a root than in a hash: what was sound once is found by memory and by what others keep."""
    kept = registry.checkpoint()[0]
    last_rows_deleted(url)
    tamper(url, BACK, signature=revoked["signature"])
    move = "UPDATE authority SET head_seq = :head_seq, head_hash = :head_hash, head_signature = :head_signature"
    tamper(url, move, **revoked)
    assert code_of(registry) == "rolled_back"
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "another person's"))
    assert registry.audit().sound and claimed(registry, "Ada").barred is None
    assert [one.code for one in registry.audit(since=[kept]).findings] == ["rolled_back"]


@pytest.mark.parametrize("late", [False, True])
def test_no_revoked_badge_is_valid_to_who_has_not_seen_the_revocation(
    registry: Registry, url: str, seen: Path, late: bool
) -> None:
    """Catches: of the entries after those that a reader has seen, the hashes compared alone; or only if it reads first.

    The attacker keeps the hash of the entry of the revocation, and changes what it is about.
    """
    registry.enroll(badge_of("Ada"))
    early = seen.read_bytes()
    (row,) = rows_of(url, "SELECT signature FROM badges WHERE name_nfc = 'Ada'")
    registry.revoke("Ada", "stolen")
    seen.write_bytes(early)
    tamper(url, "UPDATE log SET subject = 'ff' WHERE action = 'revoke'", BACK, signature=row["signature"])
    # An audit, which reports it, does not have it count as seen.
    assert "was changed" in run("registry", "audit", "--registry", url, code=1).stdout
    with open_registry(url, create=False) as reader, pytest.raises(RegistryError, match="log entry 3 was changed"):
        _ = reader.enroll(badge_of("Bo")) if late else list(reader.records())
    assert "log entry 3 was changed" in run("registry", "list", "--registry", url, code=2).stderr


# The trigger is one of SQLite.
@pytest.mark.parametrize("url", ["sqlite"], indirect=True)
def test_a_revocation_that_the_database_does_not_keep_is_not_reported_as_done(registry: Registry, url: str) -> None:
    """Catches: a trigger that changes what the new entry is about, and leaves its hash."""
    registry.enroll(badge_of("Ada"))
    (row,) = rows_of(url, "SELECT signature FROM badges WHERE name_nfc = 'Ada'")
    undo = f"{BACK.replace(':signature', repr(row['signature']))}; UPDATE log SET subject = 'ff' WHERE seq = NEW.seq;"
    tamper(url, f"CREATE TRIGGER hide AFTER INSERT ON log WHEN NEW.action = 'revoke' BEGIN {undo} END")
    with pytest.raises(RegistryError, match="log entry 3 was changed"):
        registry.revoke("Ada", "stolen")
    assert registry.find("Ada").revoked_at is None and registry.audit().sound


def test_every_root_and_proof_is_that_of_the_entries(registry: Registry, url: str) -> None:
    """Catches: a proof that is cut wrongly at some size; leaves of an earlier transaction that are not added to."""
    heads = [registry.head()]
    for number in range(20):
        registry.enroll(badge_of("Ada", bytes([number, 0, 0])))
        heads.append(registry.head())
    registry.enroll_many(badge_of("Bo", bytes([number, 1, 0])) for number in range(14))
    leaves = [leaf_of(row["hash"]) for row in rows_of(url, "SELECT hash FROM log ORDER BY seq")]
    assert heads == [f"{size}:{root_of(leaves[:size]).hex()}" for size in range(1, 22)]
    with registry._ledger.snapshot() as connection:
        tree = registry._ledger.tree_in(connection)
        for size in range(1, 36):
            root = root_of(leaves[:size])
            head, other = Head(size, root.hex()), Head(size, "00" * 32)
            proof = consistency_proof(tree.leaves, size)
            assert consistent(size, root, 35, root_of(leaves), proof)
            assert tree.extends(head) and not tree.extends(other)
