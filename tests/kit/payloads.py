"""A fixed payload for a name, so that a test's badge is the same in every run.

The program draws identities by chance; tests give theirs.
"""

from __future__ import annotations

import hashlib


def payload_for_name(name: str, *, attempt: int = 0, family: str = "spacing") -> bytes:
    """A payload of 8 bytes, or 3 of the pitch family."""
    digest = hashlib.sha256(f"moireid/{family}/{attempt}/{name}".encode()).digest()
    return digest[: {"spacing": 8, "pitch": 3}[family]]
