"""What this user saw last of each registry, and the check that a record is the newest version in the log.

Remembered are: which authority signs at which place, how far each authority's log had grown, and which key followed
each replaced key.  They are in a small SQLite file in the user's data folder; MOIREID_SEEN names another file.  A head
is only ever replaced by a later one, in one statement, so that programs that run at the same time lose nothing.  Places
are kept as hashes, because an address may name people and servers.  If the file cannot be written (a read-only home),
nothing is remembered, and callers say so.

`check_newest` is needed because reading a record compares it only with its newest entry among those that are present.
An attacker who can write to the database could put back a record as it was before its revocation, and remove the
revocation's entry from the middle of the log.  The chain then has a gap, which the walk up to the signed head finds.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from platformdirs import user_data_path
from sqlalchemy import func, select

from moireid.errors import RegistryError
from moireid.registry.ledger import PAGE, Ledger
from moireid.registry.log import Head, Rotation, check_hash
from moireid.registry.record import Fault, Record
from moireid.registry.schema import log

SEEN_VARIABLE = "MOIREID_SEEN"
#: How long one program waits for another's write, seconds.
WAIT_S = 10.0

_TABLES = """
CREATE TABLE IF NOT EXISTS places (place TEXT PRIMARY KEY, fingerprint TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS heads (fingerprint TEXT PRIMARY KEY, seq INTEGER NOT NULL, hash TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS successors (fingerprint TEXT PRIMARY KEY, successor TEXT NOT NULL, seq INTEGER NOT NULL);
"""


@dataclass(frozen=True)
class Successor:
    """The key that came after another: its fingerprint, and the number of the log entry that says so."""

    fingerprint: str
    seq: int


def seen_path() -> Path:
    """Where it is kept; nothing is made."""
    given = os.environ.get(SEEN_VARIABLE)
    return Path(given).expanduser().absolute() if given else user_data_path("moireid", appauthor=False) / "seen.sqlite3"


def authority_at(place: str) -> str | None:
    """The fingerprint of the authority that was seen at a place; None if none was.

    Raises: RegistryError if the file cannot be read.
    """
    row = _row("places", "SELECT fingerprint FROM places WHERE place = ?", _key(place))
    return None if row is None else str(row[0])


def last_head(fingerprint: str) -> Head | None:
    """The last head of an authority's log that was seen.  Raises: RegistryError as `authority_at`."""
    row = _row("heads", "SELECT seq, hash FROM heads WHERE fingerprint = ?", fingerprint)
    return None if row is None else Head(int(row[0]), str(row[1]))


def successor_of(fingerprint: str) -> Successor | None:
    """The key that was seen to come after this one.  Raises: RegistryError as `authority_at`."""
    row = _row("successors", "SELECT successor, seq FROM successors WHERE fingerprint = ?", fingerprint)
    return None if row is None else Successor(str(row[0]), int(row[1]))


def remember(place: str, fingerprint: str, head: Head, turned: Sequence[Rotation] = ()) -> bool:
    """Remember what is seen now; returns whether that was possible.

    Parameters: turned: the changes of the authority's key, proven.
    Convention: the authority of a place is replaced, an authority's head only by a later one.
    """
    path = seen_path()
    after = {one.old.fingerprint: Successor(one.new.fingerprint, one.seq) for one in turned}
    with suppress(OSError, sqlite3.Error, RegistryError):
        known = all(successor_of(old) == new for old, new in after.items())
        if known and authority_at(place) == fingerprint and last_head(fingerprint) == head:
            return True
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))
        with closing(sqlite3.connect(path, timeout=WAIT_S)) as database, database:
            database.executescript(_TABLES)
            database.execute("BEGIN IMMEDIATE")
            database.execute("INSERT OR REPLACE INTO places VALUES (?, ?)", (_key(place), fingerprint))
            database.execute(
                "INSERT INTO heads VALUES (?, ?, ?) ON CONFLICT (fingerprint) DO UPDATE SET seq = excluded.seq, "
                "hash = excluded.hash WHERE excluded.seq > heads.seq",
                (fingerprint, head.seq, head.hash),
            )
            rows = [(old, new.fingerprint, new.seq) for old, new in after.items()]
            # If there are two changes of one key, the user has named the true one; the head seen was of the other log.
            database.executemany(
                "DELETE FROM heads WHERE EXISTS (SELECT 1 FROM successors AS s WHERE s.fingerprint = heads.fingerprint "
                "AND s.fingerprint = ? AND s.successor <> ?)",
                [row[:2] for row in rows],
            )
            database.executemany("INSERT OR REPLACE INTO successors VALUES (?, ?, ?)", rows)
        return True
    return False


