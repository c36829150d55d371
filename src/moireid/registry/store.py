"""The Registry: enroll, find, list.

Convention: names are compared exactly after Unicode NFC, ids in lower case; nothing else is folded or trimmed.
An issued record is never changed: enrolling the very same badge again returns the record there is.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from types import TracebackType

from sqlalchemy import Engine, Row, Select, and_, func, insert, or_, select
from sqlalchemy.engine import URL
from sqlalchemy.exc import IntegrityError

from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError, SpecError
from moireid.registry.engine import connect, translated, writing
from moireid.registry.schema import badges, prepare
from moireid.registry.url import default_url, read_url, show_url, sqlite_file

#: Records fetched at a time: few enough for the memory, and no lock is held while the caller looks at them.
PAGE = 200
#: More matches than this are counted, not listed, in a message.
LISTED = 10


@dataclass(frozen=True)
class Record:
    """One issued badge.

    id: lower-case hex; name: as it is matched, in NFC; issued_at: UTC, ISO 8601 to the second, such as
    2026-01-31T12:00:00Z; layout_key: `badge.layout_key()` at the time of issue.
    """

    id: str
    name: str
    badge: Badge
    issued_at: str
    layout_key: str


def open_registry(url: str | None, *, create: bool) -> Registry:
    """The registry at an SQLAlchemy URL, or at `default_url()` for None.

    With `create` the folder, file and tables are made where they are absent; without it nothing is ever made.
    Raises: RegistryError where the URL is none, its driver is not installed, the registry is absent, or what is
        there cannot be opened, is no registry, or has another schema version.
    """
    parsed = read_url(default_url() if url is None else url)
    _look_for_file(parsed, create=create)
    engine = connect(parsed)
    try:
        with translated(parsed):
            prepare(engine, show_url(parsed), create=create)
    except RegistryError:
        engine.dispose()
        raise
    return Registry(engine, parsed)


class Registry:
    """An open registry; a context manager that closes its connections.

    Every method raises RegistryError where the database fails, and where a stored record is damaged.
    """

    def __init__(self, engine: Engine, url: URL) -> None:
        self._engine = engine
        self._url = url
        self.shown_url = show_url(url)

    def __enter__(self) -> Registry:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._engine.dispose()

    def enroll(self, badge: Badge) -> Record:
        """Issue `badge`; the very same badge again returns the first record, unchanged.

        Raises: RegistryError where the badge has no id, or a name that cannot be claimed, or where its id is issued
            already to another name or with another badge; SpecError where the badge breaks its own schema.
        """
        record = _new_record(badge, self.shown_url)
        values = {
            "id": record.id,
            "name_nfc": record.name,
            "layout_key": record.layout_key,
            "badge_json": record.badge.to_json(),
            "issued_at": record.issued_at,
        }
        with translated(self._url):
            try:
                # The database's unique id decides who was first: to look before writing would let two look at once.
                with writing(self._engine) as connection:
                    connection.execute(insert(badges).values(values))
            except IntegrityError as error:
                return self._same_or_conflict(record, error)
        return record

    def find(self, claim: str) -> Record:
        """The one record whose name is `claim` (after NFC) or whose id is `claim` (hex digits of any case).

        Raises: RegistryError where there is none, or more than one; `error.details["ids"]` lists those.
        """
        name = unicodedata.normalize("NFC", claim)
        matches = []
        if _storable(name):
            query = _SELECT.where(or_(badges.c.name_nfc == name, badges.c.id == _id(claim))).order_by(badges.c.id)
            matches = self._rows(query)
        if not matches:
            raise RegistryError(
                f"nobody named {name[:80]!r} and no such id is in registry {self.shown_url}; "
                "`moireid registry list` shows who is",
                claim=claim,
                ids=[],
            )
        if len(matches) > 1:
            raise _ambiguous(claim, name, matches)
        return self._record(matches[0])

    def by_id(self, badge_id: str) -> Record | None:
        """The record of an id, hex digits of any case, or None."""
        rows = self._rows(_SELECT.where(badges.c.id == _id(badge_id))) if _storable(badge_id) else []
        return self._record(rows[0]) if rows else None

    def is_taken(self, badge_id: str) -> bool:
        """Whether an id, hex digits of any case, is issued."""
        return _storable(badge_id) and bool(self._rows(select(badges.c.id).where(badges.c.id == _id(badge_id))))

    def records(self) -> Iterator[Record]:
        """All records by name, then id; what is enrolled meanwhile may or may not be among them."""
        page = _SELECT.order_by(badges.c.name_nfc, badges.c.id).limit(PAGE)
        rows = self._rows(page)
        while rows:
            yield from map(self._record, rows)
            last = rows[-1]
            same_name = and_(badges.c.name_nfc == last.name_nfc, badges.c.id > last.id)
            rows = self._rows(page.where(or_(badges.c.name_nfc > last.name_nfc, same_name)))

    def layouts(self) -> list[Badge]:
        """One badge of each distinct layout, that of the lowest id: all that a reader needs to read any of them."""
        firsts = select(func.min(badges.c.id)).group_by(badges.c.layout_key)
        rows = self._rows(_SELECT.where(badges.c.id.in_(firsts)).order_by(badges.c.id))
        return [self._record(row).badge for row in rows]

    def count(self) -> int:
        """The number of records."""
        return int(self._rows(select(func.count()).select_from(badges))[0][0])

    def _same_or_conflict(self, record: Record, refusal: IntegrityError) -> Record:
        """The record that holds the id of `record`, if of the very same badge.  Raises: RegistryError if not."""
        holder = self.by_id(record.id)
        if holder is None:
            raise refusal
        if holder.badge == record.badge:
            return holder
        other = "with another badge " if holder.name == record.name else ""
        raise RegistryError(
            f"id {record.id} is issued already to {holder.name!r} {other}({holder.issued_at}), so {record.name!r} "
            "cannot have this badge; print one with another --payload",
            id=record.id,
            holder=holder.name,
            issued_at=holder.issued_at,
        ) from refusal

    def _rows(self, query: Select) -> list[Row]:
        """All rows of a query, in a transaction of its own."""
        with translated(self._url), self._engine.connect() as connection:
            return list(connection.execute(query))

    def _record(self, row: Row) -> Record:
        """The record of a row.  Raises: RegistryError where the badge in it is none, or is not that of its columns."""
        try:
            badge = badge_from_json(row.badge_json, source=f"the badge of id {row.id}")
        except SpecError as error:
            raise RegistryError(
                f"registry {self.shown_url} is damaged ({error}); restore it from a copy", id=row.id
            ) from error
        if (badge.id, unicodedata.normalize("NFC", badge.name)) != (row.id, row.name_nfc):
            raise RegistryError(
                f"registry {self.shown_url} is damaged (the row of id {row.id}, {row.name_nfc!r}, holds the badge "
                f"of id {badge.id}, {badge.name!r}); restore it from a copy",
                id=row.id,
            )
        return Record(row.id, row.name_nfc, badge, row.issued_at, row.layout_key)


_SELECT = select(badges)


def _look_for_file(url: URL, *, create: bool) -> None:
    """Where `url` is an SQLite file's: make its folder, or see that the file is there, before SQLite makes it."""
    path = sqlite_file(url)
    if path is None:
        return
    try:
        if create:
            path.parent.mkdir(parents=True, exist_ok=True)
        else:
            path.stat()
    except (OSError, ValueError) as error:
        if not create and isinstance(error, (FileNotFoundError, NotADirectoryError)):
            raise RegistryError(
                f"there is no registry at {show_url(url)}; enroll someone first, or run `moireid registry init`"
            ) from error
        reason = error.strerror if isinstance(error, OSError) else error
        what = f"folder {path.parent} cannot be made" if create else f"registry {show_url(url)} cannot be reached"
        raise RegistryError(f"{what} ({reason}); give another URL") from error


