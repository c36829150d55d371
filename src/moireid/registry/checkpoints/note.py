"""Signed notes: a text, an empty line, and lines of signatures; and the keys of those who sign them.

Convention: the signature is Ed25519's over the text alone.  A text begins with its origin, `moireid/...`, and nothing
else that an authority signs begins so; so none can be taken for another (`keys.py`).
Source: C2SP signed-note v1.0.0, https://c2sp.org/signed-note.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
from dataclasses import dataclass

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from moireid.errors import SpecError
from moireid.registry.keys import NOTE, Authority, Signer

#: The mark before each signature.
DASH = "\u2014 "
#: Types of signatures: of a log over a note, and of a witness over a checkpoint (`cosignature.py`).
ED25519, COSIGNATURE = b"\x01", b"\x04"
#: Signatures looked at; a note may bear those of witnesses too, and at least 16 must be read.
MOST_SIGNATURES = 64


@dataclass(frozen=True)
class VerifierKey:
    """The public key of one who signs notes, under a name and for one type of signature.

    Convention: written NAME+ID+KEY, the id in hex, the key with its type in base64, as signed-note describes.
    """

    name: str
    kind: bytes
    public: bytes

    @classmethod
    def parse(cls, text: str) -> VerifierKey:
        """The key that a text writes.  Raises: SpecError if it writes none of Ed25519."""
        name, _, rest = text.strip().partition("+")
        digits, _, packed = rest.partition("+")
        try:
            content = base64.b64decode(packed, validate=True)
            if not name or not name.isprintable() or "+" in name or any(map(str.isspace, name)):
                raise ValueError("its name is empty, or holds a blank, a plus or a control character")
            found = cls(name, content[:1], content[1:])
            if found.kind not in (ED25519, COSIGNATURE) or found.id.hex() != digits:
                raise ValueError("its type or its id is another")
            Ed25519PublicKey.from_public_bytes(found.public)
        except ValueError as error:
            raise SpecError(
                f"{text[:80]!r} is no public key of a log or a witness ({error}); give one as its operator shows it, "
                "NAME+ID+KEY"
            ) from error
        return found

    def __str__(self) -> str:
        return f"{self.name}+{self.id.hex()}+{base64.b64encode(self.kind + self.public).decode()}"

    @property
    def id(self) -> bytes:
        """Four bytes that distinguish one signer's line from another's; no proof of anything."""
        return hashlib.sha256(self.name.encode() + b"\n" + self.kind + self.public).digest()[:4]

    def line(self, signature: bytes) -> str:
        """The line of a signature, with its newline."""
        return f"{DASH}{self.name} {base64.b64encode(self.id + signature).decode()}\n"


def authority_key(name: str, authority: Authority) -> VerifierKey:
    """The key of an authority under a name."""
    return VerifierKey(name, ED25519, bytes.fromhex(authority.public_hex))


def signed_note(text: str, name: str, signer: Signer) -> str:
    """The note of a text that ends in a newline, signed under a key name without spaces and plus signs."""
    signature = bytes.fromhex(signer.sign(NOTE, text.encode()))
    return f"{text}\n{authority_key(name, signer.authority).line(signature)}"


def parted(note: str) -> tuple[str, list[str]]:
    """Text and signature lines of a note, not checked.  Raises: ValueError if it is none."""
    text, gap, lines = note.rpartition("\n\n")
    if not gap or not lines.startswith(DASH) or not lines.endswith("\n"):
        raise ValueError("it is no signed note")
    if any(letter < " " and letter != "\n" for letter in note):
        raise ValueError("it holds control characters")
    return text + "\n", lines[:-1].split("\n")[:MOST_SIGNATURES]


def signatures_of(key: VerifierKey, lines: list[str]) -> list[bytes]:
    """The signatures on these lines that name the key, not checked.  Raises: ValueError if a line is damaged."""
    found = []
    for line in lines:
        try:
            who, packed = line.removeprefix(DASH).split(" ")
            content = base64.b64decode(packed, validate=True)
        except (ValueError, binascii.Error) as error:
            raise ValueError("a line of its signatures is damaged") from error
        if (who, content[:4]) == (key.name, key.id):
            found.append(content[4:])
    return found


def opened(note: str, name: str, authority: Authority) -> str:
    """The text of a note that the authority signed under this name; the lines of other signers are passed over.

    Raises: ValueError if it is no note, or does not bear that signature.
    """
    text, lines = parted(note)
    found = signatures_of(authority_key(name, authority), lines)
    if not found:
        raise ValueError(f"it does not bear the signature of {name}")
    if not all(authority.signed(NOTE, text.encode(), one.hex()) for one in found):
        raise ValueError(f"the signature of {name} does not fit it")
    return text
