"""The content credentials that a film carries already, as a note in the report.

They say who vouches for a file, and nothing about the badge.  So they count neither for a film nor against it.
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from moireid.attest.credentials_work import UNREADABLE, read
from moireid.errors import MediaError
from moireid.files import open_regular
from moireid.verifier.reasons import Reason

#: More top-level boxes than this are not looked through: a fragmented film has some for each second.
MOST_BOXES = 100_000


def with_carried(document: dict[str, Any], film: Path) -> dict[str, Any]:
    """A report's JSON with a note of the credentials that its film carries; as it was where there are none.

    Without c2pa-python they are not looked for.
    """
    if not may_carry(film) or find_spec("c2pa") is None or not (found := _read_apart(film)):
        return document
    state = found["state"]
    who = f"signed by {found['signer']!r}" if found["signer"] else "without a signer's name"
    words = {
        "Trusted": "they hold, and their certificate is trusted",
        "Valid": "they hold, by a certificate that is on no trust list known here",
    }.get(state, "they do not hold: the film or they were changed")
    text = f"The film carries content credentials, {who}; {words}. They are no part of the verdict."
    note = Reason("content_credentials", "note", state, None, "", text)
    return document | {"reasons": [*document["reasons"], note.to_json()]}


def _read_apart(film: Path) -> dict[str, Any]:
    """The credentials of a film, as a sealed process reads them: what is damaged may end c2pa-python, and its process.

    Where no process can be sealed at all, on Windows, this one reads them.
    """
    if os.name == "nt":
        return read(film) or {}
    # Loaded here: it brings what signs, and most films carry nothing.
    from moireid.attest.credentials import talk_with

    found: dict[str, Any] = {}
    try:
        talk_with("moireid.attest.credentials_work:read_film", film, film, found.update)
    except MediaError:
        return UNREADABLE
    return found


def may_carry(film: Path) -> bool:
    """Whether a film may carry credentials; an MP4 or QuickTime file without their box does not.

    Loading c2pa-python takes longer than this look at the boxes.
    Source: C2PA specification 2.2, A.5.1: in files of the ISO base media format credentials are in a `uuid` box next
        to `moov`; so is the XMP that points to them elsewhere.
    """
    with open_regular(film) as stream:
        end = stream.seek(0, 2)
        place = 0
        for box in range(MOST_BOXES):
            stream.seek(place)
            head = stream.read(16)
            if head[4:8] == b"uuid" or (box == 0 and head[4:8] != b"ftyp"):
                return True
            size = int.from_bytes(head[:4])
            if size == 1:
                size = int.from_bytes(head[8:])
            # A size of 0 is that of a last box, which reaches to the end.
            place += size or end - place
            if place >= end:
                return False
            if 0 < size < 8:
                return True
    return True
