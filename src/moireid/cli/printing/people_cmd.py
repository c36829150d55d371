"""The badges of an event: from a list of people to sheets, folders and a summary."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    REJECT,
    counted,
    echo,
    echo_lines,
    progress_bar,
    report_mount,
    say,
    show_json,
    shown_rows,
)
from moireid.cli.printing.print_options import PrintOrder
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.artwork.placing import Look
    from moireid.badge import Badge
    from moireid.designer.list_table import RowFaults
    from moireid.designer.people import DesignResult
    from moireid.fabrication import Event
    from moireid.fabrication.mount_parts import Parts
    from moireid.registry import Registry

#: So many rows' faults are shown at once.
SHOWN = 10


@dataclass(frozen=True)
class _List:
    """A list that was read; parts: the mount of all; notes: on reading it; designed: without the skipped rows."""

    order: PrintOrder
    path: Path
    parts: Parts
    notes: tuple[str, ...]
    designed: list[DesignResult]
    skipped: RowFaults


def print_people(order: PrintOrder, people_csv: Path) -> None:
    """Make the files of `print-your-badge --people`, and report what was made.

    All rows are checked before any badge is made.
    Raises: SpecError if the list or a row of it cannot be used; then nothing is made.  With `order.skip_bad` such rows
    are left out, and Exit with `REJECT` says so after the rest is made.
    """
    from moireid.designer.drawn import no_holder
    from moireid.designer.people import badges_of, design_people, read_people
    from moireid.fabrication.event import event_files
    from moireid.fabrication.mount_parts import plan_parts
    from moireid.fabrication.page.lettering import name_note
    from moireid.files import planned

    wanted = order.wanted
    holder_of = no_holder if order.registry_url is not None else None
    # An impossible request is refused before a registry is made for it.
    faults: RowFaults = {}
    listed = read_people(people_csv, faults=faults)
    designed = list(
        design_people(
            listed.people,
            wanted.request,
            holder_of=holder_of,
            source=str(people_csv),
            name_note=name_note,
            line=next(iter(wanted.wear.lines), ""),
        )
    )
    good = []
    for one in designed:
        fault = one.fault or _look_fault(order, people_csv, one)
        if fault is None:
            good.append(one)
        else:
            faults[one.person.row] = fault
    held = _held(order, people_csv, good)
    faults |= held
    good = [one for one in good if one.person.row not in held]
    skipped = dict(sorted(faults.items()))
    _report_faults(skipped, people_csv, listed.notes, some=bool(good), skip=order.skip_bad)
    badges = badges_of(good)
    parts = plan_parts(badges[0], wanted.mount or "none", wanted.figures)
    found = _List(order, people_csv, parts, listed.notes, good, skipped)
    if order.registry_url is None:
        _make(found, None)
    else:
        files = [order.folder / name for name in event_files(badges, parts)]
        planned(files, overwrite=order.overwrite, make_folders=False, kept=[people_csv, *order.kept])
        from moireid.registry import open_registry

        with open_registry(order.registry_url, create=True, actor=order.actor) as registry:
            _make(found, registry)
    if skipped:
        raise click.exceptions.Exit(REJECT)


def _look_fault(order: PrintOrder, path: Path, one: DesignResult) -> SpecError | None:
    """What is wrong with the lines and pictures of a row."""
    assert one.badge is not None
    try:
        _dress(order, path, one, one.badge)
    except SpecError as error:
        return error
    return None


def _held(order: PrintOrder, path: Path, rows: Sequence[DesignResult]) -> RowFaults:
    """What is wrong with rows whose identity the registry has already: as another badge, or as a revoked one.

    The very badge that it has may be printed again.
    """
    from moireid.errors import RegistryError
    from moireid.registry import open_registry

    found: RowFaults = {}
    given = [one for one in rows if one.person.payload]
    if order.registry_url is None or not given:
        return found
    try:
        with open_registry(order.registry_url, create=False, actor=order.actor) as registry:
            holders = [(one, registry.by_id(one.badge.id or "")) for one in given if one.badge is not None]
    except RegistryError:
        # A registry that is absent has no one yet; what else is wrong with it is said when the list is issued.
        return found
    for one, holder in holders:
        if holder is None or one.badge is None:
            continue
        where = f"row {one.person.row} of {path.name} ({one.person.name[:40]!r}): badge {holder.id}"
        remedy = "give another payload, or none, and one is drawn"
        if holder.revoked_at is not None:
            found[one.person.row] = SpecError(
                f"{where} of {holder.name!r} was revoked ({holder.revoked_reason}); {remedy}"
            )
        elif holder.badge != _dress(order, path, one, one.badge)[0]:
            found[one.person.row] = SpecError(
                f"{where} is enrolled already, of {holder.name!r}, and is another badge; {remedy}"
            )
        elif order.expires not in (None, holder.expires):
            until = f"expires on {holder.expires}" if holder.expires else "has no day of expiry"
            found[one.person.row] = SpecError(f"{where} is enrolled already and {until}, which stays; {remedy}")
    return found


def _report_faults(faults: RowFaults, path: Path, notes: Sequence[str], *, some: bool, skip: bool) -> None:
    """Say on stderr what is wrong with each row.

    Parameters: notes: on reading the list, which may name the cause; some: whether other rows are good; skip: whether
    the rows are to be left out.
    Raises: SpecError unless there is none, or the rows are to be left out and some are good.
    """
    if skip and some:
        for fault in faults.values():
            say(f"skipped: {fault}")
        return
    for note in notes if faults else ():
        say(f"note: {note}")
    if len(faults) == 1:
        raise next(iter(faults.values()))
    for fault in list(faults.values())[:SHOWN]:
        say(f"fault: {fault}")
    if len(faults) > SHOWN:
        say(f"fault: and {len(faults) - SHOWN} rows more")
    if faults:
        remedy = "correct them, or leave them out with --skip-bad" if some else "correct them"
        raise SpecError(f"{len(faults)} rows of {path.name} cannot be printed, and nothing was made; {remedy}")


def _make(found: _List, registry: Registry | None) -> None:
    """Make and issue the badges of a list, and report them."""
    from moireid.artwork.columns import kept_pictures
    from moireid.designer import explain
    from moireid.designer.people import badges_of, without_held
    from moireid.fabrication.event import print_event

    order, designed = found.order, found.designed
    drawn = badges_of(without_held(designed, order.wanted.request, registry.by_id) if registry else designed)
    badges, looks = _dressed(found, drawn)
    notes = _notes(found, badges, looks, registry)
    for note in notes:
        say(f"note: {note}")
    issue = (lambda: registry.enroll_many(badges, warned=True, expires=order.expires)) if registry else None
    with progress_bar("making badges") as progress:
        event = print_event(
            badges,
            order.folder,
            measured_scale=order.measured_scale,
            parts=found.parts,
            looks=looks,
            overwrite=order.overwrite,
            kept=[found.path, *order.kept, *kept_pictures(looks)],
            before_moving=issue,
            progress=progress,
            processes=os.cpu_count() or 1,
        )
    report_mount(event.left_out, event.removed)
    if order.as_json:
        own = {
            "issued": registry is not None,
            "skipped": [{"row": row, "why": str(fault)} for row, fault in found.skipped.items()],
            "measured_scale": order.measured_scale,
            "explain": dict(explain(badges[0])),
        }
        show_json(_document(event, badges, notes) | own)
    else:
        _print_summary(event, badges)
        if order.explain:
            echo_lines(shown_rows(explain(badges[0])))


def _dressed(found: _List, badges: Sequence[Badge]) -> tuple[list[Badge], list[Look | None]]:
    """Each badge with its row's lines, and what it wears.  Raises: SpecError that names the row."""
    pairs = zip(found.designed, badges, strict=True)
    worn = [_dress(found.order, found.path, one, badge) for one, badge in pairs]
    return [badge for badge, _ in worn], [look for _, look in worn]


