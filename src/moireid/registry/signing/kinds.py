"""What the process with the key signs: the few kinds of things that an authority ever signs, each in its own form.

So whoever asks gets no signature over anything of their own making, such as a text that another program would believe.
A log entry comes whole, because its hash alone would not say whether it gives the log to another key.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from moireid.registry.canonical import canonical_json
from moireid.registry.keys import ACTED, ENTRY, HEAD, NOTE, RECORD
from moireid.registry.log import HASHED, ROTATE, ROTATED

#: Kinds by their names in messages; an entry is the fourth, `LOG_ENTRY`.
DOMAINS = {"record": RECORD, "head": HEAD, "note": NOTE}
LOG_ENTRY = "entry"
NAMES = {domain: name for name, domain in DOMAINS.items()}
#: Longest content, bytes: a record's text holds digests in the place of documents, and a note is shorter.
LONGEST = 65536
#: First lines of notes (`checkpoints/checkpoint.py`, `bundle/parcel.py`), before the authority's fingerprint.
NOTE_ORIGINS = ("moireid/registry/", "moireid/bundle/")
_HEAD = re.compile(rb"[1-9]\d{0,17}:[0-9a-f]{64}")
_TURN = re.compile(f"{ROTATED}([0-9a-f]{{64}}):([0-9a-f]{{64}})")


def of_kind(kind: object, content: bytes, fingerprint: str) -> bool:
    """Whether the content has the form of its kind, for the authority of that fingerprint."""
    if kind == "head":
        return _HEAD.fullmatch(content) is not None
    if kind == "note":
        first = content.partition(b"\n")[0]
        return first in [f"{origin}{fingerprint}".encode() for origin in NOTE_ORIGINS]
    return kind == "record" and _is_record(content)


def _is_record(content: bytes) -> bool:
    """Whether it is the text of a record, as `Record.signed_text` writes it."""
    try:
        fields = json.loads(content)
    except (ValueError, RecursionError):
        return False
    return isinstance(fields, dict) and {"badge_sha256", "id", "issued_at", "layout_key", "name"} <= set(fields)


def entry_of(content: bytes) -> dict[str, Any] | None:
    """The log entry whose hashed text (`log.entry_text`) this is; None where it is none."""
    domain, fields = (ACTED, {*HASHED, "actor"}) if content.startswith(ACTED) else (ENTRY, set(HASHED))
    try:
        entry = json.loads(content.removeprefix(domain))
        # One spelling alone: what is looked at here must be what others read.
        whole = isinstance(entry, dict) and domain + canonical_json(entry).encode() == content
    except (ValueError, RecursionError):
        return None
    if not whole or set(entry) != fields or not isinstance(entry["seq"], int):
        return None
    texts = all(isinstance(value, str) for name, value in entry.items() if name != "seq")
    return entry if texts and (entry["action"] == ROTATE) is entry["subject"].startswith(ROTATED) else None


def turn_of(entry: Mapping[str, Any]) -> tuple[str, str] | None:
    """The public keys, old and new, of an entry that changes the key; None where it does not say them."""
    found = _TURN.fullmatch(entry["subject"])
    return None if found is None else (found[1], found[2])
