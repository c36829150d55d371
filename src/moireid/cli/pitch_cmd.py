"""pitch-test and calibrate: from a bought lens sheet to a lens profile for printing badges; a camera by its chart."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    SCALE,
    FiniteRange,
    FolderPath,
    echo,
    focal_option,
    friendly,
    json_option,
    overwrite_option,
    paper_option,
    printer_dpi_option,
    progress_bar,
    show_figures,
    show_json,
)
from moireid.cli.sealed_reader import sealed_reader, unsealed_option
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.calibration.sheet_reading import SheetReading


@click.command("pitch-test")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the files.")
@click.option(
    "--lens",
    envvar="MOIREID_LENS",
    default="62lpi-27mil",
    metavar="LABEL|FILE",
    help="What the sheet is sold as: a label of print-your-badge, or a lens profile (.json).",
)
@printer_dpi_option
@paper_option
@click.option(
    "--steps",
    type=int,
    default=10,
    metavar="NUMBER",
    help="Bands on each side of the middle, 0.1 lines per inch apart.",
)
@overwrite_option
@json_option
@friendly
def pitch_test_command(
    folder: Path,
    lens: str,
    printer_dpi: int,
    paper: str,
    steps: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make a chart that measures a lens sheet's true pitch.

    It writes pitch-test.pdf and pitch-test.json. Print the PDF and put the sheet on it. The band that is all light or
    all dark from edge to edge is the one that matches. Then run `moireid calibrate` with a photo.
    """
    from moireid.designer.chart import design_chart
    from moireid.fabrication.page.chart_page import print_chart
    from moireid.sheets import MM_PER_INCH

    chart = design_chart(lens, printer_dpi=printer_dpi, paper=paper, steps=steps)
    files = print_chart(chart, folder, overwrite=overwrite)
    cells = chart.gratings[0].cells
    if as_json:
        show_json(
            {
                "name": chart.name,
                "files": {name: str(path) for name, path in files.items()},
                "bands": len(cells),
                "lines_per_inch": [round(MM_PER_INCH / cell.pitch_mm, 4) for cell in cells],
            }
        )
        return
    echo(
        f"Chart of {len(cells)} bands, {MM_PER_INCH / cells[0].pitch_mm:.4g} to "
        f"{MM_PER_INCH / cells[-1].pitch_mm:.4g} lines per inch:"
    )
    for path in files.values():
        echo(f"  {path}")
    echo("Print it at 100 %, put the sheet on it, and photograph it from about 1 m. Next:")
    chart_json = shlex.quote(str(files["pitch-test.json"]))
    echo(f"  moireid calibrate PHOTO --chart {chart_json} --out sheet.json --printer-out NAME")


