"""Readers of files that strangers give: each takes a content, or refuses it by one of its own errors.

Their kept corpora are contents that reach different code (`kit.fuzzing` found them), one archive a reader.
"""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from kit.places import TESTS
from moireid.attest.envelope import Broken, opened
from moireid.attest.statement import statement_fault, strict_object
from moireid.badge import badge_from_json
from moireid.designer.people import read_list
from moireid.errors import MoireIdError
from moireid.profiles import load_lens_profile
from moireid.verifier.report.live_receipt import load_receipt

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


READERS = {
    "badge": UntrustedReader(lambda content: badge_from_json(content.decode("latin-1"))),
    "envelope": UntrustedReader(opened, (Broken,)),
    # Its callers turn the error into a sentence.
    "statement": UntrustedReader(read_statement, (ValueError,)),
    "people": UntrustedReader(read_list),
    "lens": file_reader(load_lens_profile),
    "receipt": file_reader(load_receipt),
}


def kept_corpus(name: str) -> dict[str, bytes]:
    """The contents that are kept for a reader, by name; none where there is no archive."""
    path = CORPORA / f"{name}.zip"
    if not path.exists():
        return {}
    with zipfile.ZipFile(path) as archive:
        return {one: archive.read(one) for one in archive.namelist()}
