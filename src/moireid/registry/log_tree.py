"""The Merkle tree over the log's entries, as it is stored: the one structure that makes the log tamper-evident.

Leaves are the hashes in the table `log`; the nodes above them are in the table `nodes`, each written once, together
with the entry that makes its subtree whole.  So head, proofs and a new entry need as many rows as the tree has levels.

Nodes are not signed.  They are believed only as far as they lead to the signed root: whoever changes one can make a
registry unreadable, which they can do anyway, and can make nothing pass.  The audit computes them all anew.

A log from before the tree has no nodes until it is written to; they are then computed from its entries, each of which
is checked with the chain of hashes that such entries have.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

from sqlalchemy import Connection, delete, func, insert, select

from moireid.registry.engine import chunks
from moireid.registry.log import BEGINNING, Head, Link, followed, leaf_of
from moireid.registry.merkle import (
    Place,
    Tree,
    all_nodes,
    consistency_proof,
    consistent,
    included,
    inclusion_proof,
    root_at,
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
    chained : bool
        Whether the head is from before the tree.
    """

    def __init__(self, connection: Connection, head: Head, *, chained: bool) -> None:
        self._connection = connection
        self.head, self.size, self.chained = head, head.seq, chained

    @cached_property
    def root(self) -> bytes:
        """The root over all entries.  Raises: Fault if they do not lead to a head from before the tree."""
        if self.chained:
            return root_at(self._read, self.size)
        try:
            return bytes.fromhex(self.head.hash)
        except ValueError as error:
            raise Fault("head_signature", "the log's head is none") from error

    def check_end(self, last: Link) -> None:
        """Raise Fault unless the tree leads from the log's last entry to the root; a chained head names it itself."""
        if not self.chained and self.inclusion(last.seq, last.hash) is None:
            raise Fault("head_hash", f"the log's tree does not lead from entry {last.seq} to the signed head")

    def inclusion(self, seq: int, entry_hash: str | None) -> list[bytes] | None:
        """The proof that an entry is in the log at its number; None if it is not there."""
        proof = inclusion_proof(self._read, self.size, seq - 1)
        return proof if included(leaf_of(entry_hash), seq - 1, self.size, proof, self.root) else None

    def consistency(self, size: int, root: bytes) -> list[bytes] | None:
        """The proof that the log goes on from its first `size` entries, which have this root; None if it does not."""
        if not 0 < size <= self.size:
            return None
        proof = consistency_proof(self._read, self.size, size)
        return proof if consistent(size, root, self.size, self.root, proof) else None

    def is_over(self, last: Link, tree: Tree) -> bool:
        """Whether these are the last entry of the log, and the tree over all of its entries."""
        if self.chained:
            return last == Link(self.head.seq, self.head.hash)
        return (tree.size, tree.root()) == (self.size, self.root)

    def entries(self, begin: int = 1) -> Iterator[dict[str, Any]]:
        """The entries from the one of number `begin` to the head, each checked but for its signature.

        Raises: Fault if one was changed or taken out; at the end, if they are not those of the signed head.
        """
        tree = self._beginning(begin - 1)
        yield from self._followed(tree, BEGINNING if begin == 1 else Link(begin - 1, None), self.size)
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

    def versions(self) -> dict[str, str]:
        """The hash of each record's newest version by its id, from all entries.  Raises: Fault as `entries`."""
        return {entry["subject"]: entry["record_sha256"] for entry in self.entries()}

    def leads_from(self, seen: Head) -> bool:
        """Whether the log goes on from an earlier head, entry by entry.

        Raises: Fault if there is a gap, or an entry after the earlier head was changed.
        """
        if seen == self.head:
            return True
        if seen.seq > self.size:
            return False
        tree, last = self._beginning(seen.seq), Link(seen.seq, None)
        if tree.root().hex() != seen.hash:
            # A head from before the tree; or damaged nodes, without which it must do.
            tree, row = Tree(), None
            for row in self._followed(tree, BEGINNING, seen.seq):
                last = Link(row["seq"], row["hash"])
            ends = row is not None and row["previous"] and row["hash"] == seen.hash
            if not ends and tree.root().hex() != seen.hash:
                return False
        for _ in self._followed(tree, last, self.size):
            pass
        return tree.root() == self.root

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
        return self.computed if self.chained else read_nodes(self._connection, places)

    @cached_property
    def computed(self) -> dict[Place, bytes]:
        """All nodes of a log from before the tree, from its entries.  Raises: Fault if it does not lead to its head."""
        last = BEGINNING

        def leaves() -> Iterator[bytes]:
            nonlocal last
            for row in self._followed(Tree(), BEGINNING, self.size):
                last = Link(row["seq"], row["hash"])
                yield leaf_of(last.hash)

        found = all_nodes(leaves())
        if last != Link(self.head.seq, self.head.hash):
            raise Fault("log_cut", "the log does not lead to its signed head")
        return found

    def _followed(self, tree: Tree, last: Link, end: int) -> Iterator[dict[str, Any]]:
        """The entries after those of `tree` up to number `end`, each checked and added to it.

        Parameters: last: the entry before them.
        """
        query = select(log).where(log.c.seq > tree.size, log.c.seq <= end)
        for row in pages(self._connection, query, log.c.seq):
            entry = dict(row._mapping)
            last = followed(entry, last)
            tree.add(leaf_of(last.hash))
            yield entry


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