def forget(fingerprint: str) -> bool:
    """Forget all that was seen of an authority; returns whether something was.

    Raises: RegistryError if the file cannot be read or written.
    """
    if last_head(fingerprint) is None and successor_of(fingerprint) is None:
        return False
    with _readable(), closing(sqlite3.connect(seen_path(), timeout=WAIT_S)) as database, database:
        database.executescript(_TABLES)
        database.execute("DELETE FROM places WHERE fingerprint = ?", (fingerprint,))
        database.execute("DELETE FROM heads WHERE fingerprint = ?", (fingerprint,))
        database.execute("DELETE FROM successors WHERE fingerprint = ?", (fingerprint,))
    return True


def _row(table: str, query: str, value: str) -> tuple[Any, ...] | None:
    path = seen_path()
    if not path.exists():
        return None
    # Not for reading alone: after a program was killed in a write, the next reader must undo what it left.  A file that
    # may not be written is opened for reading all the same.
    with _readable(), closing(sqlite3.connect(f"{path.as_uri()}?mode=rw", uri=True, timeout=WAIT_S)) as database:
        # A program that is killed between making the file and its tables leaves it without them, and an older version
        # of this one knew fewer.
        if not database.execute("SELECT 1 FROM sqlite_master WHERE name = ?", (table,)).fetchone():
            return None
        found: tuple[Any, ...] | None = database.execute(query, (value,)).fetchone()
        return found


@contextmanager
def _readable() -> Iterator[None]:
    try:
        yield
    except sqlite3.Error as error:
        # If the error were ignored, damage to this file would hide that a registry was put back.
        raise RegistryError(
            f"what was seen of registries before, {seen_path()}, cannot be read ({error}); put that file right, or "
            "remove it to begin anew"
        ) from error


def _key(place: str) -> str:
    return hashlib.sha256(place.encode()).hexdigest()


def check_newest(ledger: Ledger, record: Record) -> None:
    """Walk the log from the record's newest entry to its signed head.

    Raises: RegistryError if an entry on the way was changed or taken out, or is about another version of the record.
    Source: each entry's hash holds that of the entry before, and the head is signed; so no signature on the way counts.
    A walk over 100,000 entries takes about a second.
    """
    with ledger.snapshot() as connection:
        head = ledger.head_in(connection)
        begin = select(func.max(log.c.seq)).where(log.c.subject == record.id).scalar_subquery()
        rows = connection.execution_options(yield_per=PAGE).execute(
            select(log).where(log.c.seq >= begin).order_by(log.c.seq)
        )
        names = list(rows.keys())
        _follow((dict(zip(names, row, strict=True)) for row in rows), record, head)


def _follow(entries: Iterable[Mapping[str, Any]], record: Record, head: Head) -> None:
    """Follow the chain from the first of these entries, the record's own, to the head.  Raises: Fault."""
    before: Head | None = None
    for entry in entries:
        if before is None and entry["record_sha256"] != record.digest():
            raise Fault("record_stale", f"the record of id {record.id} is not the version that the log has last")
        before = followed(entry, before)
    if before is None:
        raise Fault("record_unlogged", f"the log has no entry for the record of id {record.id}")
    if before != head:
        raise Fault("log_cut", f"the log does not lead from the record of id {record.id} to its signed head")


def followed(entry: Mapping[str, Any], before: Head | None) -> Head:
    """The log's head after an entry, which must follow from `before`; None: the entry before it is not checked.

    Raises: Fault if it does not, or any of its fields was changed.  Its signature is not checked.
    """
    if before is not None and (entry["seq"], entry["previous"]) != (before.seq + 1, before.hash):
        raise Fault("entry_missing", f"log entry {entry['seq']} does not follow from the one before it")
    return Head(entry["seq"], check_hash(entry))
