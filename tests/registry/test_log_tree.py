"""The tree over the log: each known attack of one who writes the database without the key, and what one root costs.

Each test says what it catches.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event

from kit.registries import badge_of, code_of, rows_of, tamper
from kit.witnesses import nodes_over, root_of
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import Registry, claimed
from moireid.registry.log import Head, entry_hash, leaf_of
from moireid.registry.merkle import consistent

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


def nodes_anew(url: str) -> None:
    """The nodes that fit the entries as they are now: anyone can compute them."""
    hashes = [row["hash"] for row in rows_of(url, "SELECT hash FROM log ORDER BY seq")]
    tamper(url, "DELETE FROM nodes")
    for (level, place), node in nodes_over([leaf_of(one) for one in hashes]).items():
        if level:
            insert = "INSERT INTO nodes (level, place, hash) VALUES (:level, :place, :node)"
            tamper(url, insert, level=level, place=place, node=node.hex())


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
@pytest.mark.parametrize("replaced", [False, True], ids=["nodes as they were", "nodes that fit"])
@pytest.mark.parametrize("hide", HIDDEN)
def test_a_revocation_cannot_be_hidden_without_the_key(
    url: str, registry: Registry, revoked: dict[str, Any], hide: Callable[[str], None], replaced: bool, tmp_path: Path
) -> None:
    """Catches: entries that commit to nothing before them, and nodes that are believed because they are stored."""
    hide(url)
    tamper(url, BACK, signature=revoked["signature"])
    if replaced:
        nodes_anew(url)
    with pytest.raises(RegistryError, match=r"tampered|rolled back"):
        claimed(registry, "Ada")
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
    nodes_anew(url)
    move = "UPDATE authority SET head_seq = :head_seq, head_hash = :head_hash, head_signature = :head_signature"
    tamper(url, move, **revoked)
    assert code_of(registry) == "rolled_back"
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "another person's"))
    assert registry.audit().sound and claimed(registry, "Ada").barred is None
    assert [one.code for one in registry.audit(since=[kept]).findings] == ["rolled_back"]


@pytest.mark.parametrize("change", ["hash = :other", "hash = 'x'"])
def test_one_changed_node_is_found_and_nothing_is_signed_over_it(
    url: str, registry: Registry, revoked: dict[str, Any], change: str
) -> None:
    """Catches: an audit that compares the head alone; a writer that signs a root over nodes which it did not check."""
    assert registry.audit().sound
    assert tamper(url, f"UPDATE nodes SET {change} WHERE level = 1 AND place = 2", other="11" * 32) == 1
    assert [(one.code, one.subject) for one in registry.audit().findings] == [("tree_node", "6")]
    before = rows_of(url, "SELECT * FROM log") + rows_of(url, "SELECT * FROM authority")
    with pytest.raises(RegistryError, match="tree"):
        registry.enroll(badge_of("Flo"))
    assert rows_of(url, "SELECT * FROM log") + rows_of(url, "SELECT * FROM authority") == before


def test_a_node_too_many_is_reported(url: str, registry: Registry, revoked: dict[str, Any]) -> None:
    """Catches: a node of the future, by which no entry can be added any more, in an audit that finds nothing."""
    tamper(url, "INSERT INTO nodes (level, place, hash) VALUES (3, 0, 'x')")
    assert [one.code for one in registry.audit().findings] == ["tree_node"]


def test_every_root_and_proof_is_that_of_the_entries(registry: Registry, url: str) -> None:
    """Catches: a node stored at another place; a proof from a frontier that is cut wrongly at some size."""
    heads = [registry.head()]
    for number in range(20):
        registry.enroll(badge_of("Ada", bytes([number, 0, 0])))
        heads.append(registry.head())
    registry.enroll_many(badge_of("Bo", bytes([number, 1, 0])) for number in range(14))
    leaves = [leaf_of(row["hash"]) for row in rows_of(url, "SELECT hash FROM log ORDER BY seq")]
    assert heads == [f"{size}:{root_of(leaves[:size]).hex()}" for size in range(1, 22)]
    assert len(rows_of(url, "SELECT * FROM nodes")) == sum(len(leaves) >> level for level in range(1, 9))
    with registry._ledger.snapshot() as connection:
        tree = registry._ledger.tree_in(connection)
        for size in range(1, 36):
            root = root_of(leaves[:size])
            proof = tree.consistency(size, root)
            assert proof is not None and consistent(size, root, 35, tree.root, proof)
            assert tree.leads_from(Head(size, root.hex()))
            assert not tree.leads_from(Head(size, "00" * 32)) and tree.consistency(size, bytes(32)) is None


def test_what_is_read_grows_with_the_number_of_levels(registry: Registry) -> None:
    """Catches: a head, a proof or a new entry that reads the whole log again."""
    found, asked = [], list[int]()

    def counted(connection: Any, cursor: Any, statement: str, values: Any, *_: object) -> None:
        asked.append(len(values))

    def values_of(call: Callable[[], object]) -> int:
        """How many values all statements of a call name together: each row that is asked for is named by two."""
        asked.clear()
        call()
        return sum(asked)

    first = registry.checkpoint()[0]
    event.listen(registry._ledger.engine, "before_cursor_execute", counted)
    for size in (20, 650):
        registry.enroll_many(badge_of("Ada", bytes([k % 256, k // 256, size % 256])) for k in range(size))
        registry.enroll(badge_of("Cy", bytes([1, 200, size % 256])))
        asks = (registry.head, lambda: registry.checkpoint([first]))
        found.append([values_of(ask) for ask in asks])
    assert all(few < many < 4 * few for few, many in zip(*found, strict=True)), found
