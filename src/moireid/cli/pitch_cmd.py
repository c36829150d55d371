"""pitch-test and calibrate: from a bought lens sheet to a lens profile for printing badges."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    FiniteRange,
    FolderPath,
    form_option,
    friendly,
    json_option,
    overwrite_option,
    paper_option,
    printer_dpi_option,
    say,
    scale_option,
    show_json,
)
from moireid.errors import MediaError, SpecError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from moireid.badge import Badge
    from moireid.calibration.chart_reading import ChartView
    from moireid.calibration.lens_fit import Calibration

#: Standard deviation of the camera's distance as a share, by where it comes from: a tape measure, a focal length that
#: was calibrated, one that the camera noted (rounded, and cropped by stabilisation), and that of a usual phone.
DISTANCE_SD = {"--distance": 0.03, "--focal-px": 0.02, "the camera's note": 0.06, "a usual phone": 0.35}


@click.command("pitch-test")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the files.")
@click.option(
    "--lens",
    default="50lpi",
    show_default=True,
    metavar="LABEL|FILE",
    help="What the sheet is sold as: a label of print-your-badge, or a lens profile (.json).",
)
@printer_dpi_option
@paper_option
@click.option(
    "--distance",
    type=FiniteRange(0.1, 100),
    default=1.0,
    metavar="M",
    show_default=True,
    help="Distance from which you will read it, in metres.",
)
@click.option(
    "--steps",
    type=int,
    default=10,
    metavar="NUMBER",
    show_default=True,
    help="Bands on each side of the middle, 0.1 lines per inch apart.",
)
@form_option
@scale_option
@overwrite_option
@json_option
@friendly
def pitch_test_command(
    folder: Path,
    lens: str,
    printer_dpi: int,
    paper: str,
    distance: float,
    steps: int,
    form: str,
    scale_text: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make a chart that measures a lens sheet's true pitch.

    It writes pitch-test.pdf and pitch-test.json. Print the PDF and put the sheet on it. The band that is all light or
    all dark from edge to edge is the one that matches. Then run `moireid calibrate` with the number of that band, or
    with a photo.
    """
    from moireid.designer.chart import ChartRequest, design_chart
    from moireid.designer.request import parse_scale
    from moireid.fabrication.page.chart_page import print_chart
    from moireid.sheets import MM_PER_INCH

    measured_scale = parse_scale(scale_text) if scale_text else (1.0, 1.0)
    chart = design_chart(ChartRequest(lens, printer_dpi, paper, distance, steps, form))
    files = print_chart(chart, folder, measured_scale=measured_scale, overwrite=overwrite)
    cells = chart.gratings[0].cells
    if as_json:
        show_json(
            {
                "name": chart.name,
                "files": {name: str(path) for name, path in files.items()},
                "bands": len(cells),
                "lines_per_inch": [round(MM_PER_INCH / cell.pitch_mm, 4) for cell in cells],
                "distance_m": distance,
                "measured_scale": measured_scale,
            }
        )
        return
    click.echo(
        f"Chart of {len(cells)} bands, {MM_PER_INCH / cells[0].pitch_mm:.4g} to "
        f"{MM_PER_INCH / cells[-1].pitch_mm:.4g} lines per inch:"
    )
    for path in files.values():
        click.echo(f"  {path}")
    click.echo(f"Print it at 100 %, put the sheet on it, and read it from {distance:g} m; then run moireid calibrate.")


