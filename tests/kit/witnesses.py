"""The root over a log's leaves, and witnesses who add their lines to a checkpoint, as programs of others do."""

from __future__ import annotations

import base64
import hashlib
import time
from collections.abc import Sequence
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from moireid.registry.merkle import Place, ReadNodes, Tree


def nodes_over(leaves: Sequence[bytes]) -> dict[Place, bytes]:
    """All nodes of the tree over these leaves."""
    tree, found = Tree(), {(0, place): leaf for place, leaf in enumerate(leaves)}
    for leaf in leaves:
        found |= tree.add(leaf)
    return found


def reading(leaves: Sequence[bytes]) -> ReadNodes:
    """The nodes over these leaves, as `merkle` looks them up."""
    nodes = nodes_over(leaves)
    return lambda places: nodes


def root_of(leaves: Sequence[bytes]) -> bytes:
    """The root of these leaves."""
    tree = Tree()
    for leaf in leaves:
        tree.add(leaf)
    return tree.root()


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
