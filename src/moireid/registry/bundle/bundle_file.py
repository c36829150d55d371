"""The file of a bundle: one line with its kind, a signed note (`checkpoints/note.py`), and the content.

The note contains the content's SHA-256, so a check of the note and of that digest covers every byte; and it contains
the public key, which counts only if its fingerprint is the trusted one.

The content is a `BundleContent` as JSON, whose types are checked as it is read: its authority may be anyone.

What is not in it: identities in the clear, printed lines, times of issue, and whose each log entry is.  The measured
figures are in it: they can be measured from a film of the badge, too, and without them a verifier cannot detect a copy.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from moireid.errors import RegistryError
from moireid.files import read_regular
from moireid.provenance import Revocation, Seal
from moireid.registry.canonical import sha256_hex
from moireid.registry.checkpoints.note import opened, parted, signed_note
from moireid.registry.keys import Authority, Signer
from moireid.registry.merkle import leaf_hash

#: Of the format, and the origin of its notes.
VERSION, ORIGIN = 4, "moireid/bundle4/"
_FIRST = re.compile(rb"moireid bundle (\d{1,9}) (\d{6})\n")
#: Largest bundle; of 100,000 people it has some 25 MB.
MOST_BYTES = 1 << 30
TIME = "%Y-%m-%dT%H:%M:%SZ"


class BundlePerson(msgspec.Struct, frozen=True, array_like=True):
    """A person of a bundle.

    skeleton, folded: what the name looks like (`look_alikes`); layout: number of its specimen; line: below the name;
    figures: each set of measured figures as JSON, without the identity, and when it was stored; the last one is in use.
    """

    name: str
    skeleton: str
    folded: str
    seal: Seal
    layout: int
    revoked: Revocation | None
    line: str | None
    figures: list[tuple[str, str]]


class BundleContent(msgspec.Struct, frozen=True):
    """What was signed.

    checkpoint: the note of the log's checkpoint, which witnesses may have signed; entries: the hashes of all log
    entries, 32 bytes each; layouts: badges without a person, as JSON.
    """

    checkpoint: str
    entries: bytes
    layouts: list[str]
    people: list[BundlePerson]

    def __post_init__(self) -> None:
        """Raises: ValueError where a person's layout is not there."""
        if not all(0 <= person.layout < len(self.layouts) for person in self.people):
            raise ValueError("a layout is missing")

    @property
    def leaves(self) -> list[bytes]:
        """The leaves of the log's tree, one for each entry."""
        return [leaf_hash(self.entries[place : place + 32]) for place in range(0, len(self.entries), 32)]


def sealed_file(signer: Signer, expires: str, content: bytes) -> bytes:
    """The whole file of a bundle; expires: until when it counts, as times in records."""
    name = ORIGIN + signer.authority.fingerprint
    header = {"key": signer.authority.public_hex, "expires": expires, "sha256": sha256_hex(content)}
    note = signed_note(f"{name}\n{msgspec.json.encode(header).decode()}\n", name, signer).encode()
    return b"moireid bundle %d %06d\n" % (VERSION, len(note)) + note + content


def read_bundle_file(path: Path) -> tuple[str, Authority, BundleContent]:
    """Until when a bundle counts, its authority, and its content, every byte checked against the signature.

    Raises: RegistryError if the file cannot be read, is none, was changed, or has expired.
    """
    try:
        whole = read_regular(path, MOST_BYTES)
    except OSError as error:
        raise RegistryError(f"bundle {path} cannot be read ({error.strerror}); give the path of one") from error
    first = _FIRST.match(whole)
    if first is None:
        raise RegistryError(f"{path} is no bundle of a registry; give a file that `moireid registry publish` wrote")
    begin = first.end() + int(first[2])
    if (version := int(first[1])) != VERSION:
        raise RegistryError(
            f"bundle {path} is of format {version}, and this moireid reads format {VERSION}; install a newer moireid"
        )
    try:
        header, authority = _header(whole[first.end() : begin].decode())
        content = memoryview(whole)[begin:]
        if sha256_hex(content) != header["sha256"]:
            raise ValueError("its content is another than was signed")
        expires, people = header["expires"], msgspec.json.decode(content, type=BundleContent)
        expired = now() >= datetime.strptime(expires, TIME).replace(tzinfo=UTC)
    except (ValueError, RecursionError) as error:
        raise RegistryError(
            f"bundle {path} is cut, changed or damaged ({error}); fetch it again, and ask its publisher if that fails"
        ) from error
    if expired:
        raise RegistryError(
            f"bundle {path} expired on {expires}, so it may lack revocations; fetch a newer one from where it "
            "is published",
            code="expired",
            expires=expires,
        )
    return expires, authority, people


def now() -> datetime:
    """This moment, UTC."""
    return datetime.now(UTC)


def _header(note: str) -> tuple[dict[str, str], Authority]:
    """Header and authority of a note that bears that authority's signature.  Raises: ValueError if it does not."""
    origin, line = parted(note)[0][:-1].split("\n")
    header = msgspec.json.decode(line, type=dict[str, str])
    if not header.keys() >= {"key", "expires", "sha256"}:
        raise ValueError("its header is not whole")
    authority = Authority(header["key"])
    if origin != ORIGIN + authority.fingerprint:
        raise ValueError("its key is not that of its origin")
    opened(note, origin, authority)
    return header, authority
