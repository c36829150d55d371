"""The file of a bundle: one line with its kind, a signed note (`checkpoints/note.py`), and the content.

The note contains the content's SHA-256, so a check of the note and of that digest covers every byte; and it contains
the public key, which counts only if its fingerprint is the trusted one.

The content is an SQLite database, so that a look-up among many people reads a handful of pages:

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
import re
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypedDict

import msgspec

from moireid.errors import RegistryError
from moireid.files import read_regular
from moireid.provenance import Seal
from moireid.registry.canonical import canonical_json, sha256_hex
from moireid.registry.checkpoints.note import opened, parted, signed_note
from moireid.registry.keys import Authority, Signs
from moireid.registry.log import Head
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.record import BadgeState

#: Of the format, and the origin of its notes.
VERSION, ORIGIN = 3, "moireid/bundle3/"
#: More entries than any log has; their bytes can still be counted by SQLite.
MOST_ENTRIES = 1 << 50
_FIRST = re.compile(rb"moireid bundle (\d{1,9}) (\d{6})\n")
#: Lines of the header after its origin, in this order.
_LINES = ("key", "issued", "expires", "head", "people", "length", "sha256")
#: Largest bundle: SQLite holds no larger database in memory.
MOST_BYTES = 1 << 30
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

    def sealed_file(self, signer: Signs, content: bytes) -> bytes:
        """The whole file."""
        name = ORIGIN + signer.authority.fingerprint
        text = "".join(f"{line} {getattr(self, line)}\n" for line in _LINES)
        note = signed_note(f"{name}\n{text}", name, signer).encode()
        return b"moireid bundle %d %06d\n" % (VERSION, len(note)) + note + content


def read_bundle_file(path: Path) -> tuple[Header, Authority, bytes]:
    """The header, its authority and the content of a bundle, every byte checked against the signature.

    Raises: RegistryError if the file cannot be read, is none, or was changed.
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
        older = "an unreleased version made it, so have it published again"
        raise RegistryError(
            f"bundle {path} is of format {version}, and this moireid reads format {VERSION}; "
            f"{older if version < VERSION else 'install a newer moireid'}"
        )
    try:
        header, authority = _header(whole[first.end() : begin].decode())
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


def _header(note: str) -> tuple[Header, Authority]:
    """Header and authority of a note that bears that authority's signature.  Raises: ValueError if it does not."""
    text, _ = parted(note)
    origin, *lines = text[:-1].split("\n")
    words = [line.partition(" ") for line in lines]
    if tuple(name for name, _, _ in words) != _LINES:
        raise ValueError("its header is none")
    # Not strict: whole numbers are written as text there.
    header = msgspec.convert({name: value for name, _, value in words}, Header, strict=False)
    authority = Authority(header.key)
    if origin != ORIGIN + authority.fingerprint:
        raise ValueError("its key is not that of its origin")
    opened(note, origin, authority)
    for time in (header.issued, header.expires):
        datetime.strptime(time, TIME)
    Head.parse(header.head)
    return header, authority


_TABLES = """
CREATE TABLE about (checkpoint TEXT NOT NULL, entries BLOB NOT NULL);
CREATE TABLE rotations (entry TEXT NOT NULL);
CREATE TABLE layouts (number INTEGER PRIMARY KEY, badge TEXT NOT NULL);
CREATE TABLE people (
    number INTEGER PRIMARY KEY, name TEXT NOT NULL, skeleton TEXT NOT NULL, folded TEXT NOT NULL,
    salt BLOB NOT NULL, seal BLOB NOT NULL, layout INTEGER NOT NULL, as_built TEXT, revoked_at TEXT,
    revoked_reason TEXT, suspended_at TEXT, suspended_reason TEXT, expires TEXT, compromised_since TEXT, line TEXT,
    as_built_at TEXT, as_built_earlier TEXT
);
"""
_INDEXES = """
CREATE INDEX people_by_name ON people (name);
CREATE INDEX people_by_skeleton ON people (skeleton);
CREATE INDEX people_by_folded ON people (folded);
"""


