"""A list of people, and the badge of each: what `--people` and the studio's page for an event read.

Convention: rows are counted as a spreadsheet does, so the first person stands in row 2.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from moireid.badge import Badge
from moireid.designer.drawn import Drawn, HolderOf, drawn_badge
from moireid.designer.lists import read_list, unreadable
from moireid.designer.payload import payload_from_hex
from moireid.designer.request import Request, clean_name
from moireid.errors import MoireIdError, SpecError
from moireid.names import LINE_COLUMNS, line_of

MOST_PEOPLE = 10_000
#: What a font says to a name: None where it prints all of it, else what it leaves out; it raises where nothing is left.
NameNote = Callable[[str], str | None]


@dataclass(frozen=True)
class Person:
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
    """The people of a list; note: what was guessed on reading it, None where nothing was."""

    people: tuple[Person, ...]
    note: str | None = None


@dataclass(frozen=True)
class Designed:
    """A person and either the badge, or why there is none.

    note: what there is to say of the badge; name_note: what its print leaves out of the name.
    """

    person: Person
    badge: Badge | None = None
    fault: SpecError | None = None
    note: str | None = None
    name_note: str | None = None


def read_people(people_csv: Path) -> PeopleList:
    """The people of a CSV file.

    Raises: SpecError as `parse_people`, and where the file cannot be read.
    """
    try:
        data = people_csv.read_bytes()
    except OSError as error:
        raise unreadable(str(people_csv), f"{error.strerror}; give a CSV file with a column name") from error
    return parse_people(data, source=str(people_csv))


def parse_people(data: bytes, *, source: str = "the list") -> PeopleList:
    """The people of the bytes of a CSV file; `source` names it in messages.

    Raises: SpecError as `lists.read_list`, and where the list names nobody or too many.
    """
    listed = read_list(data, source=source)
    people = [Person(row, cells["name"], cells.get("payload", ""), cells) for row, cells in listed.rows]
    if not 1 <= len(people) <= MOST_PEOPLE:
        raise SpecError(f"{source} names {len(people)} people; 1 to {MOST_PEOPLE} can be printed at once")
    return PeopleList(tuple(people), listed.note)


def design_people(
    people: Iterable[Person],
    request: Request,
    *,
    holder_of: HolderOf | None = None,
    source: str = "the list",
    name_note: NameNote = lambda name: None,
    line: str = "",
) -> Iterator[Designed]:
    """A badge for each person, in order, or the fault of that row.

    An identity that the list does not give is drawn, once: going through the list again draws others.  If two rows have
    the same identity, the later one is at fault; two rows of one name and one line are a note.

    Parameters: holder_of: as for `drawn_badge`; name_note: what fonts say to a name, `fabrication`'s word;
        line: the first line of those whose row has none.
    """
    rows: dict[str, int] = {}
    names: dict[tuple[str, str | None], int] = {}
    for person in people:
        where = f"row {person.row} of {Path(source).name} ({person.name[:40]!r})"
        try:
            told = name_note(clean_name(person.name))
            drawn = _drawn(person, request, holder_of, rows)
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
        shown = line_of(badge.print) or unicodedata.normalize("NFC", line).strip() or None
        twin = names.setdefault((badge.name, shown), person.row)
        note = drawn.note if twin == person.row else _alike(twin, person.row, badge.name, shown)
        yield Designed(person, badge, note=note, name_note=told)


def _drawn(person: Person, request: Request, holder_of: HolderOf | None, taken: Mapping[str, int]) -> Drawn:
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


def wish_of(person: Person, request: Request) -> Request:
    """The request for one person of a list.  Raises: SpecError as `clean_name`."""
    return replace(request, name=clean_name(person.name))


def with_line(drawn: Drawn, person: Person) -> Drawn:
    """The same, with the line below the name in the badge's print data."""
    if not person.line:
        return drawn
    line = clean_name(person.line, "line")
    return replace(drawn, badge=replace(drawn.badge, print=(drawn.badge.print or {}) | {"lines": [line]}))


def _alike(twin: int, row: int, name: str, line: str | None) -> str:
    also = f" and the line {line[:40]!r}" if line else ""
    return (
        f"rows {twin} and {row} bear the name {name[:40]!r}{also}, so claims tell them apart by "
        "their ids alone; a column line, such as what each does, is printed below the name and tells them apart too"
    )


def without_held(designed: Iterable[Designed], request: Request, holder_of: HolderOf) -> Iterator[Designed]:
    """The same, once the registry can be asked: an identity that was drawn, and that somebody holds, is drawn anew."""
    for one in designed:
        if one.badge is None or one.person.payload or holder_of(one.badge.id or "") is None:
            yield one
        else:
            drawn = with_line(drawn_badge(wish_of(one.person, request), None, holder_of), one.person)
            yield replace(one, badge=drawn.badge)


def badges_of(designed: Iterable[Designed]) -> list[Badge]:
    """The badges of a list.  Raises: the first row's fault."""
    badges = []
    for one in designed:
        if one.fault is not None:
            raise one.fault
        assert one.badge is not None
        badges.append(one.badge)
    return badges
