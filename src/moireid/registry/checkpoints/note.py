"""Signed notes: a text, an empty line, and lines of signatures.

Convention: the signature is Ed25519's over the text alone.  A text begins with its origin, `moireid/...`, and nothing
else that an authority signs begins so; so none can be taken for another (`keys.py`).
Source: C2SP signed-note v1.0.0, https://c2sp.org/signed-note.
"""

from __future__ import annotations

import base64
import binascii
import hashlib

from moireid.registry.keys import NOTE, Authority, Signs

#: The mark before each signature, and the type of Ed25519 signatures.
DASH, ED25519 = "\u2014 ", b"\x01"
#: Signatures looked at; a note may bear those of witnesses too, and at least 16 must be read.
MOST_SIGNATURES = 64


def key_id(name: str, public: bytes) -> bytes:
    """Four bytes that distinguish one signer's line from another's; no proof of anything."""
    return hashlib.sha256(name.encode() + b"\n" + ED25519 + public).digest()[:4]


def signed_note(text: str, name: str, signer: Signs) -> str:
    """The note of a text that ends in a newline, signed under a key name without spaces and plus signs."""
    signature = bytes.fromhex(signer.sign(NOTE, text.encode()))
    own = key_id(name, bytes.fromhex(signer.authority.public_hex))
    return f"{text}\n{DASH}{name} {base64.b64encode(own + signature).decode()}\n"


def parted(note: str) -> tuple[str, list[str]]:
    """Text and signature lines of a note, not checked.  Raises: ValueError if it is none."""
    text, gap, lines = note.rpartition("\n\n")
    if not gap or not lines.startswith(DASH) or not lines.endswith("\n"):
        raise ValueError("it is no signed note")
    if any(letter < " " and letter != "\n" for letter in note):
        raise ValueError("it holds control characters")
    return text + "\n", lines[:-1].split("\n")[:MOST_SIGNATURES]


def opened(note: str, name: str, authority: Authority) -> str:
    """The text of a note that the authority signed under this name; the lines of other signers are passed over.

    Raises: ValueError if it is no note, or does not bear that signature.
    """
    text, lines = parted(note)
    own = key_id(name, bytes.fromhex(authority.public_hex))
    for line in lines:
        try:
            who, packed = line.removeprefix(DASH).split(" ")
            content = base64.b64decode(packed, validate=True)
        except (ValueError, binascii.Error) as error:
            raise ValueError("a line of its signatures is damaged") from error
        if who == name and content[:4] == own:
            if not authority.signed(NOTE, text.encode(), content[4:].hex()):
                raise ValueError(f"the signature of {name} does not fit it")
            return text
    raise ValueError(f"it does not bear the signature of {name}")
