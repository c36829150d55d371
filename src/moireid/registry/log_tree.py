"""The Merkle tree over the log's entries, as it is stored: the one structure that makes the log tamper-evident.

Leaves are the hashes in the table `log`; the nodes above them are in the table `nodes`, each written once, together
with the entry that makes its subtree whole.  So head, proofs and a new entry need as many rows as the tree has levels.

Nodes are not signed.  They are believed only as far as they lead to the signed root: whoever changes one can make a
registry unreadable, which they can do anyway, and can make nothing pass.  The audit computes them all anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

from sqlalchemy import Connection, delete, func, insert, select

from moireid.registry.engine import chunks
from moireid.registry.log import Head, check_hash, check_order, leaf_of
from moireid.registry.merkle import (
    Place,
    Tree,
    consistency_proof,
    consistent,
    included,
    inclusion_proof,
    subtrees,
)
from moireid.registry.record import Fault
from moireid.registry.schema import log, nodes, nodes_at, pages, select_nodes

#: Length of each node and leaf: a longer one could hold two, and give a root that no log has.
HASH_BYTES = 32


class LogTree:
    """The tree over a log up to its signed head, as one transaction sees it.

    Parameters
    ----------
    connection : Connection
        Of that transaction.
    head : Head
        Signed by the authority.
    """

    def __init__(self, connection: Connection, head: Head) -> None:
        self._connection = connection
        self.head, self.size = head, head.seq

    @cached_property
    def root(self) -> bytes:
        """The root over all entries.  Raises: Fault if what was signed is none."""
        try:
            return bytes.fromhex(self.head.hash)
        except ValueError as error:
            raise Fault("head_signature", "the log's head is none") from error

    def inclusion(self, seq: int, entry_hash: str) -> list[bytes] | None:
        """The proof that an entry is in the log at its number; None if it is not there."""
        proof = inclusion_proof(self._read, self.size, seq - 1)
        return proof if included(leaf_of(entry_hash), seq - 1, self.size, proof, self.root) else None

    def consistency(self, size: int, root: bytes) -> list[bytes] | None:
        """The proof that the log goes on from its first `size` entries, which have this root; None if it does not."""
        if not 0 < size <= self.size:
            return None
        proof = consistency_proof(self._read, self.size, size)
        return proof if consistent(size, root, self.size, self.root, proof) else None

    def entries(self, begin: int = 1) -> Iterator[dict[str, Any]]:
        """The entries from the one of number `begin` to the head, each checked but for its signature.

        Raises: Fault if one was changed or taken out; at the end, if they are not those of the signed head.
        """
        tree = self._beginning(begin - 1)
        query = select(log).where(log.c.seq >= begin, log.c.seq <= self.size)
        for row in pages(self._connection, query, log.c.seq):
            entry = dict(row._mapping)
            check_order(entry, tree.size)
            tree.add(leaf_of(check_hash(entry)))
            yield entry
        if tree.root() != self.root:
            raise Fault("log_cut", f"the log's entries from {begin} on are not those of its signed head")

    def newest_entry(self, subject: str, record_sha256: str) -> int:
        """The number of the newest entry about a record.

        Every entry from there to the head is looked at, as the database's index may hide one.
        Raises: Fault if it is about another version than the one of this hash, or an entry on the way was changed.
        """
        newest = self._connection.scalar(select(func.max(log.c.seq)).where(log.c.subject == subject))
        if newest is None:
            raise Fault("record_unlogged", f"the log has no entry for the record of id {subject}")
        for entry in self.entries(newest):
            about = entry["subject"] == subject
            if about != (entry["seq"] == newest) or (about and entry["record_sha256"] != record_sha256):
                raise Fault("record_stale", f"the record of id {subject} is not the version that the log has last")
        return int(newest)

    def leads_from(self, seen: Head) -> bool:
        """Whether the log goes on from an earlier head."""
        return seen == self.head or self.consistency(seen.seq, bytes.fromhex(seen.hash)) is not None

    def growing(self) -> Tree:
        """The tree as new entries are added to it.  Raises: Fault if the stored nodes do not lead to the root."""
        tree = self._beginning(self.size)
        if tree.root() != self.root:
            raise Fault("tree_node", "the nodes of the log's tree do not lead to its signed head")
        return tree

    def _beginning(self, size: int) -> Tree:
        """The tree over the first entries."""
        places = subtrees(0, size)
        found = self._read(places)
        return Tree(size, [found[place] for place in places])

    def _read(self, places: Sequence[Place]) -> Mapping[Place, bytes]:
        return read_nodes(self._connection, places)


def read_nodes(connection: Connection, places: Sequence[Place]) -> dict[Place, bytes]:
    """The nodes at these places as they are stored.  Raises: Fault if one is missing or damaged."""
    leaves = [place + 1 for level, place in places if level == 0]
    inner = [place for place in places if place[0] > 0]
    found = dict[Place, bytes]()
    if leaves:
        rows = connection.execute(select(log.c.seq, log.c.hash).where(log.c.seq.in_(leaves)))
        found |= {(0, row.seq - 1): leaf_of(row.hash) for row in rows}
    if inner:
        rows = connection.execute(select_nodes(inner))
        try:
            found |= {(row.level, row.place): bytes.fromhex(row.hash) for row in rows}
        except (TypeError, ValueError) as error:
            raise Fault("tree_node", "a node of the log's tree is damaged") from error
    if any(len(node) != HASH_BYTES for node in found.values()):
        raise Fault("tree_node", "a node of the log's tree is damaged")
    for level, place in places:
        if (level, place) not in found:
            what = "a log entry" if level == 0 else "a node of the log's tree"
            raise Fault("tree_node", f"{what} is missing: number {place} of level {level}")
    return found


def store_nodes(connection: Connection, found: Mapping[Place, bytes]) -> None:
    """Store the nodes above the leaves, in place of any that are there."""
    for some in chunks(place for place in found if place[0]):
        connection.execute(delete(nodes).where(nodes_at(some)))
        rows = [{"level": level, "place": place, "hash": found[level, place].hex()} for level, place in some]
        connection.execute(insert(nodes), rows)


def grow(connection: Connection, tree: Tree) -> Head:
    """Add the entries of the log that follow those of `tree`, and store the nodes that they make; returns the head."""
    for some in chunks(pages(connection, select(log).where(log.c.seq > tree.size), log.c.seq)):
        made = dict[Place, bytes]()
        for row in some:
            made |= tree.add(leaf_of(row.hash))
        store_nodes(connection, made)
    return Head(tree.size, tree.root().hex())