def _dress(order: PrintOrder, path: Path, one: DesignResult, badge: Badge) -> tuple[Badge, Look | None]:
    """A badge with its row's lines, and what it wears.  Raises: SpecError that names the row."""
    from moireid.artwork.columns import dressed
    from moireid.fabrication.page.marks import check_look

    wear = order.wanted.wear
    usual = wear.look(order.wanted.request.axes)
    try:
        badge, look = dressed(badge, one.person.cells, usual, wear.lines, path.parent)
        check_look(badge, look)
    except SpecError as error:
        raise SpecError(f"row {one.person.row} of {path.name} ({one.person.name[:40]!r}): {error}") from error
    return badge, look


def _notes(found: _List, badges: Sequence[Badge], looks: Sequence[Look | None], registry: Registry | None) -> list[str]:
    """The notes on a list: guesses, texts that are printed in part, namesakes and look-alikes."""
    from moireid.cli.issue_notes import alike_in_list_notes, look_alike_notes, namesake_notes
    from moireid.fabrication.page.marks import look_notes

    set_in_part = [
        f"row {one.person.row}: {note}"
        for one, badge, look in zip(found.designed, badges, looks, strict=True)
        for note in (one.name_note, *look_notes(badge, look))
        if note
    ]
    shorter = dict.fromkeys(one.note for one in found.designed if one.note)
    alike = alike_in_list_notes(badges)
    if registry:
        alike += namesake_notes(badges, registry) + look_alike_notes(badges, registry)
    return [note for note in (*found.notes, *set_in_part, *shorter, *alike) if note]


