"""What this user saw last of each registry.

Remembered are: which authority signs at which place, and how far each authority's log had grown.  They are in a small
SQLite file in the user's data folder; MOIREID_SEEN names another file.  A head is only ever replaced by a later one, in
one statement, so that programs that run at the same time lose nothing.  Places are kept as hashes, because an address
may name people and servers.  If the file cannot be written (a read-only home), nothing is remembered, and callers say
so.
"""

from __future__ import annotations

import hashlib
import os
import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from moireid.errors import RegistryError
from moireid.registry.log import Head
from moireid.user_settings import data_folder, expanded

SEEN_VARIABLE = "MOIREID_SEEN"
#: How long one program waits for another's write, seconds.
WAIT_S = 10.0

#: All or none: a program may be killed in between.
_TABLES = """
BEGIN IMMEDIATE;
CREATE TABLE IF NOT EXISTS places (place TEXT PRIMARY KEY, fingerprint TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS heads (fingerprint TEXT PRIMARY KEY, seq INTEGER NOT NULL, hash TEXT NOT NULL);
COMMIT;
"""


def seen_path() -> Path | None:
    """Where it is kept; nothing is made.  None for a user without a home folder, where nothing is remembered."""
    if given := os.environ.get(SEEN_VARIABLE):
        return expanded(given).absolute()
    folder = data_folder()
    return None if folder is None else folder / "seen.sqlite3"


def recall(place: str = "") -> tuple[str | None, dict[str, Head]]:
    """What was seen before: the fingerprint of the authority of one place, and of every authority the last head.

    The first is None if nothing was seen there.
    Raises: RegistryError if the file cannot be read.
    """
    path = seen_path()
    if path is None or not path.exists():
        return None, {}
    # Not for reading alone: after a program was killed in a write, the next reader must undo what it left.  A file that
    # may not be written is opened for reading all the same.
    with _readable(), closing(sqlite3.connect(f"{path.as_uri()}?mode=rw", uri=True, timeout=WAIT_S)) as database:
        # A program that is killed between making the file and its tables leaves it without them.
        if not database.execute("SELECT 1 FROM sqlite_master").fetchone():
            return None, {}
        at = database.execute("SELECT fingerprint FROM places WHERE place = ?", (_key(place),)).fetchone()
        heads = database.execute("SELECT fingerprint, seq, hash FROM heads").fetchall()
        last = {str(who): _head(f"{seq}:{root}") for who, seq, root in heads}
    return str(at[0]) if at else None, last


def remember(place: str, fingerprint: str, head: Head) -> bool:
    """Remember what is seen now; returns whether that was possible.

    Convention: the authority of a place is replaced, an authority's head only by a later one.
    """
    path = seen_path()
    if path is None:
        return False
    with suppress(OSError, sqlite3.Error):
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
        return True
    return False


def forget(fingerprint: str) -> Head | None:
    """Forget all that was seen of an authority; returns its last head, None if nothing was.

    Raises: RegistryError if the file cannot be read or written.
    """
    path, last = seen_path(), recall()[1].get(fingerprint)
    if path is None or last is None:
        return None
    with _readable(), closing(sqlite3.connect(path, timeout=WAIT_S)) as database, database:
        database.executescript(_TABLES)
        database.execute("DELETE FROM places WHERE fingerprint = ?", (fingerprint,))
        database.execute("DELETE FROM heads WHERE fingerprint = ?", (fingerprint,))
    return last


@contextmanager
def _readable() -> Iterator[None]:
    try:
        yield
    except (sqlite3.Error, ValueError) as error:
        # If the error were ignored, damage to this file would hide that a registry was put back.
        raise RegistryError(
            f"what was seen of registries before, {seen_path()}, cannot be read ({error}); put that file right, or "
            "remove it to begin anew"
        ) from error


def _head(text: str) -> Head:
    """The head that `text` writes as SEQUENCE:HASH.  Raises: ValueError if it is none."""
    if (found := re.fullmatch(r"([1-9]\d{0,17}):([0-9a-f]{64})", text, re.ASCII)) is None:
        raise ValueError(f"{text[:80]!r} is no head of a log")
    return Head(int(found[1]), found[2])


def _key(place: str) -> str:
    return hashlib.sha256(place.encode()).hexdigest()
