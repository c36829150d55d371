"""first-badge: lead a builder from an empty folder to a badge that is built and measured."""

from __future__ import annotations

import textwrap
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    INCONCLUSIVE,
    FiniteRange,
    FolderPath,
    echo,
    echo_lines,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    say,
    show_figures,
    show_json,
)
from moireid.cli.sealed_reader import sealed_reader, unsealed_option

if TYPE_CHECKING:
    from moireid.bringup.bring_up import Advance
    from moireid.bringup.build_folder import BuildFolder


@click.command("first-badge")
@click.argument("folder", type=FolderPath())
@click.option("--name", metavar="NAME", help="Who will wear it.  [default: First Badge]")
@click.option(
    "--lens", metavar="LABEL", help="What the sheet is sold as; see print-your-badge.  [default: 62lpi-27mil]"
)
@click.option("--printer", metavar="NAME", help="Keep the printer, once measured, for print-your-badge --printer NAME.")
@click.option("--printer-dpi", type=click.IntRange(72, 9600), metavar="DPI", help="[default: 1200]")
@click.option("--paper", type=click.Choice(["a4", "letter"]), help="[default: a4]")
@click.option(
    "--thickness",
    "thickness_mm",
    type=FiniteRange(0, 20),
    metavar="MM",
    help="Thickness of the sheet, measured with a calliper.",
)
@click.option(
    "--measured-scale",
    "measured_scale",
    metavar="X[,Y]",
    help="Measured over stated length of the pitch test's scale bars, such as 0.9973.",
)
@click.option(
    "--distance",
    "distance_m",
    type=FiniteRange(0, 100),
    metavar="M",
    help="Of the photo of the pitch test, in metres.",
)
@click.option("--focal-px", type=FiniteRange(0, 100_000), metavar="PX", help="Focal length of that photo, if known.")
@unsealed_option
@overwrite_option
@json_option
@friendly
def first_badge_command(
    folder: Path,
    unsealed: bool,
    overwrite: bool,
    as_json: bool,
    **wished: Any,
) -> None:
    """Build a first badge, step by step, in FOLDER.

    Call it again and again: each time it looks at what is in the folder, does what can be done, and says what you do
    next. A phone, a laser printer and a lens sheet are enough.

    \b
    1. It writes pitch-test.pdf; print it and put the sheet on it.
    2. Photograph it: sheet-photo.jpg.
    3. It prints the badge for your sheet and printer: badge/badge.pdf.
    4. Build it, and film it twice: badge-film-1.mp4, badge-film-2.mp4.

    Every figure has its error bar, and what to do about it; sheet.json and printer.json are profiles for the other
    commands (--lens, --printer). It exits with 3 where a photo or film could not be used. What you
    give is kept for the next calls; a --thickness, --measured-scale, --distance or --focal-px of 0 is forgotten.
    """
    from moireid.bringup.bring_up import advance
    from moireid.bringup.build_folder import open_folder

    readers = partial(sealed_reader, unsealed=unsealed)
    made = advance(open_folder(folder, _read(wished)), watch=progress_bar, readers=readers)
    _show(made, as_json=as_json)
    _keep_printer(made.folder, overwrite=overwrite)
    if made.refused is not None:
        raise click.exceptions.Exit(INCONCLUSIVE)


def _keep_printer(folder: BuildFolder, *, overwrite: bool) -> None:
    """Keep the printer under its name, once it is measured.  Raises: SpecError where another one is kept so."""
    from moireid.bringup.chart_steps import PRINTER
    from moireid.profiles import keep_printer, load_printer_profile, printer_file

    name = folder.wish.printer
    if name is None or not folder.at(PRINTER).exists():
        return
    printer, path = load_printer_profile(folder.at(PRINTER)), printer_file(name)
    if path.exists() and load_printer_profile(path).found == printer.found:
        return
    kept = keep_printer(printer, name, overwrite=overwrite)
    say(f"note: print-your-badge --printer {kept.words}")


def _read(wished: dict[str, Any]) -> dict[str, Any]:
    """The wish, with its texts read.  Raises: SpecError for an impossible name or scale."""
    from moireid.designer.order import clean_name, parse_scale

    name, scale, lens = wished["name"], wished["measured_scale"], wished["lens"]
    # The next call may come from another folder.
    profile = lens is not None and lens.lower().endswith(".json")
    return wished | {
        "lens": str(Path(lens).absolute()) if profile else lens,
        "name": None if name is None else clean_name(name),
        "measured_scale": scale and (0 if scale == "0" else parse_scale(scale)),
    }


def _show(made: Advance, *, as_json: bool) -> None:
    """Print the figures and the next step."""
    figures = made.folder.figures()
    notes = [note for name in made.did for note in made.folder.readings[name].notes]
    if as_json:
        import msgspec

        step: dict[str, Any] | None = None
        if made.next_step is not None:
            step = {"name": made.next_step.name, "title": made.next_step.title}
        show_json(
            {
                "folder": str(made.folder.path),
                "did": list(made.did),
                "done": made.next_step is None,
                "next": step,
                "ask": made.ask,
                "refused": made.refused,
                "notes": notes,
                "figures": msgspec.to_builtins(figures),
            }
        )
        return
    for note in notes:
        say(f"note: {note}")
    show_figures(figures)
    if figures:
        echo("")
    if made.refused is not None:
        echo(f"Not usable: {made.refused}")
        echo()
    echo(f"Next: {made.next_step.title}" if made.next_step else "Done.")
    for number, sentence in enumerate(made.ask, 1):
        # A command is copied, so it is one line.
        wide = len(sentence) + 10 if sentence.startswith("moireid ") else 100
        # A path with a hyphen stays whole, too.
        whole = textwrap.TextWrapper(wide, f"  {number}. ", "     ", break_on_hyphens=False, break_long_words=False)
        echo_lines(whole.fill(sentence))
