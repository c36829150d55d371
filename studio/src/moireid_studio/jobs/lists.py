"""A list of people in the studio: each row's badge with its lines and looks, and how the list was understood.

A list in the studio has no folder.  Its columns logo and portrait name files that the visitor chose together with it,
so a cell finds one of those, by the last part of what it says, and never a file of this machine.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from moireid.artwork.columns import dressed
from moireid.artwork.placing import Look, shown_pieces
from moireid.badge import Badge
from moireid.designer.drawn import HolderOf
from moireid.designer.people import DesignResult, PersonRow, design_people, parse_people
from moireid.errors import SpecError
from moireid.fabrication.page.lettering import name_note
from moireid.fabrication.page.marks import check_look, look_notes
from moireid.names import PICTURE_COLUMNS, line_of
from moireid.registry import Registry
from moireid.registry.look_alikes import alike_within
from moireid_studio.jobs.orders import Wish

#: An event's badges are made one after the other in one child; a larger one is for the command line.
MOST_AT_AN_EVENT = 300
#: The key of the logo that all badges wear which have none of their own; no file's `picture_key` has a stroke.
FOR_ALL = "/for all"
#: The columns whose cells name files.
NAMED = ("logo", "portrait")
#: Most pictures that are listed by name because no row names them.
SHOWN = 5


@dataclass(frozen=True)
class ListRow:
    """A row: its badge with all its lines, and what it wears; badge is None where the row has a fault."""

    designed: DesignResult
    badge: Badge | None
    look: Look | None
    fault: str | None


@dataclass(frozen=True)
class ParsedList:
    """How a list was read: its rows for the page, and what there is to say of the whole."""

    rows: list[dict[str, Any]]
    notes: list[str]


def picture_key(name: str) -> str:
    """By what a cell of a list finds a picture: the last part of a file's name, however its letters are composed."""
    return unicodedata.normalize("NFC", name).replace("\\", "/").rpartition("/")[2].strip()


def dress_people(
    people: Iterable[PersonRow], wish: Wish, pictures: Mapping[str, Path], holder_of: HolderOf
) -> Iterator[ListRow]:
    """The badge of each row and what it wears, or the row's fault.

    Parameters
    ----------
    pictures
        Files of ours, by `picture_key` of what the visitor calls them, and `FOR_ALL`.

    Raises
    ------
    SpecError
        And DesignError for a wish that no row can have.
    """
    people = list(people)
    wear = wish.wear({"logo": pictures[FOR_ALL]} if FOR_ALL in pictures else None)
    if wear.look(wish.axes) is None and any(
        person.cells.get(column) for person in people for column in PICTURE_COLUMNS
    ):
        # Pictures and colours need room on all boards, which the plain template leaves.
        wish = wish.model_copy(update={"template": "plain"})
        wear = wish.wear()
    request, look = wish.request("Everybody", wear), wear.look(wish.axes)
    for one in design_people(
        people, request, holder_of=holder_of, name_note=name_note, line=next(iter(wish.lines), "")
    ):
        if one.badge is None:
            yield ListRow(one, None, None, str(one.fault))
            continue
        try:
            cells = _own(one.person.cells, pictures)
            # The cells hold paths of ours, so that no file is looked for in a list's folder.
            badge, worn = dressed(one.badge, cells, look, wish.lines, next(iter(pictures.values()), Path()).parent)
            check_look(badge, worn)
        except SpecError as error:
            where = f"row {one.person.row} of the list ({one.person.name[:40]!r})"
            yield ListRow(one, None, None, f"{where}: {error}")
            continue
        yield ListRow(one, badge, worn, None)


def _own(cells: Mapping[str, str], pictures: Mapping[str, Path]) -> dict[str, str]:
    """The cells with our files in the place of those that they name.  Raises: SpecError where one was not chosen."""
    own = dict(cells)
    for what in NAMED:
        if not (cell := cells.get(what)):
            continue
        if (file := _found(cell, pictures)) is None:
            raise SpecError(
                f"the {what} {cell[:80]!r} is not among the pictures that were chosen; choose that file too, or leave "
                "the cell empty"
            )
        own[what] = file.name
    return own