@dataclass(frozen=True, kw_only=True)
class BundlePerson(BadgeState):
    """A person of a bundle; layout: number of its specimen; as_built: as JSON, without the identity; as_built_earlier:
    as `Record.as_built_earlier`, without identities and reasons.
    """

    name: str
    seal: Seal
    layout: int
    as_built: str | None = None
    line: str | None = None
    as_built_at: str | None = None
    as_built_earlier: str | None = None

    def row(self) -> dict[str, Any]:
        """The columns of `people`."""
        looks = {"skeleton": skeleton(self.name), "folded": folded_skeleton(self.name)}
        return vars(self) | looks | {"salt": self.seal.salt, "seal": self.seal.digest}


#: Fields that are columns of the same name.
_PLAIN = [field.name for field in fields(BundlePerson) if field.name != "seal"]
_KINDS: dict[str, Any] = dict.fromkeys(_PLAIN, str | None) | {"name": str, "layout": int}
_COLUMNS = (*_PLAIN, "skeleton", "folded", "salt", "seal")
_INSERT = f"INSERT INTO people ({', '.join(_COLUMNS)}) VALUES (:{', :'.join(_COLUMNS)})"


def without_id(as_built: str | None) -> str | None:
    """Measured figures as a bundle holds them: without the identity that they contain."""
    return None if as_built is None else canonical_json(json.loads(as_built) | {"badge_id": ""})


def earlier_without_ids(sets: list[dict[str, Any]]) -> str | None:
    """Earlier sets of measured figures as a bundle holds them."""
    bare = [{"as_built": one["as_built"] | {"badge_id": ""}, "as_built_at": one["as_built_at"]} for one in sets]
    return canonical_json(bare) if bare else None


def made_content(
    checkpoint: str,
    entries: Iterable[bytes],
    rotations: Iterable[dict[str, Any]],
    layouts: Iterable[str],
    people: Iterable[BundlePerson],
) -> bytes:
    """The content; layouts: badges as JSON in the order of their numbers."""
    # In memory, where no disk is full: the file is written whole, once it is signed.
    with closing(sqlite3.connect(":memory:")) as database:
        database.executescript(_TABLES)
        with database:
            database.execute("INSERT INTO about VALUES (?, ?)", (checkpoint, b"".join(entries)))
            turned = ((canonical_json(entry),) for entry in rotations)
            database.executemany("INSERT INTO rotations VALUES (?)", turned)
            database.executemany("INSERT INTO layouts VALUES (?, ?)", enumerate(layouts))
            database.executemany(_INSERT, (person.row() for person in people))
        database.executescript(_INDEXES)
        return database.serialize()


class _EarlierFigures(TypedDict):
    as_built: dict[str, Any]
    as_built_at: str


#: What a bundle's content may consist of.  A view or a virtual table would run what its author wrote, for ever.
_OTHER = "SELECT name FROM sqlite_master WHERE type NOT IN ('table', 'index') OR sql LIKE 'CREATE VIRTUAL%'"


