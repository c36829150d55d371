"""moireid materials: what to buy for badges, and how to cut it; without badges, the table of products."""

from __future__ import annotations

import textwrap
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    FolderPath,
    echo,
    friendly,
    in_options,
    json_option,
    overwrite_option,
    paper_option,
    say,
    show_json,
)
from moireid.cli.printing.print_options import FORMATS, SIZE
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.fabrication.shopping.shopping_list import ShoppingList
    from moireid.materials import Material

#: Width of what is written on a terminal.
WIDE = 100


@click.command("materials")
@click.option(
    "--format", "format_name", type=click.Choice(FORMATS), help="The badges' format, with the sheet that suits it."
)
@click.option("--people", type=int, metavar="N", help="How many badges.  [default: 1]")
@click.option(
    "--badge",
    "badge_file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="A badge.json instead of --format: for a template, a size or a sheet of your own.",
)
@paper_option
@click.option("--lens", envvar="MOIREID_LENS", metavar="LABEL|FILE", help="Another lens sheet than the format's.")
@click.option(
    "--mount",
    type=click.Choice(["lanyard", "clip", "stand", "acrylic", "none"]),
    show_default="none where holders of that size are sold, else lanyard",
    help="What holds the badges: a printed mount, one cut from acrylic, or with none, a holder that is bought.",
)
@click.option(
    "--sheet-size",
    "sheet_mm",
    type=SIZE,
    show_default="210x297",
    metavar="WxH",
    help="Size of a lens sheet in mm: first across the lenses, then along them.",
)
@click.option("--out", "folder", type=FolderPath(), help="Folder for shopping list (CSV) and cutting plan (PDF).")
@overwrite_option
@json_option
@friendly
def materials_command(
    format_name: str | None,
    people: int | None,
    badge_file: Path | None,
    paper: str,
    lens: str | None,
    mount: str | None,
    sheet_mm: tuple[float, float] | None,
    folder: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """List what to buy for badges, how much of it, and how to cut the lens sheets.

    \b
    moireid materials --format a6 --people 40 --out shopping
    moireid materials --badge ada/badge.json
    moireid materials                              the table of products

    The cutting plan has straight cuts from edge to edge, as a paper cutter makes them, and turns no piece: on a badge
    the lenses run as the plan shows. Ask the shop which way its lenses run, and give --sheet-size in that order.

    Every product names the source of its figures, and what no source states: ask the shop for that.
    """
    if badge_file is None and format_name is None:
        if people is not None or folder is not None:
            raise SpecError("--people and --out need the badges: give --format or --badge too")
        _show_table(as_json)
        return
    if badge_file is not None and format_name is not None:
        raise SpecError("give one of --format and --badge")
    from moireid.badge import load_badge
    from moireid.shopping import list_for, usual_badge

    badge = load_badge(badge_file) if badge_file is not None else usual_badge(format_name or "", lens, paper)
    count = 1 if people is None else people
    found = list_for(badge, count, mount=mount, sheet_mm=sheet_mm)
    found = replace(found, notes=tuple(map(in_options, found.notes)))
    files: dict[str, Path] = {}
    if folder is not None:
        from moireid.fabrication.shopping.shopping_files import write_shopping

        files = write_shopping(found, folder, overwrite=overwrite, kept=[badge_file] if badge_file else [])
    if as_json:
        document: dict[str, Any] = {
            "people": count,
            "lines": [asdict(line) for line in found.lines],
            "notes": found.notes,
        }
        if found.cutting is not None:
            document["cutting"] = {"sheet_mm": found.cutting.sheet_mm, "sheets": found.cutting.sheet_count}
        show_json(document | {"files": {name: str(path) for name, path in files.items()}})
        return
    for words in found.notes:
        say(f"note: {words}")
    _show_list(found)
    for path in files.values():
        echo(f"  {path}")
    if not files:
        echo("Give --out FOLDER for the list as CSV, and for the cutting plan.")


def _show_list(found: ShoppingList) -> None:
    """The list as a table."""
    _show_wrapped("", found.title)
    echo()
    width = max(len(line.amount) for line in found.lines)
    for line in found.lines:
        _show_wrapped(f"{line.amount:>{width}}  ", line.what)
        _show_wrapped(" " * (width + 2), line.note)
    echo()


def _show_wrapped(lead: str, words: str) -> None:
    """Text in lines as wide as a terminal, below its lead."""
    for line in textwrap.wrap(words, WIDE, initial_indent=lead, subsequent_indent=" " * len(lead)):
        echo(line)


def _show_table(as_json: bool) -> None:
    """All products, by kind, with their sources."""
    from msgspec import to_builtins

    from moireid.designer.formats import LENSES_MM, distances
    from moireid.materials import materials

    rows, formats = materials(), distances()
    if as_json:
        columns = ("format", "size", "lens_sheet", *(f"lens_{lens:g}_mm" for lens in LENSES_MM))
        show_json(
            {
                "materials": [to_builtins(row) for row in rows],
                "formats": [dict(zip(columns, f, strict=True)) for f in formats],
            }
        )
        return
    echo("Formats, and from where a film of 1080p is judged, by the camera's lens (full frame; 27 mm: a phone)")
    for cells in [("", "", "", *(f"{lens:g} mm" for lens in LENSES_MM)), *formats]:
        echo("  {:<7} {:<17} {:<12}".format(*cells[:3]) + "".join(f"  {cell:<15}" for cell in cells[3:]).rstrip())
    echo("The badge sways by 12 cm and turns by 9 degrees, for 8 s; move a board more if it is beyond 1.5 m.")
    for kind in dict.fromkeys(row.kind for row in rows):
        echo(f"{kind[0].upper()}{kind[1:]}")
        for row in rows:
            if row.kind == kind:
                _show_row(row)
    echo("For a shopping list: moireid materials --format a6 --people 40 --out shopping")


def _show_row(row: Material) -> None:
    """One product: what to ask for, what its law is, its source, and what no source states."""
    from moireid.sheets import PRODUCTS, angles_in_focus_deg, repeat_deg

    lead = f"  {row.label or '-':<15}"
    shape = "" if row.sold else " (no product: a shape that older badges have)"
    sizes = "" if not row.sizes_mm else "; " + ", ".join(f"{wide:g} x {high:g} mm" for wide, high in row.sizes_mm)
    price = "" if row.price is None else f"; {row.price:g} {row.currency} for {row.per_pack or 1}"
    _show_wrapped(lead, f"{row.words}{sizes}{price}{shape}")
    if row.label is not None and row.angle_deg is not None:
        lens = PRODUCTS[row.label]
        low, high = angles_in_focus_deg(lens)
        traced = (
            f"index {lens.refractive_index:g}, radius {lens.radius_mm:.3f} mm: fringes repeat after "
            f"{repeat_deg(lens):.0f} degrees ({low:.0f} to {high:.0f} for any radius in focus); the "
            f"shop's {row.angle_deg:g} degrees are another angle"
        )
        _show_wrapped(" " * len(lead), traced)
    _show_wrapped(" " * len(lead), f"source: {row.origins}")
    if row.unstated:
        _show_wrapped(" " * len(lead), f"not stated: {row.unstated}")
