"""The content of a bundle: an SQLite database, so that a look-up among many people reads a handful of pages.

people    name and its skeletons (`look_alikes`), the line below it, sealed identity, layout, measured figures, and what
          bars the badge
layouts   a specimen of each layout: a badge without a person
about     the checkpoint; the hashes of all log entries, 32 bytes each
rotations the log entries, as JSON, that gave the log another key

What is not in it: identities in the clear, printed lines, times of issue, and whose each log entry is.  The measured
figures are in it: they can be measured from a film of the badge, too, and without them a verifier cannot detect a copy.
"""

from __future__ import annotations

import json
import sqlite3
import tempfile
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from moireid.provenance import Exclusion, Seal
from moireid.registry.canonical import canonical_json
from moireid.registry.record import barred_by

_TABLES = """
CREATE TABLE about (checkpoint TEXT NOT NULL, entries BLOB NOT NULL);
CREATE TABLE rotations (entry TEXT NOT NULL);
CREATE TABLE layouts (number INTEGER PRIMARY KEY, badge TEXT NOT NULL);
CREATE TABLE people (
    number INTEGER PRIMARY KEY, name TEXT NOT NULL, skeleton TEXT NOT NULL, folded TEXT NOT NULL,
    salt BLOB NOT NULL, seal BLOB NOT NULL, layout INTEGER NOT NULL, as_built TEXT, revoked_at TEXT,
    revoked_reason TEXT, suspended_at TEXT, suspended_reason TEXT, expires TEXT, compromised_since TEXT, line TEXT
);
"""
_INDEXES = """
CREATE INDEX people_by_name ON people (name);
CREATE INDEX people_by_skeleton ON people (skeleton);
CREATE INDEX people_by_folded ON people (folded);
"""
#: Skeleton and folded skeleton of a name.
Looks = tuple[str, str]
#: Columns that older bundles do not have.
_LATER = ("suspended_at", "suspended_reason", "expires", "compromised_since", "line")
_COLUMNS = ", ".join(("name", "salt", "seal", "layout", "as_built", "revoked_at", "revoked_reason", *_LATER))


@dataclass(frozen=True)
class BundlePerson:
    """A person of a bundle; figures: as JSON, without the identity; layout: number of its specimen."""

    name: str
    seal: Seal
    layout: int
    figures: str | None
    revoked_at: str | None
    revoked_reason: str | None
    suspended_at: str | None = None
    suspended_reason: str | None = None
    expires: str | None = None
    compromised_since: str | None = None
    line: str | None = None

    @property
    def barred(self) -> Exclusion | None:
        """Why the badge does not count at present."""
        return barred_by(
            self.revoked_at,
            self.revoked_reason,
            self.suspended_at,
            self.suspended_reason,
            self.expires,
            self.compromised_since,
        )


def without_id(as_built: str | None) -> str | None:
    """Measured figures as a bundle holds them: without the identity that they contain."""
    return None if as_built is None else canonical_json(json.loads(as_built) | {"badge_id": ""})


def made_content(
    checkpoint: str,
    entries: Iterable[bytes],
    rotations: Iterable[dict[str, Any]],
    layouts: Iterable[str],
    people: Iterable[tuple[BundlePerson, Looks]],
) -> bytes:
    """The content; layouts: badges as JSON in the order of their numbers; people: each with the name's skeletons."""
    with tempfile.TemporaryDirectory(prefix="moireid-bundle-") as folder:
        path = Path(folder) / "content.sqlite3"
        # No journal is needed: no other process reads this folder, and after a power cut it is not used any more.
        with closing(sqlite3.connect(path)) as database:
            database.executescript("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;" + _TABLES)
            with database:
                database.execute("INSERT INTO about VALUES (?, ?)", (checkpoint, b"".join(entries)))
                turned = ((canonical_json(entry),) for entry in rotations)
                database.executemany("INSERT INTO rotations VALUES (?)", turned)
                database.executemany("INSERT INTO layouts VALUES (?, ?)", enumerate(layouts))
                database.executemany(
                    f"INSERT INTO people (skeleton, folded, {_COLUMNS}) VALUES ({', '.join('?' * 14)})",
                    map(_row, people),
                )
                database.executescript(_INDEXES)
        return path.read_bytes()