def _new_record(badge: Badge, shown: str) -> Record:
    """The record of a badge that is about to be issued, as it will be read back."""
    if badge.id is None:
        raise RegistryError(
            f"the badge of {badge.name[:80]!r} has no id, so registry {shown} cannot hold it; enroll one that "
            "print-your-badge made"
        )
    name = unicodedata.normalize("NFC", badge.name)
    if not name.strip() or not _storable(name):
        raise RegistryError(
            f"the badge of id {badge.id[:40]} bears the name {name[:80]!r}, which nobody can type as a claim; "
            "print it with a plain name"
        )
    text = badge.to_json()
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise RegistryError(
            f"the badge of {name[:80]!r} holds text that is not Unicode ({error.reason}); print it anew"
        ) from error
    # JSON has one kind of number where Python has two.  Only what has gone through it compares with what is stored.
    read_back = badge_from_json(text, source=f"the badge of {name[:80]!r}")
    issued_at = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return Record(badge.id, name, read_back, issued_at, read_back.layout_key())


def _ambiguous(claim: str, name: str, matches: list[Row]) -> RegistryError:
    """The error that tells apart the several records which a claim names."""
    ids = [row.id for row in matches]
    named = [row.id for row in matches if row.name_nfc == name]
    listed = ", ".join(named[:LISTED]) + (f" and {len(named) - LISTED} more" if len(named) > LISTED else "")
    of_id = [row for row in matches if row.id not in named]
    if not of_id:
        message = f"{len(named)} people are named {name[:80]!r}, with ids {listed}; claim one of these ids"
    else:
        message = (
            f"{name[:80]!r} is the id of {of_id[0].name_nfc!r} and also the name on {listed}; "
            f"claim the name {of_id[0].name_nfc!r}, or the id {named[0]}"
        )
    return RegistryError(message, claim=claim, ids=ids)


def _id(claim: str) -> str:
    """A claim as an id is written."""
    return claim.lower()


def _storable(text: str) -> bool:
    """Whether every database can hold `text`, and a person type it: no control characters, no lone surrogates."""
    return not any(unicodedata.category(letter) in ("Cc", "Cs") for letter in text)
