"""The badges of an event: from a list of people to sheets, folders and a summary."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import progress_bar, say, show_json, tell_mount
from moireid.errors import MoireIdError, SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.designer import Request
    from moireid.fabrication.process import MountFigures
    from moireid.registry import Registry

MOST_PEOPLE = 10_000


def print_people(
    people_csv: Path, request: Request, folder: Path, registry_url: str | None, measured_scale: tuple[float, float], *,
    mount: str, figures: MountFigures, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Make what `print-your-badge --people` makes, and say what was made.

    Raises: SpecError where the list or a row of it cannot be used; nothing is made then.
    """
    from moireid.fabrication.event import print_event
    from moireid.fabrication.parts import plan_parts

    badges = designed(people_csv, request)
    # A wish that cannot be is refused before a registry is made for it.
    plan_parts(badges[0], mount, figures)

    def work(registry: Registry | None) -> None:
        issue = (lambda: registry.enroll_many(badges)) if registry else None
        with progress_bar("making badges") as progress:
            event = print_event(
                badges, folder, measured_scale=measured_scale, mount=mount, figures=figures, overwrite=overwrite,
                before_moving=issue, progress=progress,
            )  # fmt: skip
        tell_mount(event.left_out, event.removed)
        if as_json:
            people = [
                {"name": badge.name, "id": badge.id, "folder": str(place)}
                for badge, place in zip(badges, event.folders, strict=True)
            ]
            files = {"badges.pdf": str(event.sheets), "summary.csv": str(event.summary)}
            files |= {name: str(path) for name, path in event.mount.items()}
            counts = {"sheets": event.sheet_count, "boards_to_a_sheet": event.boards_to_a_sheet}
            told: dict[str, Any] = {"mount_mass_g": event.mount_mass_g, "mount_figures": event.mount_figures}
            told |= {"left_out": event.left_out, "removed": [str(path) for path in event.removed]}
            show_json({"people": people, "files": files, "issued": registry is not None} | counts | told)
            return
        click.echo(f"{len(badges)} badges on {event.sheet_count} sheets, {event.boards_to_a_sheet} to a sheet:")
        click.echo(f"  {event.sheets}\n  {event.summary}\n  {event.folders[0]} and so on, a folder for each person")
        if event.mount:
            click.echo(f"One mount for all, to be made {len(badges)} times:")
            for path in event.mount.values():
                click.echo(f"  {path}")
        if badges[0].lens.kind == "mask":
            click.echo(f"The last page of badges.pdf is the mask: print it {len(badges)} times, on clear film.")
        click.echo("Print badges.pdf at 100 %; each folder's assembly.pdf says how to go on.")

    if registry_url is None:
        work(None)
        return
    from moireid.registry import open_registry

    with open_registry(registry_url, create=True) as registry:
        work(registry)


def designed(people_csv: Path, request: Request) -> list[Badge]:
    """A badge for each row of the list, in its order.

    Raises: SpecError that names the row where one cannot be used, or two would have one identity.
    """
    from moireid.designer import design_badge, payload_for_name, payload_from_hex
    from moireid.designer.request import clean_name
    from moireid.fabrication.lettering import missing_note

    badges: list[Badge] = []
    rows: dict[str, int] = {}
    for number, name, payload in read_people(people_csv):
        try:
            named = replace(request, name=clean_name(name))
            family = request.family or "spacing"
            given = payload_from_hex(payload, family=family) if payload else None
            badge = design_badge(named, given or payload_for_name(named.name, family=family))
        except MoireIdError as error:
            raise SpecError(f"row {number} of {people_csv.name} ({name[:40]!r}): {error}") from error
        badge_id = badge.id or ""
        if badge_id in rows:
            raise SpecError(
                f"rows {rows[badge_id]} and {number} of {people_csv.name} give one identity, {badge_id}; for two "
                "people of one name give a column payload with 16 hex digits"
            )
        rows[badge_id] = number
        badges.append(badge)
    if note := missing_note(badges):
        say(f"note: {note}")
    return badges


def read_people(people_csv: Path) -> list[tuple[int, str, str]]:
    """Row number, name and payload (empty where none is given) of each person.

    Raises: SpecError where the file cannot be read, has not one column `name`, has a row with more cells than its first
        line, or names nobody or too many.
    """
    try:
        text = people_csv.read_text(encoding="utf-8-sig")
        # Not splitlines, which would make two people of a name that holds a line separator.
        rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else f"no CSV in UTF-8: {error}"
        raise SpecError(f"list {people_csv} cannot be read ({reason}); give a CSV file with a column name") from error
    header = [cell.strip().lower() for cell in rows[0]] if rows else []
    if "name" not in header:
        raise SpecError(
            f"list {people_csv} has no column name; its first line must be 'name' or 'name,payload', got "
            f"{','.join(header)[:60]!r}"
        )
    for column in ("name", "payload"):
        if header.count(column) > 1:
            raise SpecError(f"list {people_csv} has {header.count(column)} columns {column}; leave one of them")
    place = {column: header.index(column) for column in ("name", "payload") if column in header}
    people = []
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        # A name with a comma in it, and no quotes about it, would be printed cut short.
        if any(cell.strip() for cell in row[len(header) :]):
            raise SpecError(
                f"row {number} of {people_csv.name} has {len(row)} cells, and the first line {len(header)}; put quotes "
                'about a name with a comma in it, as in "Doe, Jane"'
            )
        cells = {column: row[k].strip() if k < len(row) else "" for column, k in place.items()}
        people.append((number, cells["name"], cells.get("payload", "")))
    if not 1 <= len(people) <= MOST_PEOPLE:
        raise SpecError(f"list {people_csv} names {len(people)} people; 1 to {MOST_PEOPLE} can be printed at once")
    return people
