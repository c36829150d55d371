"""A list of people, and the badge of each: what `--people` and the studio's page for an event read.

Convention: rows are counted as a spreadsheet does, so the first person stands in row 2.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from moireid.badge import Badge
from moireid.designer.drawn import HolderOf, drawn_badge
from moireid.designer.payload import payload_from_hex
from moireid.designer.request import Request, clean_name
from moireid.errors import MoireIdError, SpecError

MOST_PEOPLE = 10_000


@dataclass(frozen=True)
class Person:
    """One row of a list: its number, and name and payload as given (payload empty where none is)."""

    row: int
    name: str
    payload: str


@dataclass(frozen=True)
class Designed:
    """A person and either the badge, or why there is none; note: what there is to say of the badge."""

    person: Person
    badge: Badge | None = None
    fault: SpecError | None = None
    note: str | None = None


def read_people(people_csv: Path) -> list[Person]:
    """The people of a CSV file.

    Raises: SpecError as `parse_people`, and where the file cannot be read.
    """
    try:
        data = people_csv.read_bytes()
    except OSError as error:
        raise _unreadable(str(people_csv), error.strerror) from error
    return parse_people(data, source=str(people_csv))


def parse_people(data: bytes, *, source: str = "the list") -> list[Person]:
    """The people of the bytes of a CSV file in UTF-8; `source` names it in messages.

    Raises: SpecError where it is no such file, lacks the column name, has a column twice, holds a row with more cells
        than its first line, or names nobody or too many.
    """
    try:
        # Not splitlines: it would split a name that contains a line separator into two people.
        text = io.StringIO(data.decode("utf-8-sig"), newline="")
        rows = list(csv.reader(text, strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise _unreadable(source, f"no CSV in UTF-8: {error}") from error
    header = [cell.strip().lower() for cell in rows[0]] if rows else []
    if "name" not in header:
        raise SpecError(
            f"list {source} has no column name; its first line must be 'name' or 'name,payload', got "
            f"{','.join(header)[:60]!r}"
        )
    for column in ("name", "payload"):
        if header.count(column) > 1:
            raise SpecError(f"list {source} has {header.count(column)} columns {column}; leave one of them")
    place = {column: header.index(column) for column in ("name", "payload") if column in header}
    people = []
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        # A name with a comma but without quotes would be cut at the comma.
        if any(cell.strip() for cell in row[len(header) :]):
            raise SpecError(
                f"row {number} of {Path(source).name} has {len(row)} cells, and the first line {len(header)}; put "
                'quotes about a name with a comma in it, as in "Doe, Jane"'
            )
        cells = {column: row[k].strip() if k < len(row) else "" for column, k in place.items()}
        people.append(Person(number, cells["name"], cells.get("payload", "")))
    if not 1 <= len(people) <= MOST_PEOPLE:
        raise SpecError(f"list {source} names {len(people)} people; 1 to {MOST_PEOPLE} can be printed at once")
    return people


def design_people(
    people: Iterable[Person], request: Request, *, holder_of: HolderOf | None = None, source: str = "the list"
) -> Iterator[Designed]:
    """A badge for each person, in order, or the fault of that row.

    An identity that the list does not give is drawn, once: going through the list again draws others.  If two rows have
    the same identity, the later one is at fault; two rows of one name are a note.  `holder_of`: as for `drawn_badge`.
    """
    rows: dict[str, int] = {}
    names: dict[str, int] = {}
    family = request.family or "spacing"
    for person in people:
        where = f"row {person.row} of {Path(source).name} ({person.name[:40]!r})"
        try:
            named = replace(request, name=clean_name(person.name))
            if person.payload:
                drawn = drawn_badge(named, payload_from_hex(person.payload, family=family), None)
            else:
                drawn = drawn_badge(named, None, holder_of)
                # Of 24 bits two people of a long list draw the same now and then.
                while drawn.badge.id in rows:
                    drawn = drawn_badge(named, None, holder_of)
        except MoireIdError as error:
            fault = SpecError(f"{where}: {error}")
            fault.__cause__ = error
            yield Designed(person, fault=fault)
            continue
        badge = drawn.badge
        badge_id = badge.id or ""
        if badge_id in rows:
            fault = SpecError(
                f"rows {rows[badge_id]} and {person.row} of {Path(source).name} give one identity, {badge_id}; give "
                "another payload in one of them, or none, and one is drawn"
            )
            yield Designed(person, fault=fault)
            continue
        rows[badge_id] = person.row
        twin = names.setdefault(badge.name, person.row)
        alike = f"rows {twin} and {person.row} bear the name {badge.name[:40]!r}, and each gets a badge of its own"
        yield Designed(person, badge, note=drawn.note if twin == person.row else alike)


def without_held(designed: Iterable[Designed], request: Request, holder_of: HolderOf) -> Iterator[Designed]:
    """The same, once the registry can be asked: an identity that was drawn, and that somebody holds, is drawn anew."""
    for one in designed:
        if one.badge is None or one.person.payload or holder_of(one.badge.id or "") is None:
            yield one
        else:
            yield replace(one, badge=drawn_badge(replace(request, name=one.badge.name), None, holder_of).badge)


def badges_of(designed: Iterable[Designed]) -> list[Badge]:
    """The badges of a list.  Raises: the first row's fault."""
    badges = []
    for one in designed:
        if one.fault is not None:
            raise one.fault
        assert one.badge is not None
        badges.append(one.badge)
    return badges


def _unreadable(source: str, why: str | None) -> SpecError:
    return SpecError(f"list {source} cannot be read ({why}); give a CSV file with a column name")
