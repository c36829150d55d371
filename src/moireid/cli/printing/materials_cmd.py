"""moireid materials: what to buy for badges, and how to cut it; without badges, the table of products."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    FiniteRange,
    FolderPath,
    SettingOption,
    friendly,
    json_option,
    overwrite_option,
    say,
    show_json,
)
from moireid.cli.printing.materials_view import list_document, show_list, show_table
from moireid.cli.printing.print_options import FORMATS, ORIENTATIONS
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge

SUMMARY = "summary.csv"


@dataclass(frozen=True)
class _Order:
    """The badge, its format's name (None for another size), for how many, its mount, and files that were read."""

    badge: Badge
    form: str | None
    people: int
    mount: str | None
    kept: tuple[Path, ...] = ()


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
@click.option(
    "--event",
    type=click.Path(path_type=Path),
    metavar="FOLDER|CSV",
    help="The folder that --people made, or its list of people (CSV) with --format.",
)
@click.option("--lens", cls=SettingOption, metavar="LABEL|FILE", help="Another lens sheet than the format's.")
@click.option("--orientation", type=click.Choice(ORIENTATIONS), show_default="as the format is", help="Wide or high.")
@click.option(
    "--mount",
    type=click.Choice(["lanyard", "clip", "stand", "holder", "none"]),
    show_default="none where holders of that size are sold, else lanyard",
    help="What holds the badges; with none, holders are bought.",
)
@click.option(
    "--made",
    type=click.Choice(["printed", "acrylic"]),
    default="printed",
    show_default=True,
    help="Whether mounts are 3D-printed or cut from acrylic.",
)
@click.option(
    "--spare",
    "spare_percent",
    type=FiniteRange(0, 100),
    default=5.0,
    show_default=True,
    metavar="PERCENT",
    help="So much more of everything that is bought.",
)
@click.option(
    "--sheet-size",
    "sheet_text",
    show_default="210x297",
    metavar="WxH",
    help="Size of a lens sheet in mm: first across the lenses, then along them.",
)
@click.option(
    "--trim", "trim_mm", type=float, default=3.0, show_default=True, metavar="MM", help="Cut off at each edge."
)
@click.option(
    "--cut-width",
    "cut_mm",
    type=float,
    default=0.0,
    show_default=True,
    metavar="MM",
    help="What a cut takes away: 0 for a knife, some mm for a saw.",
)
@click.option(
    "--price",
    "price_texts",
    multiple=True,
    metavar="KEY=AMOUNT",
    help="Price of one unit of a line, such as lens-sheet=4.50; may be given several times.",
)
@click.option(
    "--out", "folder", type=FolderPath(), help="Folder for shopping list (PDF, CSV) and cutting plan (PDF, DXF)."
)
@overwrite_option
@json_option
@friendly
def materials_command(
    format_name: str | None,
    people: int | None,
    badge_file: Path | None,
    event: Path | None,
    lens: str | None,
    orientation: str | None,
    mount: str | None,
    made: str,
    spare_percent: float,
    sheet_text: str | None,
    trim_mm: float,
    cut_mm: float,
    price_texts: tuple[str, ...],
    folder: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """List what to buy for badges, how much of it, and how to cut the lens sheets.

    \b
    moireid materials --format a6 --people 40 --out shopping
    moireid materials --event conference --out shopping
    moireid materials                              the table of products

    The cutting plan has straight cuts from edge to edge, as a paper cutter makes them, and turns no piece: on a badge
    the lenses run as the plan shows. Ask the shop which way the lenses run on its sheets, and give the size so.

    Every product names the source of its figures, and what no source states: such a figure is to be asked for.
    Prices are yours to fill in, by --price or in the CSV file.
    """
    if badge_file is None and event is None and format_name is None:
        if people is not None or folder is not None or price_texts:
            raise SpecError("give --format, --badge or --event with it, so that it is known which badges are made")
        show_table(as_json)
        return
    from moireid.designer.request import parse_size_mm
    from moireid.fabrication.shopping.cutting import StockSheet
    from moireid.fabrication.shopping.needs import ShoppingWish
    from moireid.shopping import ASSUMED_MM, list_for

    if (
        sum(given is not None for given in (badge_file, event)) + (badge_file is not None and format_name is not None)
        > 1
    ):
        raise SpecError("give one of --format, --badge and --event (a list of people goes with --format)")
    prices = _prices(price_texts)
    across_mm, along_mm = ASSUMED_MM if sheet_text is None else parse_size_mm(sheet_text)
    sheet = StockSheet(across_mm, along_mm, trim_mm, cut_mm)
    order = _order(format_name, people, badge_file, event, lens, orientation)
    wish = ShoppingWish(order.people, sheet, spare_percent / 100, order.form, made, prices)
    found = list_for(order.badge, wish, mount or order.mount, assumed=sheet_text is None)
    files: dict[str, Path] = {}
    if folder is not None:
        from moireid.fabrication.shopping.written import write_shopping

        files = write_shopping(found, folder, overwrite=overwrite, kept=order.kept)
    if as_json:
        show_json(list_document(found, files))
        return
    for words in found.notes:
        say(f"note: {words}")
    show_list(found, files)


def _prices(texts: tuple[str, ...]) -> dict[str, float]:
    """Prices by key.  Raises: SpecError for what is no KEY=AMOUNT."""
    prices = {}
    for text in texts:
        key, equals, amount = text.partition("=")
        try:
            prices[key.strip()] = float(amount)
        except ValueError:
            equals = ""
        if not equals:
            raise SpecError(f"price {text[:60]!r} is not understood; give KEY=AMOUNT, such as lens-sheet=4.50")
    return prices


def _order(
    format_name: str | None,
    people: int | None,
    badge_file: Path | None,
    event: Path | None,
    lens: str | None,
    orientation: str | None,
) -> _Order:
    """Which badges are made, and how many.  Raises: SpecError for options that contradict each other."""
    from moireid.badge import load_badge
    from moireid.designer.formats import format_of
    from moireid.shopping import usual_badge

    if event is not None and people is not None:
        raise SpecError("--event says how many people come; leave --people out")
    of_file = badge_file is not None or (event is not None and event.is_dir())
    if of_file and (format_name or orientation):
        raise SpecError("the badges that are made already have their size; leave --format and --orientation out")
    if badge_file is not None:
        badge = load_badge(badge_file)
        return _Order(badge, format_of(badge.outline_mm), 1 if people is None else people, None, (badge_file,))
    if event is not None and event.is_dir():
        return _order_of_event(event)
    if format_name is None:
        raise SpecError("give --format with a list of people, so that the size of the badges is known")
    count = 1 if people is None else people
    kept: tuple[Path, ...] = ()
    if event is not None:
        from moireid.designer.people import read_people

        count, kept = len(read_people(event).people), (event,)
    return _Order(usual_badge(format_name, lens, orientation), format_name, count, None, kept)


def _order_of_event(folder: Path) -> _Order:
    """The badges in a folder of `print-your-badge --people`.  Raises: SpecError where it is none."""
    from moireid.badge import load_badge
    from moireid.designer.formats import format_of
    from moireid.designer.list_table import read_list
    from moireid.files import MOST_TABLE_BYTES, read_regular

    summary = folder / SUMMARY
    try:
        data = read_regular(summary, MOST_TABLE_BYTES)
    except OSError as error:
        raise SpecError(
            f"{folder} is no folder of an event, as its {SUMMARY} cannot be read ({error.strerror}); give the folder "
            "that print-your-badge --people made"
        ) from error
    rows = read_list(data, source=str(summary), needed="folder").rows
    if not rows:
        raise SpecError(f"{summary} lists no one; give the folder that print-your-badge --people made")
    first = folder / Path(rows[0][1].get("folder", "")).name / "badge.json"
    badge = load_badge(first)
    made = rows[0][1].get("mount", "none").partition(" or ")[0]
    return _Order(
        badge, format_of(badge.outline_mm), len(rows), "lanyard" if made == "acrylic" else made, (summary, first)
    )
