"""Readers of files that strangers give: each takes a content, or refuses it by one of its own errors.

What a signature covers is signed after it was changed, as by an authority in an attacker's hands.
Their kept corpora are contents that reach different code (`kit.fuzzing` found them), one archive a reader.
"""

from __future__ import annotations

import base64
import json
import os
import tempfile
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from kit.places import TESTS
from moireid.attest.envelope import Broken, opened
from moireid.attest.statement import statement_fault, strict_object
from moireid.badge import badge_from_json
from moireid.designer.list_table import read_list
from moireid.errors import MoireIdError
from moireid.profiles import load_lens_profile
from moireid.registry.bundle.bundle_file import sealed_file
from moireid.registry.bundle.held import Bundle
from moireid.registry.checkpoints.checkpoint import ORIGIN, checkpoint_from
from moireid.registry.checkpoints.cosignature import cosigned_at
from moireid.registry.checkpoints.note import COSIGNATURE, VerifierKey, signed_note
from moireid.registry.keys import Signer
from moireid.registry.merkle import Tree, leaf_hash

CORPORA = TESTS / "data" / "fuzzing"


@dataclass(frozen=True)
class UntrustedReader:
    """A reader of bytes, and the errors by which it refuses some."""

    read: Callable[[bytes], object]
    refusals: tuple[type[Exception], ...] = (MoireIdError,)

    def takes(self, content: bytes) -> bool:
        """Whether it takes a content and does not refuse it.  Raises: any other error, which is a fault."""
        try:
            self.read(content)
        except self.refusals:
            return False
        return True


@cache
def scratch() -> Path:
    """A file for readers that take no bytes; in memory, where the system has such a folder."""
    memory = Path("/dev/shm")
    return Path(tempfile.mkdtemp(dir=memory if memory.is_dir() else None)) / "file"


def file_reader(read: Callable[[Path], object]) -> UntrustedReader:
    def of_bytes(content: bytes) -> object:
        scratch().write_bytes(content)
        return read(scratch())

    return UntrustedReader(of_bytes)


def read_statement(content: bytes) -> None:
    """Read what an envelope holds."""
    statement_fault(strict_object(content))


#: Sign fuzzed bundles and checkpoints: their authority, and a witness.
SIGNER = Signer(Ed25519PrivateKey.from_private_bytes(bytes(range(32))))
WITNESS_KEY = Ed25519PrivateKey.from_private_bytes(bytes(range(1, 33)))
WITNESS = VerifierKey("witness", COSIGNATURE, WITNESS_KEY.public_key().public_bytes_raw())


def signed_bundle(content: bytes) -> bytes:
    """A bundle with this content, whatever it is."""
    # Its authority signs a checkpoint that fits the content, where it has entries.
    with suppress(ValueError, TypeError, LookupError, AttributeError, RecursionError):
        document = json.loads(content)
        entries = base64.b64decode(document["entries"])
        leaves = [leaf_hash(entries[at : at + 32]) for at in range(0, len(entries), 32)]
        name = ORIGIN + SIGNER.authority.fingerprint
        root = base64.b64encode(Tree(leaves).root()).decode()
        text = f"{name}\n{len(leaves)}\n{root}\ndate 2026-01-01T00:00:00Z\n"
        content = json.dumps(document | {"checkpoint": signed_note(text, name, SIGNER)}).encode()
    return sealed_file(SIGNER, "9999-01-01T00:00:00Z", content)


def read_bundle(path: Path) -> None:
    """Ask a bundle all that verification and identification ask."""
    path.write_bytes(signed_bundle(path.read_bytes()))
    # Else another log of the same authority, which was read before, would have each later one refused.
    os.environ["MOIREID_SEEN"] = str(path.with_name("seen.sqlite3"))
    path.with_name("seen.sqlite3").unlink(missing_ok=True)
    with Bundle(path) as bundle:
        bundle.layouts()
        bundle.holder_of("010204")
        for claim in ("Ada", "Bo", "Cy"):
            bundle.claimed(claim)


def read_checkpoint(content: bytes) -> None:
    """Read a checkpoint that a witness signed; its own signature comes last, as a changed one has none."""
    note = content.decode(errors="replace")
    checkpoint = checkpoint_from(note, "of a stranger")
    with suppress(ValueError):
        cosigned_at(note, WITNESS)
    checkpoint.check(SIGNER.authority, "of a stranger")


READERS = {
    "badge": UntrustedReader(lambda content: badge_from_json(content.decode("latin-1"))),
    "envelope": UntrustedReader(opened, (Broken,)),
    # Its callers turn the error into a sentence.
    "statement": UntrustedReader(read_statement, (ValueError,)),
    "people": UntrustedReader(read_list),
    "lens": file_reader(load_lens_profile),
    "bundle": file_reader(read_bundle),
    "checkpoint": UntrustedReader(read_checkpoint),
}


def kept_corpus(name: str) -> dict[str, bytes]:
    """The contents that are kept for a reader, by name; none where there is no archive."""
    path = CORPORA / f"{name}.zip"
    if not path.exists():
        return {}
    with zipfile.ZipFile(path) as archive:
        return {one: archive.read(one) for one in archive.namelist()}
