"""Checkpoints, in the format that transparency logs share.

A checkpoint is a signed note (`note.py`) with the size of a registry's log and the root of the tree over it: what the
signed head says (`registry/log.py`), in a form that others can keep.  It covers every letter of every entry up to it,
and reveals none.

Convention: the lines of a checkpoint are origin, size, root in base64, and the date as an extension line, which C2SP
allows.
Source: C2SP tlog-checkpoint, https://c2sp.org/tlog-checkpoint; tree of RFC 6962.
"""

from __future__ import annotations

import base64
import re
from dataclasses import dataclass
from pathlib import Path

from moireid.errors import RegistryError
from moireid.files import read_regular
from moireid.registry.canonical import utc_now
from moireid.registry.checkpoints.note import opened, parted, signed_note
from moireid.registry.keys import FINGERPRINT_DIGITS, Authority, Signer
from moireid.registry.log import Head
from moireid.registry.rollback import refusal

ORIGIN = "moireid/registry/"
#: The lines of a text: other lines of extension may be around the date.  In ASCII alone, as digits of other scripts
#: would be read as numbers, too.
_TEXT = re.compile(
    rf"{ORIGIN}([0-9a-f]{{{FINGERPRINT_DIGITS}}})\n([1-9]\d{{0,17}})\n([A-Za-z0-9+/]{{43}}=)\n"
    r"(?:(?!date ).*\n)*date (.*)\n(?:(?!date ).*\n)*",
    re.ASCII,
)
#: Longest file of a checkpoint, bytes: it has 250, more with the lines of witnesses.
MOST_BYTES = 65536


@dataclass(frozen=True)
class Checkpoint:
    """A log's state, as others can keep it.

    Attributes
    ----------
    fingerprint : str
        Of the authority that signed it, 32 hex digits.
    head : Head
        Entries of the log, and the root of the Merkle tree over them.
    date : str
        When it was signed; UTC, ISO 8601 to the second.
    note : str
        The signed note whole.
    """

    fingerprint: str
    head: Head
    date: str
    note: str

    def check(self, authority: Authority, source: str) -> None:
        """Check the signature.

        Parameters
        ----------
        authority : Authority
            Of the log.
        source : str
            Names the checkpoint in messages.

        Raises
        ------
        RegistryError
            If it is not the authority's; with code "key_replaced" if it is another one's.
        """
        if self.fingerprint != authority.fingerprint:
            what = (
                f"is signed by authority {authority.fingerprint}, and the checkpoint {source} by {self.fingerprint}: "
                "its key was replaced"
            )
            raise refusal("key_replaced", "the registry", what, "get a checkpoint of its own")
        try:
            opened(self.note, ORIGIN + authority.fingerprint, authority)
        except ValueError as error:
            raise RegistryError(
                f"checkpoint {source} was changed or is damaged ({error}); get another copy of it"
            ) from error


def checkpoint_from(note: str, source: str) -> Checkpoint:
    """The checkpoint in a note; its signature is not checked.  Raises: RegistryError if the note is no checkpoint."""
    try:
        found = _TEXT.fullmatch(parted(note)[0])
    except ValueError:
        found = None
    if found is None:
        raise RegistryError(f"{source} is no checkpoint; give a file that `moireid registry checkpoint` wrote")
    fingerprint, size, root, date = found.groups()
    return Checkpoint(fingerprint, Head(int(size), base64.b64decode(root).hex()), date, note)


def read_checkpoint(path: Path) -> Checkpoint:
    """The checkpoint in a file.

    Parameters
    ----------
    path : Path
        What `moireid registry checkpoint` wrote; witnesses may have added their lines.

    Returns
    -------
    Checkpoint
        Its signatures are not checked yet.

    Raises
    ------
    RegistryError
        If it cannot be read, or is none.
    """
    try:
        text = read_regular(path, MOST_BYTES).decode("utf-8", errors="replace")
    except OSError as error:
        raise RegistryError(f"checkpoint {path} cannot be read ({error.strerror}); give the path of one") from error
    return checkpoint_from(text, str(path))


def sign_checkpoint(head: Head, signer: Signer) -> Checkpoint:
    """The checkpoint of a log that ends so."""
    fingerprint, date, root = signer.authority.fingerprint, utc_now(), base64.b64encode(bytes.fromhex(head.hash))
    text = f"{ORIGIN}{fingerprint}\n{head.seq}\n{root.decode()}\ndate {date}\n"
    return Checkpoint(fingerprint, head, date, signed_note(text, ORIGIN + fingerprint, signer))
