"""The root over a log's leaves, and witnesses who add their lines to a checkpoint, as programs of others do."""

from __future__ import annotations

import base64
import hashlib
import time
from collections.abc import Sequence
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from moireid.registry.merkle import Tree, node_hash


def root_of(leaves: Sequence[bytes]) -> bytes:
    """The root of these leaves."""
    return Tree(leaves).root()


def consistent(first: int, first_root: bytes, second: int, second_root: bytes, proof: Sequence[bytes]) -> bool:
    """Whether the tree of `second` leaves holds that of `first` leaves, at least one, as its beginning.

    Source: RFC 9162, section 2.1.4.2, as a witness checks it.
    """
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


class Witness:
    """A witness who signs whatever it is given; written from the specification, with no code of moireid.

    Source: C2SP tlog-cosignature v1 and signed-note.
    """

    def __init__(self, name: str) -> None:
        self.name, self._key = name, Ed25519PrivateKey.generate()
        self._public = b"\x04" + self._key.public_key().public_bytes_raw()
        self._id = hashlib.sha256(name.encode() + b"\n" + self._public).digest()[:4]

    @property
    def key(self) -> str:
        """Its public key, as its operator shows it."""
        return f"{self.name}+{self._id.hex()}+{base64.b64encode(self._public).decode()}"

    def line(self, text: str, at: float | None = None) -> str:
        """Its signature of a checkpoint's text, at a time in seconds since 1970, now by default."""
        when = int(time.time() if at is None else at)
        signature = self._key.sign(f"cosignature/v1\ntime {when}\n{text}".encode())
        content = self._id + when.to_bytes(8, "big") + signature
        return f"\u2014 {self.name} {base64.b64encode(content).decode()}\n"

    def sign(self, path: Path) -> None:
        """Add its line to a checkpoint's file."""
        note = path.read_text(encoding="utf-8")
        path.write_text(note + self.line(note.partition("\n\n")[0] + "\n"), encoding="utf-8")
