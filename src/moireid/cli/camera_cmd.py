"""calibrate-camera: print a chart, film it, and get the camera's calibration for --camera."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import echo, friendly, json_option, overwrite_option, paper_option, progress_bar, show_json
from moireid.cli.sealed_reader import sealed_reader, unsealed_option
from moireid.errors import SpecError


@click.command("calibrate-camera")
@click.argument("film", required=False, type=click.Path(path_type=Path))
@click.option("--out", "out", type=click.Path(path_type=Path, dir_okay=False), help="The calibration, a .yaml file.")
@click.option(
    "--chart", type=click.Path(path_type=Path, dir_okay=False), help="Write the chart to print as this PDF, and exit."
)
@paper_option
@unsealed_option
@overwrite_option
@json_option
@friendly
def calibrate_camera_command(
    film: Path | None,
    out: Path | None,
    chart: Path | None,
    paper: str,
    unsealed: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Calibrate a camera by a film of a chart.

    \b
    1. moireid calibrate-camera --chart chart.pdf
       Print it and glue it to something flat.
    2. Film it for 20 seconds in the mode in which you film badges, from all
       sides and in every corner of the picture; hold still each time.
    3. moireid calibrate-camera FILM --out camera.yaml

    Then `moireid verify VIDEO --camera camera.yaml` need not estimate the camera from the badge, and its error bars
    are smaller, above all before wide lenses and in short films.
    """
    if chart is not None:
        from moireid.fabrication.page.camera_page import print_camera_chart

        if film is not None or out is not None:
            raise SpecError("--chart prints the chart alone; give FILM and --out once it was filmed")
        print_camera_chart(chart, paper, overwrite=overwrite)
        if as_json:
            show_json({"files": {"chart": str(chart)}})
        else:
            echo(f"{chart}: print it at true size, glue it to something flat, and film it from all sides")
        return
    if film is None or out is None:
        raise SpecError("give FILM and --out camera.yaml, or --chart chart.pdf for the chart to print")
    from moireid.calibration.camera_fit import write_camera
    from moireid.calibration.film_orders import CameraOrder, camera_read
    from moireid.files import planned

    planned([out], overwrite=overwrite, kept=[film])
    with sealed_reader([film], unsealed=unsealed) as reader, progress_bar("looking for the chart") as progress:
        found = camera_read(CameraOrder(film), reader, progress)
    write_camera(found, out)
    focal_px, (width, height) = float(found.matrix[0, 0]), found.size_px
    if as_json:
        show_json(
            {
                "files": {"camera": str(out)},
                "focal_px": focal_px,
                "focal_sd_px": found.focal_sd_px,
                "axis_px": found.matrix[:2, 2].tolist(),
                "distortion": found.distortion.tolist(),
                "error_px": found.error_px,
                "views": found.views,
                "cover": found.cover,
            }
        )
        return
    echo(f"{out}: focal length {focal_px:.1f} ± {found.focal_sd_px:.1f} px in pictures of {width} x {height} px")
    echo(
        f"corners fit within {found.error_px:.2f} px in {found.views} views over {100 * found.cover[0]:.0f} x "
        f"{100 * found.cover[1]:.0f} % of the picture"
    )
