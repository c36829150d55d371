"""Documents as bytes: one spelling for signing, and a packed form for storing.

Convention: canonical JSON has its keys in code-point order, no white space, letters as they are (UTF-8), and numbers as
Python writes them; NaN and infinity are refused.  Reading such a text and writing it again gives the same text.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from datetime import UTC, datetime

#: Largest unpacked document, bytes; a larger one cannot be a badge, and may be meant to fill the memory.
UNPACKED_LIMIT = 64 * 2**20


# Made once: `json.dumps` would make one for each of a log's entries.
_ENCODER = json.JSONEncoder(sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def canonical_json(document: object) -> str:
    """The canonical text of a JSON document.  Raises: ValueError for NaN and infinity, TypeError for bytes."""
    return _ENCODER.encode(document)


def sha256_hex(content: bytes | memoryview) -> str:
    """SHA-256 as 64 lower-case hex digits."""
    return hashlib.sha256(content).hexdigest()


def pack(text: str) -> bytes:
    """A document's text as it is stored; a badge of 100 cells shrinks from 13 kB to 1 kB."""
    return zlib.compress(text.encode())


def unpack(content: object) -> str:
    """The text that `pack` stored.  Raises: ValueError if `content` is anything else."""
    if not isinstance(content, bytes | memoryview):
        raise ValueError("a document is not stored as bytes")
    packed = zlib.decompressobj()
    try:
        text = packed.decompress(content, UNPACKED_LIMIT)
    except zlib.error as error:
        raise ValueError("a document cannot be unpacked") from error
    if not packed.eof or packed.unused_data:
        raise ValueError("a document is cut, or longer than it may be")
    return text.decode()


def utc_now() -> str:
    """Now as it is written in records and log: UTC, ISO 8601 to the second, such as 2026-01-31T12:00:00Z."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
