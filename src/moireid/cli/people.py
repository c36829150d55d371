"""The badges of an event: from a list of people to sheets, folders and a summary."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import progress_bar, say, show_json, tell_mount

if TYPE_CHECKING:
    from moireid.designer import Request
    from moireid.fabrication.process import MountFigures
    from moireid.registry import Registry


def print_people(
    people_csv: Path,
    request: Request,
    folder: Path,
    registry_url: str | None,
    actor: str | None,
    measured_scale: tuple[float, float],
    *,
    mount: str,
    figures: MountFigures,
    overwrite: bool,
    as_json: bool,
    expires: str | None,
) -> None:
    """Make the files of `print-your-badge --people`, and say what was made.

    Raises: SpecError where the list or a row of it cannot be used; nothing is made then.
    """
    from moireid.cli.issue_notes import alike_in_list_notes, derived_notes, look_alike_notes
    from moireid.designer.drawn import nobody
    from moireid.designer.people import badges_of, design_people, read_people, without_held
    from moireid.fabrication.event import print_event
    from moireid.fabrication.page.lettering import missing_note
    from moireid.fabrication.parts import plan_parts

    source, holder_of = str(people_csv), nobody if registry_url is not None else None
    # An impossible wish is refused before a registry is made for it.
    designed = list(design_people(read_people(people_csv), request, holder_of=holder_of, source=source))
    plan_parts(badges_of(designed)[0], mount, figures)

    def work(registry: Registry | None) -> None:
        badges = badges_of(without_held(designed, request, registry.by_id) if registry else designed)
        shorter = dict.fromkeys(one.note for one in designed if one.note)
        alike = alike_in_list_notes(badges) + (look_alike_notes(badges, registry) if registry else [])
        notes = [note for note in (missing_note(badges), *shorter, *derived_notes(badges), *alike) if note]
        for note in notes:
            say(f"note: {note}")
        issue = (lambda: registry.enroll_many(badges, told=True, expires=expires)) if registry else None
        with progress_bar("making badges") as progress:
            event = print_event(
                badges,
                folder,
                measured_scale=measured_scale,
                mount=mount,
                figures=figures,
                overwrite=overwrite,
                kept=[people_csv],
                before_moving=issue,
                progress=progress,
                processes=os.cpu_count() or 1,
            )
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
            told |= {"people": people, "files": files, "issued": registry is not None, "notes": notes}
            show_json(told | counts)
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

    with open_registry(registry_url, create=True, actor=actor) as registry:
        work(registry)
