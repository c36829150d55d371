"""The options of `print-your-badge` about size and looks, gathered into one `Wear`."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.printing.one_badge import gathered
from moireid.issuing.wear import Wear

#: Names of `designer.formats.FORMATS`, repeated here because importing that package would slow down `--help`.
FORMATS = ("cr80", "a7", "4x3in", "a6", "a5", "webcam", "board")
ORIENTATIONS = ("landscape", "portrait")
#: As `looks.template.TEMPLATES`.
TEMPLATES = ("plain", "conference", "newsroom", "court", "webcam")
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
            show_default="50lpi, or the format's",
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
            "--line", "lines", multiple=True, metavar="TEXT", help="A line below the name; may be given several times."
        ),
        click.option("--logo", type=PICTURE, metavar="FILE", help="A logo: SVG, PNG or JPEG."),
        click.option("--portrait", type=PICTURE, metavar="FILE", help="A portrait: PNG or JPEG."),
        click.option(
            "--colour", "--color", "colour", metavar="COLOUR", help="The template's accent colour, as #134e8c or teal."
        ),
    ],
)
