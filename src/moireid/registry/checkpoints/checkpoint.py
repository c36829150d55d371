"""Signed notes and checkpoints, in the formats that transparency logs share.

A signed note is a text, an empty line, and lines of signatures.  A checkpoint is a note with the size of a registry's
log and the root of the tree over it.  The leaf of an entry is the entry's hash, which its chain and signature cover
already (`registry/log.py`): so a checkpoint covers every letter of every entry up to it, and reveals none.

Convention: the signature is Ed25519's over the text alone.  A text begins with its origin, `moireid/...`, and nothing
else that an authority signs begins so; so none can be taken for another (`keys.py`).  The lines of a checkpoint are
origin, size, root in base64, and the date as an extension line, which C2SP allows.
Source: C2SP signed-note v1.0.0, https://c2sp.org/signed-note; C2SP tlog-checkpoint, https://c2sp.org/tlog-checkpoint;
tree of RFC 6962.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, select

from moireid.errors import RegistryError
from moireid.registry.canonical import utc_now
from moireid.registry.checkpoints.merkle import Tree, consistency_proof, leaf_hash, root_of
from moireid.registry.keys import FINGERPRINT_DIGITS, NOTE, Authority, Signs
from moireid.registry.ledger import Ledger, pages
from moireid.registry.log import GENESIS, Head, followed
from moireid.registry.record import Fault
from moireid.registry.schema import log

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


ORIGIN = "moireid/registry/"


@dataclass(frozen=True)
class Checkpoint:
    """A log's state, as others can keep it.

    Attributes
    ----------
    fingerprint : str
        Of the authority that signed it, 32 hex digits.
    size : int
        Entries of the log.
    root : bytes
        Root of the Merkle tree over them, 32 bytes.
    date : str
        When it was signed; UTC, ISO 8601 to the second.
    note : str
        The signed note whole.
    """

    fingerprint: str
    size: int
    root: bytes
    date: str
    note: str

    def check(self, authority: Authority, source: str) -> None:
        """Check the signature.

        Parameters
        ----------
        authority : Authority
            Of this checkpoint's fingerprint.
        source : str
            Names the checkpoint in messages.

        Raises
        ------
        RegistryError
            If it is not the authority's.
        """
        try:
            opened(self.note, ORIGIN + authority.fingerprint, authority)
        except ValueError as error:
            raise RegistryError(
                f"checkpoint {source} was changed or is damaged ({error}); get another copy of it"
            ) from error


def checkpoint_from(note: str, source: str) -> Checkpoint:
    """The checkpoint in a note; its signature is not checked.  Raises: RegistryError if the note is no checkpoint."""
    try:
        text, _ = parted(note)
        origin, size, root, *more = text[:-1].split("\n")
        fingerprint = origin.removeprefix(ORIGIN)
        dates = [line.removeprefix("date ") for line in more if line.startswith("date ")]
        content = base64.b64decode(root, validate=True)
        whole = re.fullmatch(f"[0-9a-f]{{{FINGERPRINT_DIGITS}}}", fingerprint) and re.fullmatch(r"[1-9]\d{0,17}", size)
        if origin == fingerprint or not whole or len(content) != 32 or len(dates) != 1:
            raise ValueError("it is not one of a moireid registry")
    except (ValueError, binascii.Error) as error:
        raise RegistryError(
            f"{source} is no checkpoint ({error}); give a file that `moireid registry checkpoint` wrote"
        ) from error
    return Checkpoint(fingerprint, int(size), content, dates[0], note)


def sign_checkpoint(leaves: Iterable[bytes], signer: Signs) -> Checkpoint:
    """The checkpoint of a log of these leaves."""
    tree, fingerprint, date = Tree(), signer.authority.fingerprint, utc_now()
    for leaf in leaves:
        tree.add(leaf)
    root = base64.b64encode(tree.root()).decode()
    text = f"{ORIGIN}{fingerprint}\n{tree.size}\n{root}\ndate {date}\n"
    return Checkpoint(fingerprint, tree.size, tree.root(), date, signed_note(text, ORIGIN + fingerprint, signer))


def leaf_of(entry_hash: str) -> bytes:
    """The leaf of a log entry, from its hash in hex digits.  Raises: ValueError if that is none."""
    return leaf_hash(bytes.fromhex(entry_hash))


def entry_hashes(ledger: Ledger, connection: Connection) -> list[bytes]:
    """The hashes of all entries in order, as a snapshot has them.

    A signature over them states that the log is whole, so each entry up to the signed head is checked against its hash.
    Raises: Fault if any entry was changed or taken out; the snapshot reports it.
    """
    head, last, found = ledger.head_in(connection), Head(0, GENESIS), []
    for row in pages(connection, select(log), log.c.seq):
        last = followed(dict(row._mapping), last)
        found.append(bytes.fromhex(last.hash))
    if last != head:
        raise Fault("log_cut", "the log does not lead to its signed head")
    return found


def signed_state(ledger: Ledger, older: Sequence[Checkpoint]) -> tuple[Checkpoint, list[tuple[int, list[bytes]]]]:
    """What `Registry.checkpoint` does."""
    signer = ledger.signer()
    with ledger.snapshot() as connection:
        leaves = [leaf_hash(content) for content in entry_hashes(ledger, connection)]
    keys = {key.fingerprint: key for key in (*(one.old for one in ledger.rotations()), ledger.authority)}
    proofs = [(one.size, _proof(leaves, one, ledger, keys.get(one.fingerprint, ledger.authority))) for one in older]
    return sign_checkpoint(leaves, signer), proofs


def _proof(leaves: list[bytes], older: Checkpoint, ledger: Ledger, authority: Authority) -> list[bytes]:
    older.check(authority, f"of {older.date}")
    if older.size > len(leaves) or root_of(leaves[: older.size]) != older.root:
        raise RegistryError(
            f"registry {ledger.shown} does not begin as its checkpoint of {older.date} says, so nothing is signed; "
            "look with `moireid registry audit --since`"
        )
    return consistency_proof(leaves, older.size)
