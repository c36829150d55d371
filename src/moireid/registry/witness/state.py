"""What a witness keeps: its key, and of each log the newest checkpoint that it signed; one SQLite file.

Key and state are in one file, so that the key cannot go on without what it signed.  Each step is one transaction that
is on the disk before the signature leaves: a program that is killed, or a machine that loses power, forgets no
signature that anyone has seen.  Two programs on one file take turns.

What the file cannot show: that an older copy of it was put back.  Keep no backups of it; a witness that lost its file
begins anew under another name.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from moireid.errors import SpecError
from moireid.registry.checkpoints.checkpoint import TreeHead, tree_head
from moireid.registry.checkpoints.cosignature import cosignature_line
from moireid.registry.checkpoints.note import COSIGNATURE, VerifierKey, checked_name, parted, signatures_of
from moireid.registry.merkle import consistent
from moireid.registry.witness.request import SIZE_TYPE, AddRequest

#: How long one step waits for another, seconds.
WAIT_S = 10.0
_TABLES = """
CREATE TABLE IF NOT EXISTS witness (one INTEGER PRIMARY KEY CHECK (one = 1), name TEXT NOT NULL, key BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS logs (origin TEXT PRIMARY KEY, size INTEGER NOT NULL, root BLOB NOT NULL);
"""
#: The root of a log without entries.
EMPTY = hashlib.sha256().digest()


@dataclass(frozen=True)
class Answer:
    """A witness's answer: status of HTTP, text, and its type."""

    status: int
    text: str
    kind: str = "text/plain; charset=utf-8"


class Witness:
    """A witness, with its state in a file.

    Parameters
    ----------
    path : Path
        The file; it is made, with a new key, if it is absent.
    name : str
        The witness's name, such as witness.example/w1; a key has one name for ever.
    logs : sequence of VerifierKey
        The logs that it follows; the name of each key is the log's origin.

    Attributes
    ----------
    public : VerifierKey
        Its public key, for those who trust it.

    Raises
    ------
    SpecError
        If the name is none, the file is another witness's or cannot be written, or a log is given twice.
    """

    def __init__(self, path: Path, name: str, logs: Sequence[VerifierKey]) -> None:
        self._path, self._logs = path, {one.name: one for one in logs}
        if len(self._logs) < len(logs):
            raise SpecError("two of the logs have one origin; give each log once")
        try:
            checked_name(name)
            own, secret = self._opened(name)
        except ValueError as error:
            raise SpecError(
                f"{name[:80]!r} is no name of a witness ({error}); give one such as example.org/w1"
            ) from error
        except (OSError, sqlite3.Error) as error:
            raise SpecError(
                f"the witness's state {path} cannot be opened ({error}); give a file in a folder that you may write"
            ) from error
        if own != name:
            raise SpecError(f"{path} is the state of witness {own}, not of {name}; give its name, or another file")
        self._key = Ed25519PrivateKey.from_private_bytes(secret)
        self.public = VerifierKey(name, COSIGNATURE, self._key.public_key().public_bytes_raw())

    def _opened(self, name: str) -> tuple[str, bytes]:
        """Name and private key in the file, made if there are none."""
        os.close(os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600))
        with self._step() as database:
            for statement in _TABLES.strip().split("\n"):
                database.execute(statement)
            fresh = Ed25519PrivateKey.generate().private_bytes_raw()
            database.execute("INSERT OR IGNORE INTO witness VALUES (1, ?, ?)", (name, fresh))
            own, secret = database.execute("SELECT name, key FROM witness").fetchone()
        return str(own), bytes(secret)

    @contextmanager
    def _step(self) -> Iterator[sqlite3.Connection]:
        """A transaction, alone among all; on the disk when this ends, undone if an exception leaves it."""
        with closing(sqlite3.connect(self._path, timeout=WAIT_S, isolation_level=None)) as database:
            # The folder too is written to the disk: else a power cut could bring the journal back, and undo the step.
            database.execute("PRAGMA synchronous = EXTRA")
            database.execute("PRAGMA fullfsync = ON")
            database.execute("BEGIN IMMEDIATE")
            try:
                yield database
            except BaseException:
                database.execute("ROLLBACK")
                raise
            database.execute("COMMIT")

    def answer(self, content: bytes) -> Answer:
        """The answer to a request.

        Raises: sqlite3.Error if the state cannot be read or written; nothing is signed then.
        """
        try:
            request = AddRequest.parse(content)
            text, lines = parted(request.note)
            head = tree_head(text)
            log = self._logs.get(head.origin)
            signatures = [] if log is None else signatures_of(log, lines)
        except ValueError as error:
            return Answer(400, f"the request cannot be read: {error}\n")
        if log is None:
            return Answer(404, "this witness does not follow that log\n")
        if not any(_signed(log, text, one) for one in signatures):
            return Answer(403, "the checkpoint does not bear the log's signature\n")
        if request.old > head.size:
            return Answer(400, "the old size is larger than the checkpoint's\n")
        with self._step() as database:
            return self._advance(database, request, text, head)

    def _advance(self, database: sqlite3.Connection, request: AddRequest, text: str, head: TreeHead) -> Answer:
        """Compare a checkpoint with the newest one of its log, keep it and sign it, within a step."""
        row = database.execute("SELECT size, root FROM logs WHERE origin = ?", (head.origin,)).fetchone()
        size, root = (0, EMPTY) if row is None else (int(row[0]), bytes(row[1]))
        if request.old != size or (head.size == size and head.root != root):
            return Answer(409, f"{size}\n", SIZE_TYPE)
        if not (consistent(size, root, head.size, head.root, request.proof) if size else not request.proof):
            return Answer(422, "the proof does not show that the log goes on from the old size\n")
        # The same checkpoint again only gets a new date: no one can wear out the disk with it.
        if head.size > size:
            database.execute("INSERT OR REPLACE INTO logs VALUES (?, ?, ?)", (head.origin, head.size, head.root))
        return Answer(200, cosignature_line(text, self.public, self._key, int(time.time())))


def _signed(log: VerifierKey, text: str, signature: bytes) -> bool:
    try:
        Ed25519PublicKey.from_public_bytes(log.public).verify(signature, text.encode())
    except InvalidSignature:
        return False
    return True
