"""simulate: a film of a badge, true or forged, with its ground truth."""

from __future__ import annotations

from dataclasses import asdict
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    FiniteRange,
    GroupedCommand,
    echo,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    show_json,
)
from moireid.simulate.flaw_table import BUILDS, flaw_lines

if TYPE_CHECKING:
    from moireid.simulate.filming import FilmReport


GROUPS = {
    "How it is filmed": "motion distance frames fps camera",
    "What is filmed": "build flaw scene light forge",
    "What becomes of the film": "effect recipe",
    "Error and run time": "backend error explain",
    "Output": "out seed overwrite json",
}


@click.command("simulate", cls=GroupedCommand, groups=GROUPS)
@click.argument("badge_json", type=click.Path(path_type=Path))
@click.option("--out", "video", required=True, type=click.Path(path_type=Path, dir_okay=False), help="The film, .mp4.")
@click.option(
    "--motion",
    default="handheld",
    metavar="NAME|CSV",
    help="How the camera moves: handheld, walk, linear, sway, static, roll, oblique, tumble, circle, board, both, "
    "alike, or a CSV file of poses.",
)
@click.option(
    "--distance",
    "distance_m",
    type=FiniteRange(0.1, 100),
    default=1.4,
    metavar="M",
    help="From camera to badge, in metres.",
)
@click.option(
    "--frames",
    type=click.IntRange(2, 1_000_000),
    default=300,
    metavar="NUMBER",
    help="How many frames.",
)
@click.option(
    "--fps",
    type=FiniteRange(1, 1000),
    default=60.0,
    metavar="NUMBER",
    help="Frames per second.",
)
@click.option(
    "--camera",
    default="phone",
    metavar="NAME",
    help="Kind of camera: phone, sharpened, webcam, wide, dim, bright, ideal.",
)
@click.option(
    "--build",
    default="typical",
    metavar="NAME[:SEED]",
    help=f"How the badge was built: {', '.join(BUILDS)}, with a seed of its own.",
)
@click.option(
    "--flaw",
    "flaws",
    multiple=True,
    metavar="NAME=VALUE",
    help="One quantity of the build; may be given several times; the names are listed above.",
)
@click.option(
    "--scene",
    metavar="NAME",
    help="Where the badge is, in colour: on a desk, worn in an office, at a lectern, in a call; printed as in "
    "preview.png next to badge.json. Default: before grey clouds. With --effect or --recipe the film is grey.",
)
@click.option(
    "--light",
    metavar="NAME",
    help="Light the badge, with glare on its lenses; default: the page shines evenly by itself.",
)
@click.option("--forge", metavar="KIND", help="Forge the film in one thing; the kinds are listed above.")
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="NAME[:STRENGTH]",
    help="What the world does to the film: light, ordinary (default) or strong; may be given several times.",
)
@click.option(
    "--recipe",
    metavar="NAME",
    help="What sending makes of the film: chat, call, meeting, low (quality), double (coded twice), vfr (frames lost).",
)
@click.option(
    "--backend",
    type=click.Choice(["analytic", "mitsuba"]),
    default="analytic",
    help="Renderer: analytic is fast; mitsuba is the reference, and takes a second for each frame.",
)
@click.option(
    "--error",
    "error_rad",
    type=FiniteRange(1e-6, 1),
    metavar="RAD",
    help="Largest error of the fringe phase; the fastest setting that keeps it is taken.",
)
@click.option("--explain", is_flag=True, help="Show run times, estimated errors, and what was left out.")
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    metavar="NUMBER",
    help="Seed of everything random.",
)
@overwrite_option
@json_option
@friendly
def simulate_command(
    badge_json: Path, video: Path, overwrite: bool, as_json: bool, explain: bool, **wished: Any
) -> None:
    """Simulate a film of a badge, real or forged.

    The true camera poses and fringe phases are written next to the film, as VIDEO.truth.csv.

    The badge is filmed as if built by hand: the sheet is a little shifted and rotated, and print and lens pitch differ
    a little from their nominal size. The seed decides how much. A badge keeps its flaws from film to film if --build
    is given the same seed.

    \b
    Kinds of --build:
    ideal    as designed
    typical  built by hand of good parts: only place, turn and scales are off
    usual    bled ink, 7 % out of focus, some air, uneven lenses, a third of
             haze, bent to 1.5 m, a lamp in its ribs, more light on one side
    poor     all of that and more, as badly as still occurs

    \b
    Names of --flaw, as NAME=VALUE; each overrides one quantity of the build:
    {flaws}

    \b
    Kinds of --forge, each wrong in one thing:
    frozen               the fringes stay still
    drift, randomwalk    they drift evenly, or wander, by themselves
    late, reversed       they follow a quarter of a second late, or backwards
    gain_low, gain_high  they move half as far, or nearly twice as far
    splice, wobble       they move as in another film, or tremble as well
    patchy, generative   they differ from place to place, or are made up
    photo, screen        the badge is a printed photo, or a film on a screen

    \b
    Kinds of --effect, each light, ordinary or strong:
    zoom, zoom-step            a digital zoom, slowly or at once
    autoframe, autoframe-zoom  a window that follows the badge, also zooming
    breathing                  refocusing changes the focal length
    crop, tile                 cut off on the right; a tile of a recorded call
    stretch, anamorphic        wider pixels, without and with a flag that says so
    eis, jello                 a stabiliser; rows that wobble
    shutter, shutter-up        rows read one by one, from the top or the bottom
    tnr, tnr-mc                mixed with the picture before; motion compensated
    blend, repeat              of fewer frames: mixed, or shown again
    mix                        the mean of some frames
    freeze, skip, jitter       standstill; frames lost; times that are off
    slow-motion                filmed faster than it is played
    clahe, tone-map, halos     contrast, brightness and edges by an editor
    exposure, glare            exposure that follows the fringes; a lamp
    backdrop                   a virtual background that nibbles at the badge
    hlg, pq                    10-bit high dynamic range
    call, crf                  a call of changing size; coded too small

    \b
    Kinds of --light; an even sky gives the other 20 to 40 % of the light:
    even      an overcast sky all round
    softbox   0.8 m across, 1.5 m away, 35 degrees to the left, 25 degrees up
    window    1 m2, 2.5 m away, 40 degrees to the right; the lenses mirror it
    lamp      0.25 m across, 2 m away, 45 degrees up
    sun       40 degrees up, 30 degrees to the left, in a clear sky
    """
    from moireid.badge import load_badge

    # A wrong badge is refused before the simulator is imported, which takes seconds.
    load_badge(badge_json)
    from moireid.simulate.film_badge import simulate

    # The options of the film have the names of its parameters.
    with progress_bar("filming") as progress:
        report = simulate(badge_json, video, overwrite=overwrite, progress=progress, **wished)
    if as_json:
        show_json(_document(report))
        return
    echo(f"{report.video}: {report.frames} frames, {report.label}; truth in {report.truth}")
    if explain:
        _explain(report)


