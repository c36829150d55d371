"""render: a photograph of a badge as it is worn, path-traced in colour."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import FiniteRange, echo, friendly, json_option, overwrite_option, progress_bar, show_json

#: Height of the picture for its width.
TALL = 4 / 3


@click.command("render")
@click.argument("badge_json", type=click.Path(path_type=Path))
@click.option(
    "--out", "picture", required=True, type=click.Path(path_type=Path, dir_okay=False), help="The picture, .png."
)
@click.option(
    "--width", type=click.IntRange(60, 6000), default=600, show_default=True, metavar="PX", help="Width of the picture."
)
@click.option(
    "--distance",
    "distance_m",
    type=FiniteRange(0.2, 10),
    default=0.8,
    show_default=True,
    metavar="M",
    help="From camera to badge, in metres.",
)
@click.option(
    "--aside",
    "aside_deg",
    type=FiniteRange(-60, 60),
    default=14.0,
    show_default=True,
    metavar="DEG",
    help="How far the camera is to the right of the badge, in degrees; less than 0: to the left.",
)
@click.option(
    "--above",
    "above_deg",
    type=FiniteRange(-40, 40),
    default=6.0,
    show_default=True,
    metavar="DEG",
    help="How far the camera is above the badge, in degrees.",
)
@click.option(
    "--rays",
    type=click.IntRange(32, 65536),
    default=256,
    show_default=True,
    metavar="NUMBER",
    help="Rays of each pixel; time grows with them, noise falls with their square root.",
)
@click.option(
    "--error",
    type=FiniteRange(1e-5, 1),
    metavar="SHARE",
    help="Stop as soon as the noise is at most this share of white.",
)
@click.option(
    "--build",
    default="typical",
    show_default=True,
    metavar="NAME",
    help="How the badge was built, as in `moireid simulate`.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    show_default=True,
    metavar="NUMBER",
    help="Seed of everything random.",
)
@overwrite_option
@json_option
@friendly
def render_command(
    badge_json: Path,
    picture: Path,
    width: int,
    distance_m: float,
    aside_deg: float,
    above_deg: float,
    rays: int,
    error: float | None,
    build: str,
    seed: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Render a photograph of a badge as it is worn.

    The badge is in a holder, on a cord, before a knitted jumper. Light is followed through every lens of the sheet, so
    the fringes are where a camera at that place sees them. The print in colour is that of preview.png next to
    BADGE_JSON. Such a picture is made to be shown; it proves nothing.
    """
    from moireid.badge import load_badge
    from moireid.files import planned
    from moireid.simulate.build import build_named
    from moireid.simulate.photograph.photograph import View, photograph
    from moireid.simulate.scene import Scene
    from moireid.simulate.settings.wearing import load_print

    if picture.suffix.lower() != ".png":
        raise click.UsageError(f"{picture.name} is no .png file; give --out a name that ends in .png")
    scene = Scene(load_badge(badge_json), build_named(build, seed), print_picture=load_print(badge_json))
    planned([picture], overwrite=overwrite, kept=[badge_json])
    view = View(distance_m, aside_deg, above_deg)
    with progress_bar("rendering") as progress:
        made = photograph(
            scene, view, (width, round(TALL * width)), rays=rays, error=error, seed=seed, progress=progress
        )
    made.save(picture)
    rows, columns = made.picture.shape[:2]
    if as_json:
        size = {"width": columns, "height": rows}
        show_json(
            {"picture": str(picture), **size, "rays": made.rays, "error": made.error, "seconds": round(made.seconds, 3)}
        )
        return
    echo(
        f"{picture}: {columns} x {rows} px, {made.rays} rays a pixel in {made.seconds:.0f} s; "
        f"noise {100 * made.error:.1f} % of white"
    )