@click.command("calibrate")
@click.argument("photo", required=False, type=click.Path(path_type=Path))
@click.option(
    "--chart", "chart_json", required=True, type=click.Path(path_type=Path), help="The pitch-test.json of the chart."
)
@click.option(
    "--band",
    type=FiniteRange(0, 1000),
    metavar="NUMBER",
    help="Number of the band that matches; 10.5 is between 10 and 11.",
)
@click.option(
    "--out",
    "out",
    required=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="The lens profile to write, .json.",
)
@click.option(
    "--distance",
    type=FiniteRange(0.1, 100),
    metavar="M",
    help="Distance from eye or camera to the sheet, in metres; by eye, the default is the one that the chart is for.",
)
@click.option(
    "--focal-px", type=FiniteRange(50, 100_000), metavar="PX", help="The camera's focal length in pixels, if known."
)
@click.option(
    "--measured-scale",
    "scale_text",
    metavar="X[,Y]",
    help="Measured over stated length of this chart's scale bars; needed for the pitch in true millimetres.",
)
@overwrite_option
@json_option
@friendly
def calibrate_command(
    photo: Path | None,
    chart_json: Path,
    band: float | None,
    out: Path,
    distance: float | None,
    focal_px: float | None,
    scale_text: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make a lens profile from a chart of `moireid pitch-test`.

    Give a PHOTO or a film of the chart with the sheet on it, or the number of the matching band as --band. A film that
    is moved sideways also measures the sheet's thickness. Then print badges for that sheet: print-your-badge NAME
    --lens my-lens.json.
    """
    from moireid.badge import load_badge
    from moireid.calibration.lens_fit import lens_from_band
    from moireid.designer.request import parse_scale
    from moireid.files import planned
    from moireid.profiles import save_lens_profile

    if (photo is None) == (band is None):
        raise SpecError("give either a photo of the chart or --band with the matching band's number")
    if band is not None and focal_px is not None:
        raise SpecError("--focal-px belongs to a photo; give it with one, or leave it out")
    if not out.name.lower().endswith(".json"):
        raise SpecError(f"--out {out} must end in .json, by which --lens knows a lens profile")
    planned([out], overwrite=overwrite, make_folders=False, kept=[chart_json, photo])
    scale = parse_scale(scale_text)[0] if scale_text else None
    chart = load_badge(chart_json)
    if band is not None:
        intended_m = chart.range_m[0] if chart.range_m else 1.0
        made = lens_from_band(chart, band, distance_mm=1000 * (distance or intended_m), measured_scale=scale)
    else:
        assert photo is not None
        made = _from_photo(photo, chart, distance, focal_px, scale)
    planned([out], overwrite=overwrite, kept=[chart_json, photo])
    save_lens_profile(made.profile, out)
    _show(made, out, as_json=as_json)


def _from_photo(
    photo: Path, chart: Badge, distance_m: float | None, focal_px: float | None, scale: float | None
) -> Calibration:
    """Read the photo, with the best known distance of the camera."""
    from moireid.calibration.chart_reading import check_chart
    from moireid.calibration.lens_fit import lens_from_views
    from moireid.calibration.still import is_film, load_pictures
    from moireid.verifier.measuring import FOCAL_PRIOR_RATIO

    check_chart(chart)
    pictures, noted_px = load_pictures(photo)
    focal = focal_px or noted_px or FOCAL_PRIOR_RATIO * max(pictures[0].shape)
    known = {"--distance": distance_m, "--focal-px": focal_px, "the camera's note": noted_px}
    source = next((name for name, value in known.items() if value), "a usual phone")
    distance_mm = 1000 * distance_m if distance_m else None
    views = _views(pictures, chart, focal, distance_mm)
    made = lens_from_views(
        views, chart, distance_sd_share=DISTANCE_SD[source], distance_from=source, measured_scale=scale
    )
    if is_film(photo):
        made = _with_thickness(made, photo, chart, focal_px)
    if source == "a usual phone":
        say(
            f"note: the focal length is not known, so the camera's distance is guessed to be "
            f"{made.profile.found['distance_mm'] / 1000:.2f} m; give --distance or --focal-px for a smaller error"
        )
    return made


def _views(
    pictures: list[NDArray[np.uint8]], chart: Badge, focal_px: float, distance_mm: float | None
) -> list[ChartView]:
    """The chart in those pictures that show it; if none does, raises the error of the first."""
    from moireid.calibration.chart_reading import view_chart

    views: list[ChartView] = []
    first: MediaError | None = None
    for picture in pictures:
        try:
            views.append(view_chart(picture, chart, focal_px=focal_px, distance_mm=distance_mm))
        except MediaError as wrong:
            first = first or wrong
    if not views and first is not None:
        raise first
    return views


def _with_thickness(made: Calibration, film: Path, chart: Badge, focal_px: float | None) -> Calibration:
    """The result with the thickness measured from the film, or a note that it could not be measured."""
    from moireid.calibration.thickness import thickness_from_film, with_thickness

    found = thickness_from_film(film, chart, focal_px=focal_px)
    if found.mm is None:
        say(f"note: the film does not show how thick the sheet is, so the thickness on its label is used: {found.why}")
    return replace(made, profile=with_thickness(made.profile, found))


def _show(made: Calibration, out: Path, *, as_json: bool) -> None:
    """Print the result."""
    from moireid.sheets import MM_PER_INCH

    profile = made.profile
    pitch_mm, sd_mm = profile.lens.pitch_mm, profile.pitch_sd_mm
    if as_json:
        show_json(
            {
                "file": str(out),
                "name": profile.name,
                "pitch_mm": pitch_mm,
                "pitch_sd_mm": sd_mm,
                "lines_per_inch": MM_PER_INCH / pitch_mm,
                "thickness_mm": profile.lens.thickness_mm,
                "thickness_sd_mm": profile.found.get("thickness_sd_mm"),
                "matching_band": made.matching_band,
                "bands": made.bands,
                "bands_used": made.used,
                "twist_deg": made.twist_deg,
                "scatter_fringes": made.scatter_fringes,
                "unit": profile.found["unit"],
                "from": profile.found,
            }
        )
        return
    click.echo(f"{out}: pitch {pitch_mm:.5f} mm, sd {sd_mm:.5f} mm; {profile.name}")
    if "thickness_sd_mm" in profile.found:
        thick_mm, thick_sd_mm = profile.lens.thickness_mm, profile.found["thickness_sd_mm"]
        click.echo(f"  {thick_mm:.3f} mm thick, sd {thick_sd_mm:.3f} mm, from the fringes' motion")
    if made.used:
        click.echo(f"  {made.used} of {made.bands} bands read; the match is at band {made.matching_band:.2f}")
        if made.twist_deg is not None:
            click.echo(f"  the sheet was rotated by {abs(made.twist_deg):.2f} degrees, which is corrected")
    if profile.found["unit"] == "printed page":
        click.echo(
            "  this is in mm of the printed page: right for badges from the same printer at the same scale; for "
            "true mm, measure the scale bars and give --measured-scale"
        )
