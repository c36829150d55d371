"""The Merkle tree of RFC 6962 (section 2.1), with SHA-256: roots, and proofs of inclusion and consistency.

A node is the root of a whole subtree of 2^level leaves; node (level, place) covers those from place * 2^level on, and
level 0 are the leaves.  A range of leaves falls into at most two nodes of each level, so that every root and every
proof needs a number of nodes that grows with the logarithm of the tree's size.

Convention: the byte 0 is hashed before a leaf's content, and the byte 1 before two nodes, so that no leaf can be taken
for a node.  Places count from 0.  Hashes of leaves (`leaf_hash`) are handed over, not their contents.
The maintained package for this, pymerkle, is under the GPL, which this project's licence does not allow.
Source: RFC 6962, sections 2.1.1 and 2.1.2; the checks of proofs are those of RFC 9162, sections 2.1.3.2 and 2.1.4.2.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence

#: Level and place of a node.
Place = tuple[int, int]
#: Looks up the nodes at some places, each of which it must have.
ReadNodes = Callable[[Sequence[Place]], Mapping[Place, bytes]]


def leaf_hash(content: bytes) -> bytes:
    """The hash of a leaf."""
    return hashlib.sha256(b"\0" + content).digest()


def node_hash(left: bytes, right: bytes) -> bytes:
    """The hash of the node above two others."""
    return hashlib.sha256(b"\1" + left + right).digest()


class Tree:
    """A tree that grows leaf by leaf and keeps no more than one hash for each of its levels.

    Parameters: size: of the tree that it begins as; peaks: the nodes at `subtrees(0, size)`.
    """

    def __init__(self, size: int = 0, peaks: Iterable[bytes] = ()) -> None:
        self.size = size
        self._peaks = list(peaks)

    def add(self, leaf: bytes) -> dict[Place, bytes]:
        """Add the hash of the next leaf; returns the nodes above the leaves that are whole with it."""
        place, level, made = self.size, 0, {}
        while place & 1:
            leaf = node_hash(self._peaks.pop(), leaf)
            place, level = place >> 1, level + 1
            made[level, place] = leaf
        self._peaks.append(leaf)
        self.size += 1
        return made

    def root(self) -> bytes:
        """The root of all leaves so far; that of no leaves is the hash of nothing."""
        return _joined(self._peaks)


def _joined(peaks: Sequence[bytes]) -> bytes:
    """The root over the nodes of a range, the largest first."""
    if not peaks:
        return hashlib.sha256().digest()
    root = peaks[-1]
    for peak in reversed(peaks[:-1]):
        root = node_hash(peak, root)
    return root


def subtrees(begin: int, end: int) -> list[Place]:
    """The nodes of the leaves from `begin` to before `end`, where the tree splits off such a range; largest first."""
    found = []
    while begin < end:
        level = (end - begin).bit_length() - 1
        found.append((level, begin >> level))
        begin += 1 << level
    return found


def inclusion_proof(read: ReadNodes, size: int, place: int) -> list[bytes]:
    """The hashes that lead from the leaf at `place` to the root of `size` leaves.

    Raises: IndexError if there is no such leaf.
    """
    if not 0 <= place < size:
        raise IndexError(f"there is no leaf {place} among {size}")
    begin, end, ranges = 0, size, []
    while end - begin > 1:
        split = begin + _split(end - begin)
        if place < split:
            ranges.append((split, end))
            end = split
        else:
            ranges.append((begin, split))
            begin = split
    return _hashes(read, ranges[::-1])


def consistency_proof(read: ReadNodes, size: int, first: int) -> list[bytes]:
    """The hashes that show that the first leaves of `size` are those of before.

    Raises: IndexError if there are not so many.
    """
    if not 0 < first <= size:
        raise IndexError(f"there are no first {first} among {size} leaves")
    begin, end, ranges = 0, size, []
    while first < end:
        split = begin + _split(end - begin)
        if first <= split:
            ranges.append((split, end))
            end = split
        else:
            ranges.append((begin, split))
            begin = split
    # Where the old tree is one node of the new one, its root is known.
    return _hashes(read, ([(begin, end)] if begin else []) + ranges[::-1])


def _hashes(read: ReadNodes, ranges: Sequence[tuple[int, int]]) -> list[bytes]:
    """The roots over ranges of leaves, all nodes of which are read at once."""
    places = [subtrees(*one) for one in ranges]
    nodes = read([place for some in places for place in some])
    return [_joined([nodes[place] for place in some]) for some in places]


def included(leaf: bytes, place: int, size: int, proof: Sequence[bytes], root: bytes) -> bool:
    """Whether the leaf of this hash is at `place` in the tree of `size` leaves that has this root."""
    if not 0 <= place < size:
        return False
    at, last, found = place, size - 1, leaf
    for step in proof:
        if last == 0:
            return False
        if at & 1 or at == last:
            found = node_hash(step, found)
            while not at & 1 and at:
                at, last = at >> 1, last >> 1
        else:
            found = node_hash(found, step)
        at, last = at >> 1, last >> 1
    return last == 0 and found == root


def consistent(first: int, first_root: bytes, second: int, second_root: bytes, proof: Sequence[bytes]) -> bool:
    """Whether the tree of `second` leaves holds that of `first` leaves, at least one, as its beginning."""
    if first == second:
        return not proof and first_root == second_root
    if not 0 < first < second or not proof:
        return False
    steps = [first_root, *proof] if first & (first - 1) == 0 else list(proof)
    at, last = first - 1, second - 1
    while at & 1:
        at, last = at >> 1, last >> 1
    old = new = steps[0]
    for step in steps[1:]:
        if last == 0:
            return False
        if at & 1 or at == last:
            old, new = node_hash(step, old), node_hash(step, new)
            while not at & 1 and at:
                at, last = at >> 1, last >> 1
        else:
            new = node_hash(new, step)
        at, last = at >> 1, last >> 1
    return last == 0 and (old, new) == (first_root, second_root)


def _split(size: int) -> int:
    """The largest power of two below `size`, which is 2 or more."""
    return 1 << (size - 1).bit_length() - 1