class BundleContent:
    """A content whose signature was checked, kept in memory: no one can change it between check and use.

    Its authority may be anyone, so each value is checked as it is read.
    """

    def __init__(self, content: bytes, path: Path) -> None:
        """Parameters: path: of the bundle, for messages.

        Raises: RegistryError where it is no database of a bundle, as all methods do where a value is of another kind.
        """
        self._path, self._database = path, sqlite3.connect(":memory:")
        with self._checked():
            self._database.deserialize(content)
            self._database.execute("PRAGMA query_only = ON")
            self._database.execute("PRAGMA trusted_schema = OFF")
            if other := self._rows(tuple[str], _OTHER):
                raise ValueError(f"it holds {other[0][0][:40]!r}, which is no table")

    def close(self) -> None:
        """Give the memory back."""
        self._database.close()

    def named(self, name: str) -> list[BundlePerson]:
        """All of this very name."""
        return self._people("name = ?", name)

    def alike(self, name: str) -> list[BundlePerson]:
        """All people whose names have one of this name's skeletons."""
        found = self._people("skeleton = ?", skeleton(name))
        return found + [one for one in self._people("folded = ?", folded_skeleton(name)) if one not in found]

    def everybody(self) -> list[BundlePerson]:
        """All people."""
        return self._people("1 = ?", 1)

    def count(self) -> int:
        """How many people there are."""
        return int(self._rows(tuple[int], "SELECT count(*) FROM people")[0][0])

    def layout(self, number: int) -> str:
        """A specimen's JSON."""
        with self._checked():
            ((found,),) = self._rows(tuple[str], "SELECT badge FROM layouts WHERE number = ?", number)
        return str(found)

    def layouts(self) -> list[str]:
        """The JSON of all specimens."""
        return [found for (found,) in self._rows(tuple[str], "SELECT badge FROM layouts ORDER BY number")]

    def checkpoint(self) -> str:
        """The note of the log's checkpoint, which witnesses may have signed."""
        with self._checked():
            ((found,),) = self._rows(tuple[str], "SELECT checkpoint FROM about")
        return str(found)

    def hash_at(self, seq: int) -> str | None:
        """The hash of a log entry; None if there is no such entry."""
        if not 0 < seq < MOST_ENTRIES:
            return None
        with self._checked():
            ((found,),) = self._rows(tuple[bytes], "SELECT substr(entries, ?, 32) FROM about", 32 * seq - 31)
        return bytes(found).hex() if len(found) == 32 else None

    def entry_hashes(self) -> Iterator[bytes]:
        """The hashes of all log entries in order, 32 bytes each."""
        ((found,),) = self._rows(tuple[bytes], "SELECT entries FROM about")
        return (found[begin : begin + 32] for begin in range(0, len(found), 32))

    def earlier(self, person: BundlePerson) -> list[dict[str, Any]]:
        """The earlier sets of a person's measured figures, as `earlier_without_ids` wrote them."""
        with self._checked():
            sets = msgspec.json.decode(person.as_built_earlier or "[]", type=list[_EarlierFigures])
        return [dict(one) for one in sets]

    def rotations(self) -> list[dict[str, Any]]:
        """The log entries that gave the log another key, in order."""
        with self._checked():
            rows = self._rows(tuple[str], "SELECT entry FROM rotations ORDER BY rowid")
            return [msgspec.json.decode(entry, type=dict[str, Any]) for (entry,) in rows]

    def _people(self, condition: str, value: object) -> list[BundlePerson]:
        query = f"SELECT salt, seal, {', '.join(_PLAIN)} FROM people WHERE {condition} ORDER BY number"
        kind: Any = tuple[(bytes, bytes, *(_KINDS[name] for name in _PLAIN))]  # type: ignore[misc]
        return [
            BundlePerson(seal=Seal(salt, seal), **dict(zip(_PLAIN, rest, strict=True)))
            for salt, seal, *rest in self._rows(kind, query, value)
        ]

    def _rows(self, kind: Any, query: str, *values: object) -> list[Any]:
        """What a query finds; kind: of each row."""
        with self._checked():
            found = self._database.execute(query, values).fetchall()
            return list(msgspec.convert(found, list[kind], builtin_types=(bytes,)))

    @contextmanager
    def _checked(self) -> Iterator[None]:
        try:
            yield
        # An empty content is a lack of memory to SQLite.
        except (sqlite3.Error, ValueError, MemoryError, RecursionError) as error:
            raise RegistryError(
                f"bundle {self._path} cannot be read ({str(error) or 'it is empty'}); fetch one that this moireid's "
                "version wrote"
            ) from error
