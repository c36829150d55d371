"""The payload of a badge: given, or derived from the name.

A derived payload makes the same badge from the same name, byte for byte.  It is no secret: whoever knows a name can
print its pattern, and only a registry says which badge was issued.  `attempt` counts on where a registry has given
the first choice to somebody else.
"""

from __future__ import annotations

import hashlib

from moireid.designer.request import clean_name
from moireid.errors import CodeError
from moireid.idcodes.words import PAYLOAD_BYTES


def payload_for_name(name: str, *, attempt: int = 0) -> bytes:
    """The first bytes of SHA-256 over the cleaned name and the attempt: `PAYLOAD_BYTES` of them."""
    seed = f"moireid/pitch/{attempt}/{clean_name(name)}"
    return hashlib.sha256(seed.encode()).digest()[:PAYLOAD_BYTES]


def payload_from_hex(text: str) -> bytes:
    """The payload that hex digits name.  Raises: CodeError where they are not the digits of a pitch code."""
    digits = PAYLOAD_BYTES * 2
    try:
        payload = bytes.fromhex(text) if len(text) == digits else b""
    except ValueError:
        payload = b""
    if not payload:
        raise CodeError(
            f"payload {text[:40]!r} is not possible; the pitch code carries {digits * 4} bits, so give {digits} hex "
            "digits such as 3fa20c"
        )
    return payload
