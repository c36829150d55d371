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
from moireid.issuing.wear import Wear

if TYPE_CHECKING:
    from moireid.designer import Request
    from moireid.fabrication.process_figures import MountFigures
    from moireid.issuing.plan import IssuePlan
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
    """What the badge is to be, where its files go, and how to report it.

    request: without a person's name where there are many; mount: None where no mount was named; measured_scale: x and
    y; kept: files that were read, which nothing may replace; registry_url, actor, expires: of who enters the badge,
    None for no registry.
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
    """Plan, make and enter the badge, and report it.

    Parameters: payload: the identity; None for one that is drawn.
    Raises: MoireIdError where the badge cannot be; no file and no registry is made then.
    """
    from moireid.designer.drawn import no_holder
    from moireid.files import planned
    from moireid.issuing.plan import IssueOrder, plan_badge

    wanted = IssueOrder(order.request, order.wear, order.mount, order.figures, payload)
    # A wish that cannot be is refused before a registry is made for it.
    plan = plan_badge(wanted, no_holder if order.registry_url is not None else None)
    if order.registry_url is None:
        _make(order, plan, None)
        return
    from moireid.registry import open_registry

    files = [order.folder / name for name in plan.files]
    planned(files, overwrite=order.overwrite, make_folders=False, kept=order.kept)
    with open_registry(order.registry_url, create=True, actor=order.actor) as registry:
        if registry.by_id(plan.badge.id or "") is not None:
            plan = plan_badge(wanted, registry.by_id)
        _make(order, plan, registry)


def _make(order: PrintOrder, plan: IssuePlan, registry: Registry | None) -> None:
    """Make and issue the badge, and report it."""
    from moireid.cli.issue_notes import derived_notes, look_alike_notes, namesake_notes
    from moireid.designer import explain as explain_badge
    from moireid.issuing.plan import write

    badge = plan.badge
    others = [*namesake_notes([badge], registry), *look_alike_notes([badge], registry)] if registry else []
    notes = [*plan.notes, *derived_notes([badge]), *others]
    for note in notes:
        say(f"note: {note}")
    issue = (lambda: registry.enroll(badge, warned=True, expires=order.expires)) if registry else None
    with status_line() as show:
        printed = write(
            plan,
            order.folder,
            measured_scale=order.measured_scale,
            overwrite=order.overwrite,
            kept=order.kept,
            issue=issue,
            progress=lambda file: show(f"making {file}"),
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
