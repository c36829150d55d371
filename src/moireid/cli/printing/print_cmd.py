"""print-your-badge: from a name to the files that a person prints."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    FolderPath,
    actor_option,
    echo,
    echo_lines,
    expires_option,
    friendly,
    json_option,
    overwrite_option,
    printer_option,
    report_mount,
    say,
    scale_option,
    show_json,
    shown_rows,
    status_line,
)
from moireid.cli.issue_notes import look_alike_notes, namesake_notes
from moireid.cli.printing.print_options import (
    Design,
    MountWish,
    PrintOrder,
    design_options,
    mount_options,
    wear_options,
)
from moireid.errors import SpecError
from moireid.issuing import IssueOrder, IssuePlan, Wear, plan_badge

if TYPE_CHECKING:
    from moireid.registry import Registry


@click.command("print")
@click.argument("name", required=False)
@click.option(
    "--people",
    "people_csv",
    type=click.Path(path_type=Path),
    help="Instead of NAME: a list (CSV) with the column name, and line (below the name), payload, logo, portrait and "
    "colour if you like. Makes all badges of an event.",
)
@click.option("--skip-bad", is_flag=True, help="With --people: leave out the rows that cannot be printed.")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the files.")
@click.option(
    "--registry",
    "registry_url",
    metavar="URL|FILE",
    help="Also enter the badge into this registry, as moireid enroll does. It must be given here: no badge is entered "
    "because of MOIREID_REGISTRY.",
)
@click.option("--payload", metavar="HEX", help="The identity: 16 or 32 hex digits; default: drawn at random.")
@wear_options
@printer_option
@design_options
@scale_option
@mount_options
@click.option("--explain", is_flag=True, help="Show the figures of the design.")
@expires_option
@actor_option
@overwrite_option
@json_option
@friendly
def print_command(
    name: str | None,
    people_csv: Path | None,
    skip_bad: bool,
    folder: Path,
    registry_url: str | None,
    payload: str | None,
    scale_text: str | None,
    explain: bool,
    expires: str | None,
    overwrite: bool,
    actor: str | None,
    as_json: bool,
    design: Design,
    wear: Wear,
    wish: MountWish,
) -> None:
    """Make a badge for NAME, ready to print.

    The folder gets badge.pdf (the page to print at 100 %), preview.png and preview.webp (the badge as worn; the second
    moves), assembly.pdf (how to build it), the files of a mount, and badge.json, which the other commands read.

    The identity is a random number, so the same name printed twice gives two different badges: keep the folder, as
    badge.json is the only copy. It has 128 bits if badge and range can carry them; with --registry it has 64, which no
    one else in that registry has.

    With --people, badges are made for many people: sheets with as many badges as fit, a folder for each person, and a
    summary. With --mount too, one set of mount files serves them all. All rows are checked first: if one cannot be
    printed, none is, unless --skip-bad leaves it out.

    Exit code 0: all is made; 1: made without the rows that --skip-bad left out; 2: bad input, and nothing is made.

    \b
    Labels for --lens, with the viewing angle; moireid materials says where
    the figures are from, and what to buy. Measure your sheet's thickness.
    62lpi-27mil   44 degrees       20lpi-2mm     47 degrees
    75lpi-18mil   49 degrees       30lpi-47mil   49 degrees
    100lpi-14mil  42 degrees       40lpi-33mil   49 degrees
    60lpi-1.2mm   26 degrees       40lpi-2mm     25 degrees
    The published prototype's shape, which no one sells, at four pitches:
    40lpi 1.25 mm, 50lpi 1.00 mm, 60lpi 0.84 mm, 75lpi 0.67 mm
    """
    from moireid.designer.request import parse_scale, payload_from_hex

    if (name is None) == (people_csv is None):
        raise SpecError("give either the NAME of one person, or --people with a CSV file of many")
    if expires is not None:
        _check_expiry(expires, registry_url)
    if payload is not None and people_csv is not None:
        raise SpecError("--payload is for one person; give the payloads in a column of the CSV file")
    chosen = None if payload is None else payload_from_hex(payload, family=design.code)
    request = design.request("Everybody" if name is None else name)
    request = wear.fit(request, payload_bytes=None if chosen is None else len(chosen))
    order = PrintOrder(
        IssueOrder(request, wear, wish.mount, wish.figures(for_many=people_csv is not None), chosen),
        parse_scale(scale_text) if scale_text else (1.0, 1.0),
        folder,
        tuple(wear.files),
        registry_url,
        actor,
        expires,
        overwrite,
        as_json,
        explain,
        skip_bad,
    )
    if people_csv is None:
        if skip_bad:
            raise SpecError("--skip-bad is about the rows of a list; give it with --people")
        print_one(order)
        return
    from moireid.cli.printing.people_cmd import print_people

    print_people(order, people_csv)


def _check_expiry(expires: str, registry_url: str | None) -> None:
    """Raise SpecError if the day is not in the future, or if there is no registry to store it."""
    from moireid.registry.changes import expiry_day

    expiry_day(expires)
    if registry_url is None:
        raise SpecError("--expires is kept by a registry; give --registry with it, or give it to moireid enroll")


def print_one(order: PrintOrder) -> None:
    """Plan, make and enter the badge, and report it.

    Raises: MoireIdError where the badge cannot be; no file and no registry is made then.
    """
    from moireid.designer.drawn import no_holder
    from moireid.files import planned

    # A wish that cannot be is refused before a registry is made for it.
    plan = plan_badge(order.wanted, no_holder if order.registry_url is not None else None)
    if order.registry_url is None:
        _make(order, plan, None)
        return
    from moireid.registry import open_registry

    files = [order.folder / name for name in plan.files]
    planned(files, overwrite=order.overwrite, make_folders=False, kept=order.kept)
    with open_registry(order.registry_url, create=True, actor=order.actor) as registry:
        if registry.by_id(plan.badge.id or "") is not None:
            plan = plan_badge(order.wanted, registry.by_id)
        _make(order, plan, registry)


def _make(order: PrintOrder, plan: IssuePlan, registry: Registry | None) -> None:
    """Make and issue the badge, and report it."""
    from moireid.designer import explain as explain_badge
    from moireid.fabrication.package import print_badge

    badge = plan.badge
    others = [*namesake_notes([badge], registry), *look_alike_notes([badge], registry)] if registry else []
    notes = [*plan.notes, *others]
    for note in notes:
        say(f"note: {note}")
    issue = (lambda: registry.enroll(badge, warned=True, expires=order.expires)) if registry else None
    with status_line() as show:
        printed = print_badge(
            badge,
            order.folder,
            parts=plan.parts,
            look=plan.look,
            measured_scale=order.measured_scale,
            overwrite=order.overwrite,
            kept=order.kept,
            before_moving=issue,
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
    from moireid.fabrication.shopping.shopping_list import front_words

    entered = ", entered in the registry" if registry else ""
    echo(f"Badge {badge.id} for {badge.name}{entered}:")
    for path in files.values():
        echo(f"  {path}")
    if order.explain:
        echo_lines(shown_rows(rows))
    echo("Print badge.pdf at 100 % and follow assembly.pdf.")
    echo(f"On the card: {front_words(badge)}.")
    echo(f"What to buy: moireid materials --badge {files['badge.json']}")
