"""A list of people in the studio: each row's badge with its lines and looks, and how the list was understood.

A list in the studio has no folder.  Its columns logo and portrait name files that the visitor chose together with it,
so a cell finds one of those, by the last part of what it says, and never a file of this machine.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from moireid.artwork.columns import lines_in
from moireid.artwork.placing import shown_pieces
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.names import line_of
from moireid.people import PersonRow, plan_people
from moireid.registry import Registry
from moireid.registry.look_alikes import alike_within
from moireid_studio.jobs.orders import VisitorOrder

#: An event's badges are made one after the other in one child; a larger one is for the command line.
MOST_AT_AN_EVENT = 300
#: The key of the logo that all badges wear which have none of their own; no file's `picture_key` has a stroke.
FOR_ALL = "/for all"
#: The columns whose cells name files.
NAMED = ("logo", "portrait")
#: Most pictures that are listed by name because no row names them.
SHOWN = 5


def picture_key(name: str) -> str:
    """By what a cell of a list finds a picture: the last part of a file's name, however its letters are composed."""
    return unicodedata.normalize("NFC", name).replace("\\", "/").rpartition("/")[2].strip()


def plan_list(
    people_csv: bytes, order: VisitorOrder, registry: Registry, pictures: Mapping[str, Path]
) -> tuple[list[PersonRow], list[str]]:
    """The badge of each row and what it wears, or the row's fault; and notes on the list.

    Parameters
    ----------
    pictures
        Files of ours, by `picture_key` of what the visitor calls them, and `FOR_ALL`.

    Raises
    ------
    SpecError
        Where the list as a whole cannot be read, or names too many; and DesignError for what no row can have.
    """

    def find(what: str, cell: str) -> Path:
        if (file := _found(cell, pictures)) is None:
            raise SpecError(
                f"the {what} {cell[:80]!r} is not among the pictures that were chosen; choose that file too, or leave "
                "the cell empty"
            )
        return file

    own = order.with_files({"logo": pictures[FOR_ALL]} if FOR_ALL in pictures else {})
    return plan_people(people_csv, own, find, holder_of=registry.by_id, most=MOST_AT_AN_EVENT)


def _found(cell: str, pictures: Mapping[str, Path]) -> Path | None:
    """The picture that a cell names: of that very name, or the only one that differs in capitals alone."""
    key = picture_key(cell)
    if key in pictures:
        return pictures[key]
    alike = [file for name, file in pictures.items() if name.casefold() == key.casefold()]
    return alike[0] if len(alike) == 1 else None


def understood(
    people_csv: bytes, order: VisitorOrder, registry: Registry, pictures: Mapping[str, Path]
) -> tuple[list[dict[str, Any]], list[str]]:
    """How a list was understood, row by row: row, name, id (None where there is a fault, or it will be drawn), fault,
    note, line; and notes on the whole.  Parameters and errors as of `plan_list`.
    """
    rows, notes = plan_list(people_csv, order, registry, pictures)
    names = [one.badge.name for one in rows if one.badge]
    alike = {
        name: [f"{other.name} ({other.id})" for other in found] for name, found in registry.look_alikes(names).items()
    }
    for name, other in alike_within(names):
        alike.setdefault(name, []).append(f"{other}, who is in this list")
    shown = [_row(one, registry, alike.get(one.badge.name, []) if one.badge else []) for one in rows]
    return shown, [note for note in (*notes, _unnamed(rows, pictures)) if note]


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
    """A note where another enrolled person has the same name."""
    same = [one for one in registry.named(badge.name) if one.id != badge.id and not one.barred()]
    return [f"badge {one.id} has the name too, so claims distinguish the two by their ids alone" for one in same[:1]]


def _row(one: PersonRow, registry: Registry, alike: list[str]) -> dict[str, Any]:
    """One row of the table.  An identity that is drawn is drawn anew when the list is issued, so it is not shown."""
    badge, notes = one.badge, list(one.notes)
    notes += [f"looks like {other}, in other letters or case" for other in alike[:1]]
    notes += _namesakes(badge, registry) if badge is not None else []
    if one.holder is not None:
        notes.append(f"issued already on {one.holder.issued_at[:10]}; its files are made again")
    worn = set(NAMED) if badge is None or badge.look is None else shown_pieces(badge, badge.look)
    line = next(iter(lines_in(one.cells)), None) if badge is None else line_of(badge.print)
    return {
        "row": one.row,
        "name": one.name,
        "line": line or "",
        "wears": [what for what in NAMED if one.cells.get(what) and what in worn],
        "id": badge.id if badge is not None and one.cells.get("payload") else None,
        "fault": one.fault,
        "note": "; ".join(notes) or None,
    }
