"""The request `add-checkpoint`: the size that the witness knows, a consistency proof from it, and the checkpoint.

Source: C2SP tlog-witness, https://c2sp.org/tlog-witness.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass

#: Where a witness takes requests, below its address; the type of the answer that names a size.
PATH, SIZE_TYPE = "/add-checkpoint", "text/x.tlog.size"
#: Longest request, bytes, and most hashes of a proof, as C2SP limits them.
MOST_BYTES, MOST_STEPS = 65536, 63
_SIZE = re.compile(r"0|[1-9]\d{0,17}", re.ASCII)


@dataclass(frozen=True)
class AddRequest:
    """A log's request; old: the size of the newest checkpoint that the witness signed, 0 for none."""

    old: int
    proof: Sequence[bytes]
    note: str

    def to_bytes(self) -> bytes:
        """As it is sent."""
        steps = "".join(f"{base64.b64encode(step).decode()}\n" for step in self.proof)
        return f"old {self.old}\n{steps}\n{self.note}".encode()

    @classmethod
    def parse(cls, content: bytes) -> AddRequest:
        """The request that was sent.  Raises: ValueError, in a few words, if it is none."""
        head, gap, note = content.decode().partition("\n\n")
        first, *steps = head.split("\n")
        if not gap or not first.startswith("old ") or len(steps) > MOST_STEPS:
            raise ValueError("it does not begin with the old size, at most 63 hashes and an empty line")
        proof = [base64.b64decode(step, validate=True) for step in steps]
        if any(len(step) != 32 for step in proof):
            raise ValueError("a hash of its proof is not of 32 bytes")
        return cls(size_of(first.removeprefix("old ")), proof, note)


def size_of(text: str) -> int:
    """The size that a text writes, in decimal digits without leading zeros.  Raises: ValueError if it is none."""
    if _SIZE.fullmatch(text) is None:
        raise ValueError(f"{text[:40]!r} is no size")
    return int(text)
