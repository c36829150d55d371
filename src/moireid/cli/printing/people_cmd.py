"""The badges of an event: from a list of people to sheets, folders and a summary."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.cli.common import counted, in_options, progress_bar, report_mount, say
from moireid.cli.issue_notes import alike_in_list_notes, known_holders, look_alike_notes, namesake_notes, opened
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.designer import Order
    from moireid.fabrication.package import PrintResult

#: So many rows' faults are shown at once.
SHOWN = 10


def print_people(
    order: Order, people_csv: Path, folder: Path, registry_url: str | None, how: dict[str, Any]
) -> tuple[dict[str, Any], list[str], list[tuple[str, str]]]:
    """Plan, make and enter the badges of a list; all rows are checked before any badge is made.

    Parameters: order: of all badges; how: as for `print_one`.
    Returns: as `print_one`.
    Raises: SpecError if the list or a row of it cannot be used; then nothing is made.
    """
    from moireid.artwork.columns import files_below, kept_pictures
    from moireid.designer import explain
    from moireid.designer.list_table import unreadable
    from moireid.fabrication.event import event_files, print_event
    from moireid.files import MOST_TABLE_BYTES, planned, read_regular
    from moireid.issuing import choose_parts
    from moireid.names import line_of
    from moireid.people import plan_people

    try:
        data = read_regular(people_csv, MOST_TABLE_BYTES)
    except OSError as error:
        raise unreadable(str(people_csv), f"{error.strerror}; give a CSV file with a column name") from error
    with known_holders(registry_url) as holder_of:
        rows, said = plan_people(
            data, order, files_below(people_csv.parent), source=str(people_csv), holder_of=holder_of
        )
    _check_rows([row.fault for row in rows if row.fault], people_csv, said)
    badges = [row.badge for row in rows if row.badge is not None]
    # A board of no format has the mount that was asked for, or none.
    parts, _ = choose_parts(badges[0], replace(order, format=None, mount=order.mount or "none"))
    kept = [people_csv, *order.files, *kept_pictures(badges)]
    if registry_url is not None:
        files = [folder / name for name in event_files(badges, parts)]
        planned(files, overwrite=how["overwrite"], make_folders=False, kept=kept)
    with opened(registry_url) as registry:
        notes = [*said, *(f"row {row.row}: {note}" for row in rows for note in row.notes), *alike_in_list_notes(badges)]
        if registry:
            notes += namesake_notes(badges, registry) + look_alike_notes(badges, registry)
        notes = [in_options(note) for note in notes]
        for note in notes:
            say(f"note: {note}")
        with progress_bar("making badges") as progress:
            event = print_event(
                badges,
                folder,
                parts=parts,
                kept=kept,
                before_moving=((lambda: registry.enroll_many(badges)) if registry else None),
                progress=progress,
                processes=os.cpu_count() or 1,
                **how,
            )
    report_mount(event)
    people = [
        {"name": badge.name, "line": line_of(badge.print), "id": badge.id, "folder": str(place)}
        for badge, place in zip(badges, event.folders, strict=True)
    ]
    document = {
        "people": people,
        "sheets": event.sheets,
        "boards_to_a_sheet": event.boards_to_a_sheet,
        "issued": registry is not None,
        "notes": notes,
        **event.to_json(),
        "left_out": {shop: in_options(why) for shop, why in event.left_out.items()},
    }
    return document, _summary(event, badges), explain(badges[0])


def _check_rows(faults: Sequence[str], path: Path, notes: Sequence[str]) -> None:
    """Say on stderr what is wrong with each row; notes: on the list, which may name the cause.

    Raises: SpecError unless there is none.
    """
    for note in notes if faults else ():
        say(f"note: {note}")
    if len(faults) == 1:
        raise SpecError(faults[0])
    for fault in faults[:SHOWN]:
        say(f"fault: {fault}")
    if len(faults) > SHOWN:
        say(f"fault: and {len(faults) - SHOWN} rows more")
    if faults:
        raise SpecError(f"{len(faults)} rows of {path.name} cannot be printed, and nothing was made; correct them")


def _summary(event: PrintResult, badges: Sequence[Badge]) -> list[str]:
    """What was made, and what to do with it."""
    from moireid.fabrication.event import OWN_FILES
    from moireid.fabrication.page.sheet_layout import lay_out_sheets
    from moireid.fabrication.shopping.shopping_list import front_words

    count, alone = len(badges), len(badges) == 1
    sheets, most = counted(event.sheets, "sheet"), event.boards_to_a_sheet
    folders = "" if alone else " and so on, a folder for each person"
    sheets += "" if alone else f", {most} to a sheet"
    sheets += ", and a page of pitch bands" * lay_out_sheets(badges[0]).bands_apart
    lines = [f"{counted(count, 'badge')} on {sheets}:"]
    lines += [f"  {line}" for line in (*map(event.files.get, OWN_FILES), f"{event.folders[0]}{folders}")]
    mount = [path for name, path in event.files.items() if name not in OWN_FILES]
    if mount:
        lines.append("The mount:" if alone else f"One mount for all, to be made {count} times:")
        lines += [f"  {path}" for path in mount]
    if badges[0].lens.kind == "mask":
        times = "once" if alone else f"{count} times"
        lines.append(f"The last page of badges.pdf is the mask: print it {times}, on clear film.")
    lines += ["Print badges.pdf at 100 % and follow assembly.pdf."]
    lines.append(f"Lay on the print: {front_words(badges[0])}.")
    lines.append(f"What to buy: moireid materials --people {count} --badge {event.folders[0] / 'badge.json'}")
    return lines