@click.command("calibrate")
@click.argument("photo", metavar="[PHOTO|FILM]", required=False, type=click.Path(path_type=Path))
@click.option("--chart", "chart_json", type=click.Path(path_type=Path), help="The pitch-test.json of the chart.")
@click.option(
    "--camera",
    is_flag=True,
    help="Calibrate a camera: without FILM, --out chart.pdf is the chart to print; with it, --out camera.yaml.",
)
@paper_option
@click.option(
    "--out",
    "out",
    required=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="The lens profile to write, .json; with --camera chart or calibration.",
)
@click.option(
    "--printer-out",
    metavar="NAME|FILE",
    help="Also keep a printer profile under that name, or write it as that .json: ink growth from the photo, and the "
    "measured scale.",
)
@click.option(
    "--distance",
    "distance_m",
    type=FiniteRange(0.1, 100),
    metavar="M",
    help="Distance from camera to the sheet, in metres, if known.",
)
@focal_option
@click.option(
    "--measured-scale",
    type=SCALE,
    metavar="X[,Y]",
    help="Measured over stated length of this chart's scale bars; needed for the pitch in true millimetres.",
)
@unsealed_option
@overwrite_option
@json_option
@friendly
def calibrate_command(
    photo: Path | None,
    chart_json: Path | None,
    camera: bool,
    paper: str,
    out: Path,
    printer_out: str | None,
    distance_m: float | None,
    focal_px: float | None,
    measured_scale: tuple[float, float] | None,
    unsealed: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make a lens profile from a chart of `moireid pitch-test`, or calibrate a camera.

    Give a PHOTO or a film of the chart with the sheet on it. A film that is moved sideways also measures the sheet's
    thickness; a photo from about 1 m also measures by how much the printer widens lines. Then print badges for that
    sheet and printer: print-your-badge NAME --lens sheet.json --printer office-laser.

    \b
    A camera:
    1. moireid calibrate --camera --out chart.pdf
       Print it and glue it to something flat.
    2. Film it for 20 seconds in the mode in which you film badges, from all
       sides and in every corner of the picture; hold still each time.
    3. moireid calibrate FILM --camera --out camera.yaml

    Then `moireid verify VIDEO --camera camera.yaml` need not estimate the camera from the badge, and its error bars
    are smaller, above all before wide lenses and in short films.
    """
    if camera:
        given: dict[str, object] = {"--chart": chart_json, "--printer-out": printer_out, "--distance": distance_m}
        given |= {"--focal-px": focal_px, "--measured-scale": measured_scale}
        if wrong := [option for option, value in given.items() if value is not None]:
            raise SpecError(f"{wrong[0]} belongs to a lens sheet; leave it out with --camera")
        _camera(photo, out, paper, unsealed=unsealed, overwrite=overwrite, as_json=as_json)
        return
    if chart_json is None:
        raise SpecError("give the pitch-test.json of the chart as --chart, or --camera to calibrate a camera")
    from moireid.badge import load_badge
    from moireid.calibration.film_orders import film_read
    from moireid.calibration.sheet_reading import SheetReading, printer_profile, read_sheet
    from moireid.files import planned
    from moireid.profiles import keep_printer, printer_file, save_profile

    if photo is None:
        raise SpecError("give a photo or a film of the chart, with the sheet on it")
    if not out.name.lower().endswith(".json"):
        raise SpecError(f"--out {out} must end in .json, by which --lens knows a lens profile")
    outs = [out] if printer_out is None else [out, printer_file(printer_out)]
    planned(outs, overwrite=overwrite, make_folders=False, kept=[chart_json, photo])
    chart = load_badge(chart_json)
    along = measured_scale and measured_scale[0]
    read = partial(read_sheet, chart=chart, distance_m=distance_m, focal_px=focal_px, measured_scale=along)
    with sealed_reader([photo], unsealed=unsealed) as reader, progress_bar("reading the pitch test") as progress:
        found = film_read(photo, read, SheetReading, reader, progress)
    planned(outs, overwrite=overwrite, kept=[chart_json, photo])
    if printer_out is not None:
        keep_printer(printer_profile(chart, found.ink, measured_scale), printer_out, overwrite=overwrite)
    save_profile(found.profile, out)
    _show(found, out, measured_scale, as_json=as_json)
    if not as_json:
        printer = [] if printer_out is None else ["--printer", printer_out]
        echo(f"Next: {shlex.join(['print-your-badge', 'NAME', '--lens', str(out), *printer])}")


def _camera(film: Path | None, out: Path, paper: str, *, unsealed: bool, overwrite: bool, as_json: bool) -> None:
    """Write the chart of a camera, or the calibration by a film of it."""
    if (out.suffix.lower() == ".pdf") != (film is None):
        raise SpecError("give --camera with --out chart.pdf for the chart to print, or with FILM and --out camera.yaml")
    if film is None:
        from moireid.fabrication.page.camera_page import print_camera_chart

        print_camera_chart(out, paper, overwrite=overwrite)
        if as_json:
            show_json({"files": {"chart": str(out)}})
        else:
            echo(f"{out}: print it at true size, glue it to something flat, and film it from all sides")
        return
    from moireid.calibration.camera_fit import CameraFound, camera_from_film, write_camera
    from moireid.calibration.film_orders import film_read
    from moireid.files import planned

    planned([out], overwrite=overwrite, kept=[film])
    with sealed_reader([film], unsealed=unsealed) as reader, progress_bar("looking for the chart") as progress:
        found = film_read(film, camera_from_film, CameraFound, reader, progress)
    write_camera(found, out)
    if as_json:
        figures = asdict(found) | {"focal_px": found.focal_px}
        show_json({"files": {"camera": str(out)}} | figures)
        return
    width, height = found.size_px
    echo(f"{out}: focal length {found.focal_px:.1f} ± {found.focal_sd_px:.1f} px in pictures of {width} x {height} px")
    echo(
        f"corners fit within {found.error_px:.2f} px in {found.views} views over {100 * found.cover[0]:.0f} x "
        f"{100 * found.cover[1]:.0f} % of the picture"
    )


def _show(read: SheetReading, out: Path, scales: tuple[float, float] | None, *, as_json: bool) -> None:
    """Print the result, with the figures that first-badge shows of a sheet."""
    from moireid.bringup.chart_steps import sheet_figures
    from moireid.sheets import MM_PER_INCH

    profile, ink = read.profile, read.ink
    pitch_mm, sd_mm, found = profile.lens.pitch_mm, profile.pitch_sd_mm, profile.found
    if as_json:
        show_json(
            {
                "file": str(out),
                "name": profile.name,
                "pitch_mm": pitch_mm,
                "pitch_sd_mm": sd_mm,
                "lines_per_inch": MM_PER_INCH / pitch_mm,
                "thickness_mm": profile.lens.thickness_mm,
                "ink_growth_um": ink.um,
                "ink_growth_sd_um": ink.sd_um if ink.um is not None else None,
                "from": found,
            }
        )
        return
    echo(f"{out}: {profile.name}")
    show_figures(sheet_figures(read, scales))
