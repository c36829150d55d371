"""A list of people (CSV), and the badge of each: used by `--people` and by the studio's page for an event.

Convention: rows are counted as a spreadsheet does, so the first line is row 1 and the first person is in row 2.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.artwork.columns import FindPicture, dressed
from moireid.badge import Badge
from moireid.designer.list_table import Cells, read_list
from moireid.designer.order import Order
from moireid.errors import MoireIdError, SpecError
from moireid.fabrication.page.lettering import name_note
from moireid.fabrication.page.marks import check_look, look_notes
from moireid.issuing import HolderOf, draw, fitted, held, look_of
from moireid.names import LINE_COLUMNS, PICTURE_COLUMNS
from moireid.user_settings import nearest

if TYPE_CHECKING:
    from moireid.registry import Record

MOST_PEOPLE = 10_000
#: So many columns are named of which nothing is printed.
SHOWN = 10


@dataclass(frozen=True)
class PersonRow:
    """One row of a list: its number, the name as given and all cells by column; and its badge, or what is wrong.

    badge: with what it wears; holder: who has this very badge already; notes: on what is not printed of it.
    """

    row: int
    name: str
    cells: Cells
    badge: Badge | None = None
    holder: Record | None = None
    fault: str | None = None
    notes: tuple[str, ...] = ()


def plan_people(
    data: bytes,
    order: Order,
    find: FindPicture,
    *,
    source: str = "the list",
    holder_of: HolderOf | None = None,
    most: int = MOST_PEOPLE,
) -> tuple[list[PersonRow], list[str]]:
    """A badge for each person of a CSV file's bytes, in order, or the fault of that row; and notes on the list.

    An identity that the list does not give is drawn.  If two rows have the same identity, the later one is at fault;
    two rows of one name are a note.

    Parameters: order: of all badges, of no one's name; find: the file of a picture that a cell names; source: names the
        list in messages; holder_of: as for `draw`; most: people at once.
    Raises: SpecError where the list as a whole cannot be read, or names no one or too many people; else as `fitted`.
    """
    columns, listed = read_list(data, source=source)
    if not 1 <= len(listed) <= most:
        raise SpecError(f"{source} names {len(listed)} people; 1 to {most} can be printed at once")
    pictures = any(cells.get(column) for _, cells in listed if isinstance(cells, Mapping) for column in PICTURE_COLUMNS)
    if pictures and look_of(order) is None:
        # Pictures and colours need room on all boards, which the plain template leaves.
        order = replace(order, template="plain")
    wanted, usual = fitted(order)
    notes, rows = [note for note in [_unused(columns, source)] if note], []
    ids: dict[str, int] = {}
    names: dict[str, int] = {}
    for number, cells in listed:
        if isinstance(cells, SpecError):
            rows.append(PersonRow(number, "", {}, fault=str(cells)))
            continue
        person = PersonRow(number, cells["name"], cells)
        try:
            own = replace(wanted, name=person.name, payload=cells.get("payload") or cells.get("id") or None)
            drawn, shorter = draw(own, holder_of, ids)
            badge = dressed(drawn, cells, usual, order.lines, find)
            about = (name_note(badge.name), *look_notes(badge))
            check_look(badge)
            if badge.id in ids:
                raise SpecError(
                    f"row {ids[badge.id]} has its identity {badge.id} too; give another payload in one of them, or "
                    "none, and one is drawn"
                )
            holder = held(badge, holder_of)
        except MoireIdError as error:
            where = f"row {number} of {Path(source).name} ({person.name[:40]!r})"
            rows.append(replace(person, fault=f"{where}: {error}"))
            continue
        ids[badge.id or ""] = number
        rows.append(replace(person, badge=badge, holder=holder, notes=tuple(note for note in about if note)))
        if (twin := names.setdefault(badge.name, number)) != number:
            notes.append(
                f"rows {twin} and {number} bear the name {badge.name[:40]!r}, so claims distinguish them by their ids "
                "alone; names with what each does would distinguish them too"
            )
        elif shorter and shorter not in notes:
            notes.append(shorter)
    return rows, notes


def _unused(columns: Iterable[str], source: str) -> str | None:
    """A note on columns that nothing is printed of, each with the column that may have been meant."""
    known = ("name", *LINE_COLUMNS, "role", "payload", "id", *PICTURE_COLUMNS)
    unused = [f"{column[:40]!r}{nearest(column, known)}" for column in columns if column and column not in known]
    if not unused:
        return None
    more = f" and {len(unused) - SHOWN} more" if len(unused) > SHOWN else ""
    return (
        f"nothing is printed of {Path(source).name}'s column{'s' if len(unused) > 1 else ''} "
        f"{', '.join(unused[:SHOWN])}{more}; the columns that count are {', '.join(known[:-1])}"
    )
