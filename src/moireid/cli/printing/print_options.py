"""The options of `print-your-badge`, and the order that they are read into.

`gathered` collects the options of one subject into one argument of the command: about size and looks into a `Wear`,
about the design into a `Design`, about the mount into a `MountWish`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import FiniteRange, form_option, paper_option, printer_dpi_option
from moireid.cli.removed import RemainingChoice
from moireid.errors import SpecError
from moireid.issuing import IssueOrder, Wear

if TYPE_CHECKING:
    from moireid.designer import Request
    from moireid.fabrication.process_figures import MountFigures

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
class Design:
    """The options as they were given; None for an option that was not given."""

    code: str
    lens_thickness_mm: float | None
    front: str
    gap_mm: float | None
    printer_dpi: int
    ink_growth_um: float
    paper: str
    axes: str
    markers: str
    pattern: str | None
    form: str

    def request(self, name: str) -> Request:
        """The request for a person of that name.  Raises: SpecError for an invalid name, or options that contradict."""
        from moireid.designer import Request
        from moireid.designer.request import clean_name

        if self.lens_thickness_mm is not None and self.front == "mask":
            raise SpecError("--lens-thickness is of a lens sheet; a mask has a spacer, whose thickness is --gap")
        if self.gap_mm is not None and self.front != "mask":
            raise SpecError("--gap is the spacer of a mask; give --front mask with it, or leave it out")
        return Request(
            clean_name(name),
            printer_dpi=self.printer_dpi,
            ink_growth_um=self.ink_growth_um,
            paper=self.paper,
            family=self.code,
            axes=self.axes,
            markers=self.markers,
            pattern=self.pattern,
            form=self.form,
            front=self.front,
            gap_mm=Request.gap_mm if self.gap_mm is None else self.gap_mm,
            lens_thickness_mm=self.lens_thickness_mm,
        )


design_options = gathered(
    "design",
    Design,
    [
        click.option(
            "--code",
            type=click.Choice(["spacing", "pitch"]),
            default="spacing",
            show_default=True,
            help="How lines carry the identity: by their places, or by their pitch.",
        ),
        click.option(
            "--lens-thickness",
            "lens_thickness_mm",
            type=FiniteRange(0.05, 20),
            metavar="MM",
            help="Thickness of the sheet, measured with a calliper; default: the one on its label.",
        ),
        click.option(
            "--front",
            type=RemainingChoice(["lens", "mask"]),
            default="lens",
            show_default=True,
            help="What is on top: a lenticular sheet, or a line mask printed on clear film with an acrylic spacer.",
        ),
        click.option(
            "--gap",
            "gap_mm",
            type=FiniteRange(0, 100),
            show_default="1.5",
            metavar="MM",
            help="Thickness of a mask's spacer.",
        ),
        printer_dpi_option,
        click.option(
            "--ink-growth",
            "ink_growth_um",
            type=FiniteRange(0, 150),
            default=0.0,
            show_default=True,
            metavar="UM",
            help="By how many micrometres the printer widens a line, as the strip of moireid pitch-test shows it; "
            "lines are drawn narrower by that.",
        ),
        paper_option,
        click.option(
            "--axes",
            type=click.Choice(["x", "xy", "hex"]),
            default="x",
            show_default=True,
            help="Motion that the fringes show: sideways, also up and down, or by three fields at 0, 60 and 120 "
            "degrees.",
        ),
        click.option(
            "--markers",
            type=click.Choice(["squares", "frame"]),
            default="squares",
            show_default=True,
            help="What a film finds the badge by: squares in its corners, or a thin frame around the fringes.",
        ),
        click.option(
            "--pattern",
            type=click.Choice(["cells", "silk"]),
            show_default="silk; cells for --axes hex, --front mask, --code pitch",
            help="How lines pass from one cell of the code to the next: they end and begin anew, which looks like a "
            "chequered board, or they bend, which looks like watered silk.",
        ),
        form_option,
    ],
)


@dataclass(frozen=True)
class MountWish:
    """The options as they were given; None for an option that was not given."""

    mount: str | None
    mount_pairs: tuple[str, ...]

    def figures(self, *, for_many: bool) -> MountFigures:
        """The figures of printer and laser; for_many: whether there is no mount unless one was asked for.

        Raises: SpecError for figures without a mount, or of an unknown name.
        """
        from moireid.fabrication.process_figures import mount_figures

        without = self.mount == "none" or (self.mount is None and for_many)
        # Without a mount, an adhesive holds page and sheet together.
        if without and any(not pair.strip().startswith("adhesive_mm") for pair in self.mount_pairs):
            raise SpecError(
                "--mount-figure is a figure of a mount; give --mount lanyard, clip, stand or holder with it, or leave "
                "it out (adhesive_mm alone goes without a mount)"
            )
        return mount_figures(self.mount_pairs)


mount_options = gathered(
    "wish",
    MountWish,
    [
        click.option(
            "--mount",
            type=click.Choice(["lanyard", "clip", "stand", "holder", "none"]),
            show_default="lanyard; with --people none",
            help="What holds the badge; it comes as parts to 3D-print and as an acrylic stack to laser-cut. Into a "
            "holder a finished badge is pressed.",
        ),
        click.option(
            "--mount-figure",
            "mount_pairs",
            multiple=True,
            metavar="NAME=MM",
            help="A dimension of the mount or of the laser, such as card_mm=0.5, kerf_mm=0.15 (0 if the shop corrects "
            "for it) or base_mm=3 of the acrylic plate; may be given several times.",
        ),
    ],
)


#: Names of `designer.formats.FORMATS`, repeated here because importing that package would slow down `--help`.
FORMATS = ("cr80", "a7", "4x3in", "a6", "a5", "webcam", "board")
ORIENTATIONS = ("landscape", "portrait")
#: As `artwork.template.TEMPLATES`.
TEMPLATES = ("plain", "conference", "newsroom", "court", "webcam", "banner", "campus", "minimal", "stripes", "gala")
TYPEFACES = ("sans", "serif", "slab")
PICTURE = click.Path(path_type=Path, dir_okay=False)


wear_options = gathered(
    "wear",
    Wear,
    [
        click.option(
            "--format",
            "format_name",
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
            "--size", "size_text", show_default="146x160", metavar="WxH", help="Size in mm, if no format is given."
        ),
        click.option(
            "--lens",
            envvar="MOIREID_LENS",
            show_default="62lpi-27mil, or the format's",
            metavar="LABEL|FILE",
            help="The lenticular sheet: a label from the list above, or a lens profile (.json) of moireid calibrate.",
        ),
        click.option(
            "--range",
            "range_text",
            show_default="0.8-2.5, or the format's",
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
            "--typeface",
            type=click.Choice(TYPEFACES),
            show_default="the template's",
            help="Of name, lines and identity. All have Latin, Greek and Cyrillic; other scripts go with them.",
        ),
        click.option(
            "--line", "lines", multiple=True, metavar="TEXT", help="A line below the name; may be given several times."
        ),
        click.option("--logo", type=PICTURE, metavar="FILE", help="A logo: SVG, PNG or JPEG."),
        click.option("--portrait", type=PICTURE, metavar="FILE", help="A portrait: PNG or JPEG."),
        click.option(
            "--colour", "--color", "colour", metavar="COLOUR", help="The template's accent colour, as #134e8c or teal."
        ),
    ],
)


@dataclass(frozen=True)
class PrintOrder:
    """What the badge is to be, where its files go, and how to report it.

    wanted: without a person's name and identity where there are many; measured_scale: x and y; kept: files that were
    read, which nothing may replace; registry_url, actor, expires: of who enters the badge, None for no registry;
    skip_bad: leave out the rows of a list that cannot be printed.
    """

    wanted: IssueOrder
    measured_scale: tuple[float, float]
    folder: Path
    kept: tuple[Path, ...]
    registry_url: str | None
    actor: str | None
    expires: str | None
    overwrite: bool
    as_json: bool
    explain: bool
    skip_bad: bool = False
