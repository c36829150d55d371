"""simulate: a film of a badge, true or forged, with its ground truth."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import FiniteRange, friendly, json_option, overwrite_option, progress_bar, show_json

if TYPE_CHECKING:
    from moireid.simulate.wish import Wish

#: The names of `moireid.simulate`, written again because importing that room costs a second; a test compares.
FORGERIES = (
    "frozen",
    "drift",
    "randomwalk",
    "late",
    "gain_low",
    "gain_high",
    "reversed",
    "splice",
    "wobble",
    "patchy",
    "generative",
    "photo",
    "screen",
)
CAMERAS = ("phone", "sharpened", "webcam", "wide", "dim", "bright")
CODECS = ("h264", "h265", "av1")
RECIPES = ("chat", "call", "low", "double", "vfr")
MOTIONS = ("handheld", "linear", "sway", "static", "roll", "oblique", "tumble", "circle")
LIGHT_NAMES = ("even", "softbox", "window", "lamp")
PARTS = ("background", "page", "shutter", "glare")


@click.command("simulate")
@click.argument("badge_json", type=click.Path(path_type=Path))
@click.option("--out", "video", required=True, type=click.Path(path_type=Path, dir_okay=False), help="The film, .mp4.")
@click.option(
    "--motion", default="handheld", show_default=True, metavar="NAME|CSV", help=f"{', '.join(MOTIONS)}, or a file."
)
@click.option("--distance", type=FiniteRange(0.1, 100), default=1.4, show_default=True, help="Camera to badge, metres.")
@click.option("--frames", type=click.IntRange(2, 1_000_000), default=300, show_default=True)
@click.option("--fps", type=FiniteRange(1, 1000), default=60.0, show_default=True, help="Frames a second.")
@click.option(
    "--backend",
    type=click.Choice(["analytic", "mitsuba"]),
    default="analytic",
    show_default=True,
    help="Renderer; mitsuba is the reference, and takes a second a frame.",
)
@click.option(
    "--error",
    "error_rad",
    type=FiniteRange(1e-6, 1),
    metavar="RAD",
    help="Phase error that the renderer must meet; the cheapest setting that does is taken.",
)
@click.option("--forge", type=click.Choice(FORGERIES), help="Forge the film in one thing.")
@click.option("--camera", type=click.Choice(CAMERAS), default="phone", show_default=True, help="What films.")
@click.option("--mirror", is_flag=True, help="Turn the picture left to right, as a self-view is.")
@click.option("--blur", type=FiniteRange(0, 50), metavar="PX", help="Out of focus by so many pixels (one sigma).")
@click.option("--codec", type=click.Choice(CODECS), default="h264", show_default=True, help="Of the video file.")
@click.option("--crf", type=click.IntRange(0, 63), help="Quality on the codec's own scale; small is good.")
@click.option("--recipe", type=click.Choice(RECIPES), help="Worsen the film as sending it by a chat program does.")
@click.option(
    "--light",
    type=click.Choice(LIGHT_NAMES),
    help="Light the badge from one side, with glare on its lenses; without it the page shines evenly by itself.",
)
@click.option(
    "--leave-out",
    "unneeded",
    type=click.Choice(PARTS),
    multiple=True,
    help="What the film need not show; without the page it has no markers. Can be given again.",
)
@click.option("--seed", type=click.IntRange(0, 2**31 - 1), default=0, show_default=True, help="Of all that is random.")
@overwrite_option
@json_option
@friendly
def simulate_command(badge_json: Path, video: Path, overwrite: bool, as_json: bool, **wished: Any) -> None:
    """Film the badge in BADGE_JSON as a phone would; the truth lies beside the film as VIDEO.truth.csv.

    The badge is filmed as one that somebody built: the sheet a little off its place and turned, print and lens pitch a
    little off their size. The seed says how.

    Lights: even, an overcast sky all round; softbox, 0.8 m across, 1.5 m away, 35 degrees to the left and 25 up;
    window, a square metre, 2.5 m away, 40 degrees to the right, at the badge's height, which the lenses mirror; lamp,
    0.25 m across, 2 m away, 45 degrees up. Each gives 60 to 70 % of the light, an even sky the rest.
    """
    from moireid.badge import load_badge

    badge = load_badge(badge_json)
    from moireid.simulate.wish import filmed, scene_of

    wish = wish_of(**wished)
    scene = scene_of(badge, wish)
    with progress_bar("filming") as progress:
        report = filmed(scene, wish, video, overwrite=overwrite, progress=progress)
    stages = {name: round(seconds, 3) for name, seconds in report.stages_s.items()}
    estimate = report.estimate
    if as_json:
        show_json(
            {
                "video": str(report.video),
                "truth": str(report.truth),
                "frames": report.frames,
                "label": report.label,
                "size": report.size,
                "camera": asdict(scene.camera),
                "stages_s": stages,
                "left_out": [asdict(one) for one in report.left_out],
                "estimated_error_rad": estimate.phase_rad,
                "estimated_image_error": estimate.image,
                "rays": estimate.rays,
                "segments": estimate.segments,
            }
        )
    else:
        click.echo(f"{report.video}: {report.frames} frames, {report.label}; truth in {report.truth}")
        click.echo(", ".join(f"{name} {seconds:.1f} s" for name, seconds in stages.items()))
        phase = "no fringe to err in" if estimate.phase_rad is None else f"phase {estimate.phase_rad:.4f} rad"
        setting = f"{estimate.rays[0] * estimate.rays[1]} rays a pixel"
        setting += "" if estimate.segments is None else f" and {estimate.segments} segments a lens"
        click.echo(f"estimated error: {phase}, brightness {100 * estimate.image:.1f} %, with {setting}")
        saved = (f"{one.what} ({_saved(one.saved_s)})" for one in report.left_out)
        click.echo(f"left out, and the time it saved a frame: {', '.join(saved)}")


def wish_of(
    *,
    motion: str,
    distance: float,
    frames: int,
    fps: float,
    backend: str,
    error_rad: float | None,
    forge: str | None,
    camera: str,
    mirror: bool,
    blur: float | None,
    light: str | None,
    codec: str,
    crf: int | None,
    recipe: str | None,
    unneeded: tuple[str, ...],
    seed: int,
) -> Wish:
    """The film that the options ask for."""
    from moireid.simulate.wish import Wish

    return Wish(
        motion=motion,
        distance_m=distance,
        frames=frames,
        fps=fps,
        backend=backend,
        error_rad=error_rad,
        forge=forge,
        camera=camera,
        mirror=mirror,
        blur_px=blur,
        light=light,
        codec=codec,
        crf=crf,
        recipe=recipe,
        leave_out=unneeded,
        seed=seed,
    )


def _saved(seconds: float | None) -> str:
    return "not known" if seconds is None else f"{1000 * seconds:.1f} ms"
