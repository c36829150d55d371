"""The bundle's file: one line with its kind, a signed note (`checkpoints/checkpoint.py`), and the content.

The note contains the content's SHA-256, so a check of the note and of that digest covers every byte; and it contains
the public key, which counts only if its fingerprint is the trusted one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from moireid.errors import RegistryError
from moireid.registry.canonical import sha256_hex
from moireid.registry.checkpoints.checkpoint import opened, parted, signed_note
from moireid.registry.keys import Authority, Signs
from moireid.registry.log import Head

#: Origins of notes by the bundle's version.  The second is for bundles in which a badge is suspended or has a day of
#: expiry: programs that know neither refuse it, as they would take such a badge for valid.
ORIGINS = {1: "moireid/bundle/", 2: "moireid/bundle2/"}
STATES = 2
_FIRST = re.compile(rb"moireid bundle ([12]) (\d{6})\n")
#: Lines of the header after its origin, in this order.
_LINES = ("key", "issued", "expires", "head", "people", "length", "sha256")
TIME = "%Y-%m-%dT%H:%M:%SZ"


@dataclass(frozen=True)
class Header:
    """What the signed note says.

    Convention: times as in records; key: the authority's public key, 64 hex digits.
    """

    key: str
    issued: str
    expires: str
    head: str
    people: int
    length: int
    sha256: str
    version: int = 1

    def parcel(self, signer: Signs, content: bytes) -> bytes:
        """The whole file."""
        name = ORIGINS[self.version] + signer.authority.fingerprint
        text = "".join(f"{line} {getattr(self, line)}\n" for line in _LINES)
        note = signed_note(f"{name}\n{text}", name, signer).encode()
        return b"moireid bundle %d %06d\n" % (self.version, len(note)) + note + content


def opened_parcel(path: Path) -> tuple[Header, Authority, bytes]:
    """The header, its authority and the content of a bundle, every byte checked against the signature.

    Raises: RegistryError if the file cannot be read, is none, or was changed.
    """
    try:
        whole = path.read_bytes()
    except OSError as error:
        raise RegistryError(f"bundle {path} cannot be read ({error.strerror}); give the path of one") from error
    first = _FIRST.match(whole)
    if first is None:
        raise RegistryError(f"{path} is no bundle of a registry; give a file that `moireid registry publish` wrote")
    begin = first.end() + int(first[2])
    try:
        header, authority = _header(whole[first.end() : begin].decode(), int(first[1]))
        content = memoryview(whole)[begin:]
        if len(content) != header.length:
            raise ValueError(f"it has {len(content)} bytes of content, and {header.length} were signed")
        if sha256_hex(content) != header.sha256:
            raise ValueError("its content is another than was signed")
    except ValueError as error:
        raise RegistryError(
            f"bundle {path} is cut, changed or damaged ({error}); fetch it again, and ask its publisher if that fails"
        ) from error
    return header, authority, bytes(content)


def now() -> datetime:
    """This moment, UTC."""
    return datetime.now(UTC)


def check_expiry(header: Header, path: Path) -> None:
    """Raise RegistryError unless the bundle still counts."""
    if now() >= datetime.strptime(header.expires, TIME).replace(tzinfo=UTC):
        raise RegistryError(
            f"bundle {path} expired on {header.expires}, so it may lack revocations; fetch a newer one from where it "
            "is published",
            code="expired",
            expires=header.expires,
        )


def _header(note: str, version: int) -> tuple[Header, Authority]:
    """Header and authority of a note that bears that authority's signature.  Raises: ValueError if it does not."""
    text, _ = parted(note)
    origin, *lines = text[:-1].split("\n")
    values = [line.removeprefix(f"{name} ") for name, line in zip(_LINES, lines, strict=True)]
    if any(not line.startswith(f"{name} ") for name, line in zip(_LINES, lines, strict=True)):
        raise ValueError("its header is none")
    key, issued, expires, head, people, size, digest = values
    authority = Authority(key)
    if origin != ORIGINS[version] + authority.fingerprint:
        raise ValueError("its key is not that of its origin")
    opened(note, origin, authority)
    for time in (issued, expires):
        datetime.strptime(time, TIME)
    Head.parse(head)
    return Header(key, issued, expires, head, int(people), int(size), digest, version), authority
