"""print-your-badge: from a name to the files that a person prints."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    FolderPath,
    GroupedCommand,
    echo,
    echo_lines,
    friendly,
    in_options,
    json_option,
    overwrite_option,
    report_mount,
    say,
    scale_option,
    show_json,
    shown_rows,
    status_line,
)
from moireid.cli.issue_notes import known_holders, look_alike_notes, namesake_notes, opened
from moireid.cli.printing.print_options import GROUPS, order_options
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.designer import Order


@click.command("print", cls=GroupedCommand, groups=GROUPS)
@click.argument("name", required=False)
@click.option(
    "--people",
    "people_csv",
    type=click.Path(path_type=Path),
    help="Instead of NAME: a list (CSV) with the column name, and line (below the name), logo, portrait, colour "
    "and id (of an earlier print) if you like. Makes all badges of an event.",
)
@click.option(
    "--again",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Instead of NAME: a badge.json, whose badge is printed again, as at a --measured-scale. Looks are not in it: "
    "give its template and pictures again.",
)
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the files.")
@click.option(
    "--registry",
    "registry_url",
    metavar="URL|FILE",
    help="Also enter the badge into this registry, as moireid enroll does. It must be given here: no badge is entered "
    "because of MOIREID_REGISTRY.",
)
@order_options
@scale_option
@click.option("--explain", is_flag=True, help="Show the figures of the design.")
@overwrite_option
@json_option
@click.pass_context
@friendly
def print_command(
    context: click.Context,
    name: str | None,
    people_csv: Path | None,
    again: Path | None,
    folder: Path,
    registry_url: str | None,
    measured_scale: tuple[float, float],
    explain: bool,
    overwrite: bool,
    as_json: bool,
    mount_mm: tuple[tuple[str, Any], ...],
    **wish: Any,
) -> None:
    """Make a badge for NAME, ready to print.

    print-your-badge and moireid print are the same program.

    The folder gets badge.pdf (the page to print at 100 %), preview.png and preview.webp (the badge as worn; the second
    moves), fringes.webp (how fringes run, right and wrong), assembly.pdf (how to build it), the files of a mount, and
    badge.json, which the other commands read.

    The identity is a random number, so the same name printed twice gives two different badges: keep the folder, as
    badge.json is the only copy, and print the same badge another time by --again. The identity has 128 bits if badge
    and range can carry them; with --registry it has 64, which no one else in that registry has.

    With --people, badges are made for many people: sheets with as many badges as fit, a folder for each person, and a
    summary. With --mount too, one set of mount files serves them all. All rows are checked first: if one cannot be
    printed, none is.

    Exit code 0: all is made; 2: bad input, and nothing is made.

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
    from moireid.badge import load_badge
    from moireid.cli.printing.people_cmd import print_people
    from moireid.designer import Order
    from moireid.issuing import order_again

    if sum(one is not None for one in (name, people_csv, again)) != 1:
        raise SpecError("give either the NAME of one person, --people with a CSV file of many, or --again")
    if wish["payload"] is not None and people_csv is not None:
        raise SpecError("--payload is for one person; give the payloads in a column of the CSV file")
    badge, figures = None, dict(mount_mm)
    if again is not None:
        badge = load_badge(again)
        order = order_again(badge, mount_mm=figures, **_kept_wishes(context, wish))
    else:
        order = Order("Everybody" if name is None else name, mount_mm=figures, **wish)
    how = {"measured_scale": measured_scale, "overwrite": overwrite}
    if people_csv is None:
        document, lines, rows = print_one(order, folder, registry_url, how, badge)
    else:
        document, lines, rows = print_people(order, people_csv, folder, registry_url, how)
    if as_json:
        show_json(document | {"measured_scale": measured_scale, "explain": dict(rows)})
        return
    for line in lines:
        echo(line)
    if explain:
        echo_lines(shown_rows(rows))


def _kept_wishes(context: click.Context, wish: dict[str, Any]) -> dict[str, Any]:
    """The wishes that a badge of before can still be given.  Raises: SpecError for another one that is given."""
    kept = ("template", "logo", "portrait", "colour", "mount")
    given = [
        param.opts[0]
        for param in context.command.params
        if param.name in wish
        and param.name not in kept
        and context.get_parameter_source(param.name) is click.core.ParameterSource.COMMANDLINE
    ]
    if given:
        raise SpecError(f"--again prints a badge as it was designed; leave {' and '.join(given)} out, or give a NAME")
    return {what: wish[what] for what in kept}


def print_one(
    order: Order,
    folder: Path,
    registry_url: str | None,
    how: dict[str, Any],
    again: Badge | None = None,
) -> tuple[dict[str, Any], list[str], list[tuple[str, str]]]:
    """Plan, make and enter the badge.

    Parameters: how: scale and whether older files are replaced, as for `fabrication.print_badge`; again: a badge
    of before, whose files are made.
    Returns: what `--json` prints, what is printed else, and the figures of the design.
    Raises: MoireIdError where the badge cannot be; no file and no registry is made then.
    """
    from moireid.designer import explain
    from moireid.fabrication.package import print_badge
    from moireid.fabrication.shopping.shopping_list import front_words
    from moireid.files import planned
    from moireid.issuing import held, plan_badge, plan_package

    with known_holders(registry_url) as holder_of:
        package = plan_badge(order, holder_of) if again is None else plan_package(again, order, held(again, holder_of))
    badge = package.badge
    if registry_url is not None:
        files = [folder / name for name in package.files]
        planned(files, overwrite=how["overwrite"], make_folders=False, kept=order.files)
    with opened(registry_url) as registry:
        others = [*namesake_notes([badge], registry), *look_alike_notes([badge], registry)] if registry else []
        notes = [in_options(note) for note in [*package.notes, *others]]
        if again is not None and order.format not in (None, "board") and not (order.template or order.files):
            notes.append("template and pictures are not in badge.json; give them again, if the badge had other ones")
        for note in notes:
            say(f"note: {note}")
        with status_line() as show:
            printed = print_badge(
                badge,
                folder,
                parts=package.parts,
                kept=order.files,
                before_moving=(lambda: registry.enroll(badge)) if registry else None,
                progress=lambda file: show(f"making {file}"),
                **how,
            )
    report_mount(printed)
    entered = ", entered in the registry" if registry else ""
    lines = [f"Badge {badge.id} for {badge.name}{entered}:", *(f"  {path}" for path in printed.files.values())]
    lines += ["Print badge.pdf at 100 % and follow assembly.pdf.", f"Lay on the print: {front_words(badge)}."]
    if not order.ink_growth_um:
        lines.append("The printer's ink growth is taken as 0: moireid first-badge measures it, and the sheet.")
    lines.append(f"What to buy: moireid materials --badge {folder / 'badge.json'} --mount {package.parts.printed}")
    document = {
        "id": badge.id,
        "name": badge.name,
        "issued": registry is not None,
        "notes": notes,
        **printed.to_json(),
        "left_out": {shop: in_options(why) for shop, why in printed.left_out.items()},
    }
    return document, lines, explain(badge)