simulate_command.help = cleandoc(simulate_command.help or "").format(flaws="\n".join(flaw_lines()))


def _document(report: FilmReport) -> dict[str, Any]:
    """What --json prints."""
    estimate = report.estimate
    return {
        "video": str(report.video),
        "truth": str(report.truth),
        "frames": report.frames,
        "label": report.label,
        "size": report.size,
        "camera": asdict(report.camera),
        "stages_s": {name: round(seconds, 3) for name, seconds in report.stages_s.items()},
        "left_out": [{"what": what} for what in report.left_out],
        "estimated_error_rad": estimate.phase_rad,
        "estimated_image_error": estimate.image,
        "rays": estimate.rays,
        "segments": estimate.segments,
    }


def _explain(report: FilmReport) -> None:
    """Show run times, estimated errors, and what the film leaves out."""
    estimate = report.estimate
    echo("time: " + ", ".join(f"{name} {seconds:.1f} s" for name, seconds in report.stages_s.items()))
    phase = "no fringes" if estimate.phase_rad is None else f"phase {estimate.phase_rad:.4f} rad"
    setting = f"{estimate.rays[0] * estimate.rays[1]} rays a pixel"
    setting += "" if estimate.segments is None else f" and {estimate.segments} segments a lens"
    echo(f"estimated error: {phase}, brightness {100 * estimate.image:.1f} %, with {setting}")
    echo("not in the film: " + "; ".join(report.left_out))
