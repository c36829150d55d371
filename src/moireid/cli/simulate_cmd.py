"""simulate: a film of a badge, true or forged, with its ground truth."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import FiniteRange, friendly, json_option, overwrite_option, progress_bar, show_json

#: The kinds of `moireid.simulate.forge`, written again because importing that room costs a second; a test compares.
FORGERIES = ("frozen", "drift", "randomwalk", "late", "gain_low", "gain_high", "reversed")
#: The names of `moireid.simulate.light`, for the same reason.
LIGHT_NAMES = ("even", "softbox", "window", "lamp")


@click.command("simulate")
@click.argument("badge_json", type=click.Path(path_type=Path))
@click.option("--out", "video", required=True, type=click.Path(path_type=Path, dir_okay=False), help="The film, .mp4.")
@click.option(
    "--motion",
    default="handheld",
    show_default=True,
    metavar="NAME|CSV",
    help="linear, sway, handheld, static, or a file.",
)
@click.option("--distance", type=FiniteRange(0.1, 100), default=1.4, show_default=True, help="Camera to badge, metres.")
@click.option("--frames", type=click.IntRange(2, 1_000_000), default=300, show_default=True)
@click.option("--fps", type=FiniteRange(1, 1000), default=60.0, show_default=True, help="Frames a second.")
@click.option(
    "--backend", type=click.Choice(["analytic", "mitsuba"]), default="analytic", show_default=True,
    help="Renderer; mitsuba is the reference, and takes a second a frame.",
)  # fmt: skip
@click.option("--forge", type=click.Choice(FORGERIES), help="Make the fringes move by another law.")
@click.option(
    "--light", type=click.Choice(LIGHT_NAMES),
    help="Light the badge from one side, with glare on its lenses; without it the page shines evenly by itself.",
)  # fmt: skip
@click.option("--seed", type=click.IntRange(0, 2**31 - 1), default=0, show_default=True, help="Of all that is random.")
@overwrite_option
@json_option
@friendly
def simulate_command(
    badge_json: Path, video: Path, motion: str, distance: float, frames: int, fps: float, backend: str,
    forge: str | None, light: str | None, seed: int, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Film the badge in BADGE_JSON as a phone would; the truth lies beside the film as VIDEO.truth.csv.

    The badge is filmed as one that somebody built: the sheet a little off its place and turned, print and lens pitch a
    little off their size. The seed says how.

    Lights: even, an overcast sky all round; softbox, 0.8 m across, 1.5 m away, 35 degrees to the left and 25 up;
    window, a square metre, 2.5 m away, 40 degrees to the right, at the badge's height, which the lenses mirror; lamp,
    0.25 m across, 2 m away, 45 degrees up. Each gives 60 to 70 % of the light, an even sky the rest.
    """
    from moireid.badge import load_badge

    badge = load_badge(badge_json)
    from moireid.simulate.film import film
    from moireid.simulate.light import light_named
    from moireid.simulate.motion import motion_named
    from moireid.simulate.scene import Build, Scene

    course = motion_named(motion, distance_mm=1000.0 * distance, seed=seed)
    scene = Scene(badge, Build.typical(seed), light=light_named(light) if light else None)
    with progress_bar("filming") as progress:
        report = film(
            scene,
            course,
            video,
            frames=frames,
            fps=fps,
            forge=forge,
            seed=seed,
            backend=backend,
            overwrite=overwrite,
            progress=progress,
        )
    if as_json:
        stages = {name: round(seconds, 3) for name, seconds in report.stages_s.items()}
        files = {"video": str(report.video), "truth": str(report.truth)}
        show_json(
            {**files, "frames": report.frames, "label": report.label, "stages_s": stages, "left_out": report.left_out}
        )
    else:
        click.echo(f"{report.video}: {report.frames} frames, {report.label}; truth in {report.truth}")
