"""What the process with the key signs: the few kinds of things that an authority ever signs, each in its own form.

So whoever asks gets no signature over anything of their own making, such as a text that another program would believe.
"""

from __future__ import annotations

import json
import re

from moireid.registry.keys import ENTRY, HEAD, NOTE, RECORD

#: Kinds by their names in messages.
DOMAINS = {"record": RECORD, "entry": ENTRY, "head": HEAD, "note": NOTE}
NAMES = {domain: name for name, domain in DOMAINS.items()}
#: Longest content, bytes: a record's text holds digests in the place of documents, and a note is shorter.
LONGEST = 65536
#: First lines of notes (`checkpoints/checkpoint.py`, `bundle/parcel.py`), before the authority's fingerprint.
NOTE_ORIGINS = ("moireid/registry/", "moireid/bundle/")
_HASH, _HEAD = re.compile(rb"[0-9a-f]{64}"), re.compile(rb"[1-9]\d{0,17}:[0-9a-f]{64}")


def of_kind(kind: object, content: bytes, fingerprint: str) -> bool:
    """Whether the content has the form of its kind, for the authority of that fingerprint."""
    if kind == "entry":
        return _HASH.fullmatch(content) is not None
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
