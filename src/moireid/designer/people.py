"""A list of people (CSV), and the badge of each: used by `--people` and by the studio's page for an event.

Convention: rows are counted as a spreadsheet does, so the first line is row 1 and the first person is in row 2.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from moireid.badge import Badge
from moireid.designer.drawn import DrawnBadge, HolderOf, drawn_badge
from moireid.designer.list_table import RowFaults, read_list, unreadable
from moireid.designer.request import Request, clean_name, payload_from_hex
from moireid.errors import MoireIdError, SpecError
from moireid.files import MOST_TABLE_BYTES, AnyPath, read_regular
from moireid.names import LINE_COLUMNS, PICTURE_COLUMNS, line_of
from moireid.user_settings import nearest

MOST_PEOPLE = 10_000
#: So many columns are named of which nothing is printed.
SHOWN = 10
#: Checks a name against the fonts: returns None if they print all of it, else what they leave out; raises if nothing
#: is left.
NameNote = Callable[[str], str | None]


@dataclass(frozen=True)
class PersonRow:
    """One row of a list: its number, name and payload as given (empty where none is), and all cells by column."""

    row: int
    name: str
    payload: str
    cells: Mapping[str, str] = field(default_factory=dict)

    @property
    def line(self) -> str:
        """The first line below the name, empty where none is given: the column line, line1 and so on, or else role."""
        return next((self.cells[column] for column in (*LINE_COLUMNS, "role") if self.cells.get(column)), "")


@dataclass(frozen=True)
class PeopleList:
    """The people of a list; notes: which columns are not used."""

    people: tuple[PersonRow, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class DesignResult:
    """A person and either the badge, or why there is none.

    note: what there is to say of the badge; name_note: what its print leaves out of the name.
    """

    person: PersonRow
    badge: Badge | None = None
    fault: SpecError | None = None
    note: str | None = None
    name_note: str | None = None


def read_people(people_csv: AnyPath, *, faults: RowFaults | None = None) -> PeopleList:
    """The people of a CSV file; faults: as for `read_list`.

    Raises: SpecError as `parse_people`, and where the file cannot be read.
    """
    try:
        data = read_regular(people_csv, MOST_TABLE_BYTES)
    except OSError as error:
        raise unreadable(str(people_csv), f"{error.strerror}; give a CSV file with a column name") from error
    return parse_people(data, source=str(people_csv), faults=faults)


def parse_people(data: bytes, *, source: str = "the list", faults: RowFaults | None = None) -> PeopleList:
    """The people of the bytes of a CSV file; `source` names it in messages, and faults are as for `read_list`.

    Raises: SpecError as `read_list`, and where the list names no one or too many people.
    """
    listed = read_list(data, source=source, faults=faults)
    people = [PersonRow(row, cells["name"], cells.get("payload", ""), cells) for row, cells in listed.rows]
    if not 1 <= len(people) + len(faults or ()) <= MOST_PEOPLE:
        raise SpecError(f"{source} names {len(people)} people; 1 to {MOST_PEOPLE} can be printed at once")
    note = _unused(listed.columns, source)
    return PeopleList(tuple(people), (note,) if note else ())


def _unused(columns: Iterable[str], source: str) -> str | None:
    """A note on columns that nothing is printed of, each with the column that may have been meant."""
    known = ("name", *LINE_COLUMNS, "role", "payload", *PICTURE_COLUMNS)
    unused = [f"{column[:40]!r}{nearest(column, known)}" for column in columns if column and column not in known]
    if not unused:
        return None
    more = f" and {len(unused) - SHOWN} more" if len(unused) > SHOWN else ""
    return (
        f"nothing is printed of {Path(source).name}'s column{'s' if len(unused) > 1 else ''} "
        f"{', '.join(unused[:SHOWN])}{more}; the columns that count are {', '.join(known[:-1])}"
    )


def design_people(
    people: Iterable[PersonRow],
    request: Request,
    *,
    holder_of: HolderOf | None = None,
    source: str = "the list",
    name_note: NameNote = lambda name: None,
    line: str = "",
) -> Iterator[DesignResult]:
    """A badge for each person, in order, or the fault of that row.

    An identity that the list does not give is drawn, once: going through the list again draws others.  If two rows have
    the same identity, the later one is at fault; two rows of one name and one line are a note.

    Parameters: holder_of: as for `drawn_badge`; name_note: a `NameNote`, which `fabrication` provides; line: the first
        line for rows that have none.
    """
    rows: dict[str, int] = {}
    names: dict[tuple[str, str | None], int] = {}
    for person in people:
        where = f"row {person.row} of {Path(source).name} ({person.name[:40]!r})"
        try:
            missing_letters = name_note(clean_name(person.name))
            drawn = _drawn(person, request, holder_of, rows)
        except MoireIdError as error:
            fault = SpecError(f"{where}: {error}")
            fault.__cause__ = error
            yield DesignResult(person, fault=fault)
            continue
        badge = drawn.badge
        badge_id = badge.id or ""
        if badge_id in rows:
            fault = SpecError(
                f"rows {rows[badge_id]} and {person.row} of {Path(source).name} give one identity, {badge_id}; give "
                "another payload in one of them, or none, and one is drawn"
            )
            yield DesignResult(person, fault=fault)
            continue
        rows[badge_id] = person.row
        shown = line_of(badge.print) or unicodedata.normalize("NFC", line).strip() or None
        twin = names.setdefault((badge.name, shown), person.row)
        note = drawn.note if twin == person.row else _alike(twin, person.row, badge.name, shown)
        yield DesignResult(person, badge, note=note, name_note=missing_letters)


def _drawn(person: PersonRow, request: Request, holder_of: HolderOf | None, taken: Mapping[str, int]) -> DrawnBadge:
    """The badge of one row, of an identity that no row before has where one is drawn.  Raises: as `drawn_badge`."""
    wish = wish_of(person, request)
    if person.payload:
        chosen = payload_from_hex(person.payload, family=request.family or "spacing")
        return with_line(drawn_badge(wish, chosen, None), person)
    drawn = drawn_badge(wish, None, holder_of)
    # Of 24 bits two people of a long list draw the same now and then.
    while drawn.badge.id in taken:
        drawn = drawn_badge(wish, None, holder_of)
    return with_line(drawn, person)


def wish_of(person: PersonRow, request: Request) -> Request:
    """The request for one person of a list.  Raises: SpecError as `clean_name`."""
    return replace(request, name=clean_name(person.name))


def with_line(drawn: DrawnBadge, person: PersonRow) -> DrawnBadge:
    """The same, with the line below the name in the badge's print data."""
    if not person.line:
        return drawn
    line = clean_name(person.line, "line")
    return replace(drawn, badge=replace(drawn.badge, print=(drawn.badge.print or {}) | {"lines": [line]}))


def _alike(twin: int, row: int, name: str, line: str | None) -> str:
    also = f" and the line {line[:40]!r}" if line else ""
    return (
        f"rows {twin} and {row} bear the name {name[:40]!r}{also}, so claims distinguish them by "
        "their ids alone; a column line, such as what each does, is printed below the name and distinguishes them too"
    )


def without_held(designed: Iterable[DesignResult], request: Request, holder_of: HolderOf) -> Iterator[DesignResult]:
    """The same, once the registry can be asked: a random identity that another person holds is drawn again."""
    for one in designed:
        if one.badge is None or one.person.payload or holder_of(one.badge.id or "") is None:
            yield one
        else:
            drawn = with_line(drawn_badge(wish_of(one.person, request), None, holder_of), one.person)
            yield replace(one, badge=drawn.badge)


def badges_of(designed: Iterable[DesignResult]) -> list[Badge]:
    """The badges of a list.  Raises: the first row's fault."""
    badges = []
    for one in designed:
        if one.fault is not None:
            raise one.fault
        assert one.badge is not None
        badges.append(one.badge)
    return badges
