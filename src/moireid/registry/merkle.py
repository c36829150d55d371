"""The Merkle tree of RFC 6962 (section 2.1), with SHA-256: roots, and proofs of consistency.

Convention: the byte 0 is hashed before a leaf's content, and the byte 1 before two nodes, so that no leaf can be taken
for a node.  Hashes of leaves (`leaf_hash`) are handed over, not their contents.
The maintained package for this, pymerkle, is under the GPL, which this project's licence does not allow.
Source: RFC 6962, sections 2.1 and 2.1.2.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence


def leaf_hash(content: bytes) -> bytes:
    """The hash of a leaf."""
    return hashlib.sha256(b"\0" + content).digest()


def node_hash(left: bytes, right: bytes) -> bytes:
    """The hash of the node above two others."""
    return hashlib.sha256(b"\1" + left + right).digest()


class Tree:
    """A tree that grows leaf by leaf and keeps no more than one hash for each of its levels."""

    def __init__(self, leaves: Iterable[bytes] = ()) -> None:
        self.size = 0
        #: The roots of whole subtrees, the largest first.
        self._peaks: list[bytes] = []
        for leaf in leaves:
            self.add(leaf)

    def copy(self) -> Tree:
        """A tree of the same leaves that grows by itself."""
        other = Tree()
        other.size, other._peaks = self.size, list(self._peaks)
        return other

    def add(self, leaf: bytes) -> None:
        """Add the hash of the next leaf."""
        place = self.size
        while place & 1:
            leaf, place = node_hash(self._peaks.pop(), leaf), place >> 1
        self._peaks.append(leaf)
        self.size += 1

    def root(self) -> bytes:
        """The root of all leaves so far; that of no leaves is the hash of nothing."""
        if not self._peaks:
            return hashlib.sha256().digest()
        *others, root = self._peaks
        for peak in reversed(others):
            root = node_hash(peak, root)
        return root


def consistency_proof(leaves: Sequence[bytes], first: int) -> list[bytes]:
    """The hashes that show that the first leaves, at least one and not more than there are, are those of before."""
    begin, end, proof = 0, len(leaves), list[bytes]()
    while first < end:
        split = begin + (1 << (end - begin - 1).bit_length() - 1)
        if first <= split:
            proof.append(Tree(leaves[split:end]).root())
            end = split
        else:
            proof.append(Tree(leaves[begin:split]).root())
            begin = split
    # Where the old tree is one node of the new one, its root is known.
    return ([Tree(leaves[begin:end]).root()] if begin else []) + proof[::-1]