class BundleContent:
    """A content whose signature was checked, kept in memory: no one can change it between check and use."""

    def __init__(self, content: bytes) -> None:
        """Raises: sqlite3.Error where it is no database."""
        self._database = sqlite3.connect(":memory:")
        self._database.deserialize(content)
        self._database.execute("PRAGMA query_only = ON")
        self._database.execute("PRAGMA trusted_schema = OFF")
        # Older bundles lack columns: names that differ only in case or width are not found in them, and no one in them
        # is suspended.
        columns = {row[1] for row in self._database.execute("PRAGMA table_info(people)")}
        self._folds = "folded" in columns
        known = [name if name in columns else f"NULL AS {name}" for name in _COLUMNS.split(", ")]
        self._columns = ", ".join(known)

    def close(self) -> None:
        """Give the memory back."""
        self._database.close()

    def named(self, name: str) -> list[BundlePerson]:
        """All of this very name."""
        return self._people("name = ?", name)

    def alike(self, looks: Looks) -> list[BundlePerson]:
        """All people whose names have one of these skeletons."""
        skeleton, folded = looks
        found = self._people("skeleton = ?", skeleton)
        if self._folds:
            found += [one for one in self._people("folded = ?", folded) if one not in found]
        return found

    def everybody(self) -> list[BundlePerson]:
        """All people."""
        return self._people("1 = ?", 1)

    def count(self) -> int:
        """How many people there are."""
        return int(self._database.execute("SELECT count(*) FROM people").fetchone()[0])

    def layout(self, number: int) -> str:
        """A specimen's JSON."""
        (found,) = self._database.execute("SELECT badge FROM layouts WHERE number = ?", (number,)).fetchone()
        return str(found)

    def layouts(self) -> list[str]:
        """The JSON of all specimens."""
        return [str(found) for (found,) in self._database.execute("SELECT badge FROM layouts ORDER BY number")]

    def hash_at(self, seq: int) -> str | None:
        """The hash of a log entry; None if there is no such entry."""
        (found,) = self._database.execute("SELECT substr(entries, ?, 32) FROM about", (32 * seq - 31,)).fetchone()
        return found.hex() if seq > 0 and len(found) == 32 else None

    def checkpoint(self) -> str:
        """The checkpoint's note."""
        return str(self._database.execute("SELECT checkpoint FROM about").fetchone()[0])

    def rotations(self) -> list[dict[str, Any]]:
        """The log entries that gave the log another key, in order; none in a bundle of an early version.

        Raises: ValueError if one is no entry.
        """
        tables = self._database.execute("SELECT 1 FROM sqlite_master WHERE name = 'rotations'").fetchone()
        rows = self._database.execute("SELECT entry FROM rotations ORDER BY rowid") if tables else ()
        return [json.loads(entry) for (entry,) in rows]

    def entries(self) -> list[bytes]:
        """The hashes of all log entries."""
        (found,) = self._database.execute("SELECT entries FROM about").fetchone()
        return [found[k : k + 32] for k in range(0, len(found), 32)]

    def _people(self, condition: str, value: object) -> list[BundlePerson]:
        rows = self._database.execute(f"SELECT {self._columns} FROM people WHERE {condition} ORDER BY number", (value,))
        return [BundlePerson(name, Seal(salt, seal), *rest) for name, salt, seal, *rest in rows]


def _row(pair: tuple[BundlePerson, Looks]) -> tuple[object, ...]:
    person, looks = pair
    seal = person.seal
    return (
        *looks,
        person.name,
        seal.salt,
        seal.digest,
        person.layout,
        person.figures,
        person.revoked_at,
        person.revoked_reason,
        *[getattr(person, name) for name in _LATER],
    )
