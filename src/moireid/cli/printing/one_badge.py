"""One person's badge, from an order to its files.

`PrintOrder` holds what is to be printed, for one person or for a list.  `gathered` collects the options of one subject
into one argument of a command.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import report_mount, say, show_json, shown_rows, status_line
from moireid.cli.printing.wear import Wear

if TYPE_CHECKING:
    from moireid.designer import Request
    from moireid.designer.drawn import DrawnBadge
    from moireid.fabrication.process import MountFigures
    from moireid.registry import Registry


#: A command's function, or a decorator of it.
Command = Callable[..., Any]


def gathered(name: str, into: type, options: Sequence[Command]) -> Command:
    """Give a command these options; it takes them as the argument `name`, a dataclass with a field for each."""

    def given_to(command: Command) -> Command:
        @wraps(command)
        def taking(*args: Any, **given: Any) -> Any:
            own = into(**{field.name: given.pop(field.name) for field in fields(into)})
            return command(*args, **{name: own}, **given)

        for option in reversed(options):
            taking = option(taking)
        return taking

    return given_to


@dataclass(frozen=True)
class PrintOrder:
    """What badge to make, where its files go, and how to report it.

    request: without a person's name if there are many; mount: None if no mount was asked for; measured_scale: x and y;
    kept: files that were read, which no output may replace; registry_url: where to enter the badge, None for nowhere;
    actor: who enters it; expires: its last day.
    """

    request: Request
    wear: Wear
    mount: str | None
    figures: MountFigures
    measured_scale: tuple[float, float]
    folder: Path
    kept: tuple[Path, ...]
    registry_url: str | None
    actor: str | None
    expires: str | None
    overwrite: bool
    as_json: bool
    explain: bool


def print_one(order: PrintOrder, payload: bytes | None) -> None:
    """Make the badge, enter it in the registry if there is one, and report it.

    Parameters: payload: the identity; None to draw one.
    Raises: MoireIdError if the badge cannot be made; then no file and no registry is made.
    """
    from moireid.artwork.content import with_lines
    from moireid.designer.drawn import drawn_badge, no_holder
    from moireid.fabrication.package import file_names
    from moireid.fabrication.page.dress import check_look
    from moireid.fabrication.page.lettering import name_note
    from moireid.files import planned

    # An impossible request is refused before a registry is made for it.
    drawn = drawn_badge(order.request, payload, no_holder if order.registry_url is not None else None)
    trial = drawn.badge
    name_note(trial.name)
    check_look(with_lines(trial, order.wear.lines), order.wear.look(order.request.axes))
    mount, parts, note = order.wear.parts(trial, order.mount, order.figures)
    if order.registry_url is None:
        _make(order, drawn, mount, note, None)
        return
    from moireid.registry import open_registry

    files = [order.folder / name for name in file_names(parts, moving=True)]
    planned(files, overwrite=order.overwrite, make_folders=False, kept=order.kept)
    with open_registry(order.registry_url, create=True, actor=order.actor) as registry:
        if payload is not None or registry.by_id(trial.id or "") is not None:
            drawn = drawn_badge(order.request, payload, registry.by_id)
        _make(order, drawn, mount, note, registry)


def _make(order: PrintOrder, drawn: DrawnBadge, mount: str, about_mount: str | None, registry: Registry | None) -> None:
    """Make and issue the badge, and report it."""
    from moireid.artwork.content import with_lines
    from moireid.cli.issue_notes import derived_notes, look_alike_notes, namesake_notes
    from moireid.designer import explain as explain_badge
    from moireid.fabrication.package import print_badge
    from moireid.fabrication.page.dress import look_notes
    from moireid.fabrication.page.lettering import name_note

    badge = with_lines(drawn.badge, order.wear.lines)
    look = order.wear.look(order.request.axes)
    others = [*namesake_notes([badge], registry), *look_alike_notes([badge], registry)] if registry else []
    printed_in_part = (name_note(badge.name), *look_notes(badge, look))
    possible = (about_mount, *printed_in_part, drawn.note, *derived_notes([badge]), *others)
    notes = [note for note in possible if note]
    for note in notes:
        say(f"note: {note}")
    issue = (lambda: registry.enroll(badge, warned=True, expires=order.expires)) if registry else None
    with status_line() as show_status:
        printed = print_badge(
            badge,
            order.folder,
            mount=mount,
            measured_scale=order.measured_scale,
            figures=order.figures,
            look=look,
            overwrite=order.overwrite,
            kept=order.kept,
            before_moving=issue,
            progress=lambda file: show_status(f"making {file}"),
        )
    files = {name: str(path) for name, path in printed.files.items()}
    report_mount(printed.left_out, printed.removed)
    rows = explain_badge(badge)
    if order.as_json:
        show_json(
            {
                "id": badge.id,
                "name": badge.name,
                "files": files,
                "issued": registry is not None,
                "notes": notes,
                "mount_mass_g": printed.mount_mass_g,
                "mount_figures": printed.mount_figures,
                "left_out": printed.left_out,
                "removed": [str(path) for path in printed.removed],
                "measured_scale": order.measured_scale,
                "explain": dict(rows),
            }
        )
        return
    entered = ", entered in the registry" if registry else ""
    click.echo(f"Badge {badge.id} for {badge.name}{entered}:")
    for path in files.values():
        click.echo(f"  {path}")
    if order.explain:
        click.echo(shown_rows(rows))
    click.echo("Print badge.pdf at 100 % and follow assembly.pdf.")