def _document(event: Event, badges: Sequence[Badge], notes: list[str]) -> dict[str, Any]:
    """What `--json` prints, without whether the badges were issued."""
    from moireid.names import line_of

    people = [
        {"name": badge.name, "line": line_of(badge.print), "id": badge.id, "folder": str(place)}
        for badge, place in zip(badges, event.folders, strict=True)
    ]
    files = {"badges.pdf": str(event.sheets), "summary.csv": str(event.summary)}
    return {
        "mount_mass_g": event.mount_mass_g,
        "mount_figures": event.mount_figures,
        "left_out": event.left_out,
        "removed": [str(path) for path in event.removed],
        "people": people,
        "files": files | {name: str(path) for name, path in event.mount.items()},
        "notes": notes,
        "sheets": event.sheet_count,
        "boards_to_a_sheet": event.boards_to_a_sheet,
    }


def _print_summary(event: Event, badges: Sequence[Badge]) -> None:
    """Print what was made, and what to do with it."""
    from moireid.fabrication.shopping.shopping_list import front_words

    count, alone = len(badges), len(badges) == 1
    sheets, most = counted(event.sheet_count, "sheet"), event.boards_to_a_sheet
    echo(f"{counted(count, 'badge')} on {sheets}" + (":" if alone else f", {most} to a sheet:"))
    folders = "" if alone else " and so on, a folder for each person"
    for line in (event.sheets, event.summary, f"{event.folders[0]}{folders}"):
        echo(f"  {line}")
    if event.mount:
        echo("The mount:" if alone else f"One mount for all, to be made {count} times:")
        for path in event.mount.values():
            echo(f"  {path}")
    if badges[0].lens.kind == "mask":
        times = "once" if alone else f"{count} times"
        echo(f"The last page of badges.pdf is the mask: print it {times}, on clear film.")
    echo("Print badges.pdf at 100 %; each folder's assembly.pdf says how to go on.")
    echo(f"On the card: {front_words(badges[0])}.")
    echo(f"What to buy: moireid materials --people {count} --badge {event.folders[0] / 'badge.json'}")
