"""The options of `print-your-badge`: those of the badge have the names of `Order`'s fields."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click

from moireid.cli.common import FiniteRange, Parsed, form_option, paper_option, printer_dpi_option, say
from moireid.errors import SpecError

#: Names of `designer.formats.FORMATS`, repeated here because importing that package would slow down `--help`.
FORMATS = ("cr80", "a7", "4x3in", "a6", "a5", "webcam", "board")
ORIENTATIONS = ("landscape", "portrait")
#: As `artwork.template.TEMPLATES`.
TEMPLATES = ("plain", "conference", "newsroom", "court", "webcam", "banner", "campus", "minimal")
PICTURE = click.Path(path_type=Path, dir_okay=False)
#: The headings of the help, and the options below each.
GROUPS = {
    "What is made": "out people again payload registry overwrite explain json help",
    "Size and distance": "format orientation size range",
    "Looks": "template line logo portrait color",
    "Sheet and fringes": "lens lens-thickness front axes markers",
    "Printer": "printer printer-dpi measured-scale paper form",
    "Mount": "mount mount-figure",
}


def _pair(text: str, what: str) -> tuple[float, float]:
    from moireid.designer.order import parse_pair

    return parse_pair(text, what)


#: Width and height in mm, such as 146x160; and metres, such as 0.8-2.5.
SIZE, RANGE = Parsed(partial(_pair, what="size_mm")), Parsed(partial(_pair, what="range_m"))


def mount_figure(text: str) -> tuple[str, float | tuple[float, ...]]:
    """A figure's name and its mm, or width and height: "kerf_mm=0.2", "slot_mm=20x5".  Raises: SpecError."""
    name, _, mm = (part.strip() for part in text.partition("="))
    try:
        numbers = tuple(float(part) for part in mm.lower().split("x"))
    except ValueError as error:
        raise SpecError(
            f"mount figure {text[:60]!r} is not understood; give NAME=MM, such as card_mm=0.5, or slot_mm=16x4"
        ) from error
    return name, numbers if len(numbers) > 1 else numbers[0]


def _use_printer(context: click.Context, _: click.Parameter, name: str | None) -> float:
    """The printer's ink growth; its dots and scale too, where they are not given."""
    if name is None or context.resilient_parsing:
        return 0.0
    from moireid.profiles import load_printer_profile

    try:
        printer = load_printer_profile(name)
    except SpecError as error:
        raise click.UsageError(f"{error}.") from error
    found: dict[str, Any] = {"printer_dpi": printer.dpi}
    if printer.measured_scale is not None:
        found["measured_scale"] = printer.measured_scale
    context.default_map = {**(context.default_map or {}), **found}
    say(f"note: drawn for {printer.words}, where no option says otherwise")
    return printer.drawn_growth_um


OPTIONS = [
    click.option(
        "--format",
        type=click.Choice(FORMATS),
        show_default="board",
        help="Size for which holders are sold, with a sheet and a range that suit it; webcam is for calls.",
    ),
    click.option(
        "--orientation",
        type=click.Choice(ORIENTATIONS),
        show_default="landscape; the board's is portrait",
        help="Whether the badge is wide or high.",
    ),
    click.option(
        "--size", "size_mm", type=SIZE, show_default="146x160", metavar="WxH", help="Size in mm, if no format is given."
    ),
    click.option(
        "--range",
        "range_m",
        type=RANGE,
        show_default="the format's",
        metavar="M-M",
        help="Nearest and farthest camera, in metres.",
    ),
    click.option(
        "--template",
        show_default="plain; with --format webcam: webcam",
        metavar="NAME|FILE",
        help=f"Where name, lines and pictures go: {', '.join(TEMPLATES)}; or a .toml or .json file of your own.",
    ),
    click.option(
        "--line", "lines", multiple=True, metavar="TEXT", help="A line below the name; may be given several times."
    ),
    click.option("--logo", type=PICTURE, metavar="FILE", help="A logo: SVG, PNG or JPEG."),
    click.option("--portrait", type=PICTURE, metavar="FILE", help="A portrait: PNG or JPEG."),
    click.option(
        "--colour", "--color", "colour", metavar="COLOUR", help="The template's accent colour, as #134e8c or teal."
    ),
    click.option(
        "--lens",
        envvar="MOIREID_LENS",
        show_default="62lpi-27mil, or the format's",
        metavar="LABEL|FILE",
        help="The lenticular sheet: a label from the list above, or a lens profile (.json) of moireid calibrate.",
    ),
    click.option(
        "--lens-thickness",
        "lens_thickness_mm",
        type=FiniteRange(0.05, 20),
        metavar="MM",
        show_default="the one on its label; of a mask's spacer 1.5",
        help="Thickness of the sheet, measured with a calliper, or of a mask's acrylic spacer.",
    ),
    click.option(
        "--front",
        type=click.Choice(["lens", "mask"]),
        default="lens",
        help="What is on top: a lenticular sheet, or a line mask printed on clear film with an acrylic spacer.",
    ),
    click.option(
        "--axes",
        type=click.Choice(["x", "xy", "hex"]),
        default="x",
        help="Motion that the fringes show: sideways, also up and down, or by three fields at 0, 60 and 120 degrees.",
    ),
    click.option(
        "--markers",
        type=click.Choice(["squares", "frame"]),
        default="squares",
        help="What a film finds the badge by: squares in its corners, or a thin frame around the fringes.",
    ),
    printer_dpi_option,
    click.option(
        "--printer",
        "ink_growth_um",
        metavar="NAME|FILE",
        is_eager=True,
        callback=_use_printer,
        help="A printer that moireid first-badge --printer or calibrate --printer-out measured and keeps by that name, "
        "or the file of its profile: its ink growth, and its dpi and scale, unless they are given.",
    ),
    paper_option,
    form_option,
    click.option(
        "--mount",
        type=click.Choice(["lanyard", "clip", "stand", "none"]),
        show_default="lanyard; with --people none",
        help="What holds the badge; it comes as parts to 3D-print and as an acrylic stack to laser-cut.",
    ),
    click.option(
        "--mount-figure",
        "mount_mm",
        type=Parsed(mount_figure),
        multiple=True,
        metavar="NAME=MM",
        help="A dimension of the mount or of the laser, such as card_mm=0.5, kerf_mm=0.15 (0 if the shop corrects "
        "for it) or base_mm=3 of the acrylic plate; may be given several times.",
    ),
    click.option("--payload", metavar="HEX", help="The identity: 16 or 32 hex digits; default: drawn at random."),
]


def order_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that an order is made of."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command