def _found(cell: str, pictures: Mapping[str, Path]) -> Path | None:
    """The picture that a cell names: of that very name, or the only one that differs in capitals alone."""
    key = picture_key(cell)
    if key in pictures:
        return pictures[key]
    alike = [file for name, file in pictures.items() if name.casefold() == key.casefold()]
    return alike[0] if len(alike) == 1 else None


def understood(people_csv: bytes, wish: Wish, registry: Registry, pictures: Mapping[str, Path]) -> ParsedList:
    """How a list was understood, row by row: row, name, id (None where there is a fault, or it will be drawn), fault,
    note, line.

    Parameters
    ----------
    pictures
        As for `dress_people`.

    Raises
    ------
    SpecError
        Where the list as a whole cannot be read, or names too many.
    """
    found = parse_people(people_csv)
    people = found.people
    if len(people) > MOST_AT_AN_EVENT:
        raise SpecError(
            f"the list names {len(people)} people, and {MOST_AT_AN_EVENT} can be issued from a page at once; split it"
        )
    dressed_rows = list(dress_people(people, wish, pictures, registry.by_id))
    names = [one.badge.name for one in dressed_rows if one.badge]
    alike = {
        name: [f"{other.name} ({other.id})" for other in found] for name, found in registry.look_alikes(names).items()
    }
    for name, other in alike_within(names):
        alike.setdefault(name, []).append(f"{other}, who is in this list")
    rows = [_row(one, registry, alike.get(one.badge.name, []) if one.badge else []) for one in dressed_rows]
    return ParsedList(rows, [note for note in (*found.notes, _unnamed(people, pictures)) if note])


def _unnamed(people: Iterable[PersonRow], pictures: Mapping[str, Path]) -> str | None:
    """A note on pictures that no row names, which are printed on no badge."""
    named = {_found(cell, pictures) for person in people for what in NAMED if (cell := person.cells.get(what))}
    left = [name for name, file in pictures.items() if name != FOR_ALL and file not in named]
    if not left:
        return None
    more = f" and {len(left) - SHOWN} more" if len(left) > SHOWN else ""
    return (
        f"no row names {', '.join(left[:SHOWN])}{more}, so no badge shows that; a column logo or portrait names files"
    )


def _namesakes(badge: Badge, registry: Registry) -> list[str]:
    """A note where another enrolled person has the same name and the same first line."""
    line = line_of(badge.print)
    same = [one for one in registry.named(badge.name) if one.id != badge.id and one.line == line and not one.barred()]
    if not same:
        return []
    what = f"the name and the line {line[:40]!r}" if line else "the name, and no line"
    return [f"badge {same[0].id} has {what} too, so claims distinguish the two by their ids alone"]


def _row(one: ListRow, registry: Registry, alike: list[str]) -> dict[str, Any]:
    """One row of the table: a badge that another person holds, or that was revoked, is a fault too.

    An identity that is drawn is drawn anew when the list is issued, so it is not shown here.
    """
    person, badge, fault = one.designed.person, one.badge, one.fault
    row, name = person.row, person.name
    notes = [note for note in (one.designed.note, one.designed.name_note) if note]
    notes += look_notes(badge, one.look) if badge is not None else []
    notes += [f"looks like {other}, in other letters or case" for other in alike[:1]]
    notes += _namesakes(badge, registry) if badge is not None else []
    holder = registry.by_id(badge.id or "") if badge is not None else None
    if holder is not None and holder.revoked_at is not None:
        fault = f"row {row} ({name[:40]!r}): badge {holder.id} was revoked; give another payload in that row"
    elif holder is not None and holder.badge != badge:
        fault = (
            f"row {row} ({name[:40]!r}): badge {holder.id} is held by {holder.name!r} and is another badge; give "
            "another payload in that row"
        )
    elif holder is not None:
        notes.append(f"issued already on {holder.issued_at[:10]}; its files are made again")
    shown_id = badge.id if badge is not None and person.payload and not fault else None
    worn = set(NAMED) if badge is None or one.look is None else shown_pieces(badge, one.look)
    return {
        "row": row,
        "name": name,
        "line": (line_of(badge.print) if badge is not None else person.line) or "",
        "wears": [what for what in NAMED if person.cells.get(what) and what in worn],
        "id": shown_id,
        "fault": fault,
        "note": "; ".join(notes) or None,
    }
