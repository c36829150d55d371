"""What the renderers leave out: a frame rendered with each thing and without it, its seconds, and what changes.

Convention: one view of the prototype at 1 m; seconds are the median of repeated runs after one that compiles.  The
change is measured as in `simulate.analytic.accuracy`.  The bar is the difference of two pictures whose errors are both
as large as estimated, because Mitsuba has other rays in each picture.  Things that change more than the bar matter:
the shutter and the light.  They are left out only by a scene that does not ask for them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from moireid.simulate.analytic.accuracy import brightness, difference, estimate_error, strips_of
from moireid.simulate.analytic.analytic_renderer import RAYS, AnalyticRenderer, BoardRadiance
from moireid.simulate.light import light_named
from moireid.simulate.scene import Instant, Need, Scene
from moireid_lab.bench.bench_frame import Row
from moireid_lab.bench.simulate.scenes import eleven

Frame = Callable[[], BoardRadiance | None]
TANGENT, RUNS, MITSUBA_RUNS = 0.2, 9, 3
#: Few rays, so that a whole picture fits into memory at once.
FEW_SAMPLES = 4
FINE = (64, 4)


def rows(seed: int) -> list[Row]:
    """One row for each thing that is left out, of each renderer."""
    setting = eleven()[0]
    scene, instant = setting.scene, setting.seen_at(TANGENT)
    return analytic_rows(scene, instant) + _light_rows(scene, instant) + mitsuba_rows(scene, instant, seed)


def analytic_rows(scene: Scene, instant: Instant) -> list[dict[str, Any]]:
    """Pixels off the badge, page and markers, and detail between the rays."""
    bar = estimate_error(scene, [instant]).phase_rad
    usual, fine = AnalyticRenderer(scene), AnalyticRenderer(scene, rays=FINE)
    badge_alone = AnalyticRenderer(replace(scene, need=Need(page=False)))
    camera = scene.camera
    whole: Frame = lambda: usual.render(instant, crop=(0, 0, camera.width, camera.height))  # noqa: E731
    plain: Frame = lambda: usual.render(instant)  # noqa: E731
    between = f"detail between {math.prod(RAYS)} rays of a pixel (of {math.prod(FINE)})"
    return [
        _row("analytic", "pixels off the badge", whole, plain, scene, instant, bar),
        _row("analytic", "page and markers", plain, lambda: badge_alone.render(instant), scene, instant, bar),
        _row("analytic", between, lambda: fine.render(instant), plain, scene, instant, bar),
    ]


def _light_rows(scene: Scene, instant: Instant) -> list[dict[str, Any]]:
    """Glare of a soft box, and all that an even sky adds to a page that shines by itself."""
    box, even = (replace(scene, light=light_named(name)) for name in ("softbox", "even"))
    shown, matt = AnalyticRenderer(box), AnalyticRenderer(replace(box, need=Need(glare=False)))
    skies, plain = AnalyticRenderer(even), AnalyticRenderer(scene)
    rows = []
    for what, one, other, lit in (
        ("glare of a soft box", shown, matt, box),
        ("Fresnel losses, light through the lenses", skies, plain, even),
    ):
        bar = estimate_error(lit, [instant]).phase_rad
        rows.append(
            _row(
                "analytic",
                what,
                partial(one.render, instant),
                partial(other.render, instant),
                scene,
                instant,
                bar,
            )
        )
    return rows


def mitsuba_rows(scene: Scene, instant: Instant, seed: int) -> list[dict[str, Any]]:
    """The same of Mitsuba, and the sheet's hidden face and bounces; none where it is not installed."""
    try:
        import mitsuba  # noqa: F401
    except ImportError:
        return []
    from moireid.simulate.mitsuba.mitsuba_renderer import USUAL, MitsubaRenderer, estimate_mitsuba
    from moireid.simulate.mitsuba.variant import choose_variant

    (samples, segments), camera = USUAL, scene.camera
    name = f"mitsuba {choose_variant()}"
    plain, few, finer, page, bounces = (
        MitsubaRenderer(replace(scene, need=need), samples=rays, segments=parts, seed=seed + k)
        for k, (need, rays, parts) in enumerate(
            (
                (Need(), samples, segments),
                (Need(), FEW_SAMPLES, segments),
                (Need(), samples, 2 * segments),
                (Need(page=False), samples, segments),
                (Need(bounces=True), samples, segments),
            )
        )
    )
    frame: Frame = lambda: plain.render(instant)  # noqa: E731
    off: Frame = lambda: few.render(instant, crop=(0, 0, camera.width, camera.height))  # noqa: E731
    pairs: list[tuple[str, Frame, Frame, int]] = [
        (f"pixels off the badge ({FEW_SAMPLES} rays)", off, lambda: few.render(instant), FEW_SAMPLES),
        ("page and markers", frame, lambda: page.render(instant), samples),
        ("bounces, and the hidden face", lambda: bounces.render(instant), frame, samples),
        (f"lens detail below {segments} segments (of {2 * segments})", lambda: finer.render(instant), frame, samples),
    ]
    # A single estimate from few strips may be off by half; the mean over several seeds is not.
    errors = {
        rays: rms(
            [
                estimate_mitsuba(scene, instant, (rays, segments), seed=seed + 10 * k).phase_rad
                for k in range(MITSUBA_RUNS)
            ]
        )
        for rays in (FEW_SAMPLES, samples)
    }
    rows = []
    for what, with_it, without, rays in pairs:
        bar = errors[rays]
        rows.append(_row(name, what, with_it, without, scene, instant, bar, runs=MITSUBA_RUNS))
    return rows


def _row(
    renderer: str,
    what: str,
    with_it: Frame,
    without: Frame,
    scene: Scene,
    instant: Instant,
    error_rad: float | None,
    *,
    runs: int = RUNS,
) -> dict[str, Any]:
    """Seconds of both frames, and how far they are apart where both show the badge."""
    (one, seconds), (other, less) = (_timed(frame, runs) for frame in (with_it, without))
    apart, bar_rad = None, None if error_rad is None else math.sqrt(2) * error_rad
    if one is not None and other is not None:
        boxes = [(p.left, p.top, p.left + p.radiance.shape[1], p.top + p.radiance.shape[0]) for p in (one, other)]
        (a, b, c, d), (e, f, g, h) = boxes
        strips = strips_of(scene, instant, (max(a, e), max(b, f), min(c, g), min(d, h)))
        pairs = [(strip, brightness(one, strip), brightness(other, strip)) for strip in strips]
        apart = difference(pairs, scene.paper - scene.ink)
    changed = None if apart is None else apart.phase_rad
    return {
        "renderer": renderer,
        "what": what,
        "with_s": seconds,
        "without_s": less,
        "phase_rad": changed,
        "image": apart and apart.image,
        "bar_rad": bar_rad,
        "within": None if changed is None or bar_rad is None else changed <= bar_rad,
    }


def rms(figures: list[float | None]) -> float | None:
    """Root mean square of the known figures; None if there are none."""
    known = [figure for figure in figures if figure is not None]
    return math.sqrt(sum(figure * figure for figure in known) / len(known)) if known else None


def _timed(frame: Frame, runs: int) -> tuple[BoardRadiance | None, float]:
    """The first picture, and the median of the seconds of further ones."""
    first, took = frame(), []
    for _ in range(runs):
        clock = time.perf_counter()
        frame()
        took.append(time.perf_counter() - clock)
    return first, float(np.median(took))


COLUMNS = {"left out of a frame": "left_out <58", "with, ms": ">9.2f", "without": ">9.2f", "saved": ">9.2f"}
COLUMNS |= {"change": "off >9.4f", "bar": "bar_rad >9.4f", "within": "bar_kept >9"}


def table(rows: Sequence[Row]) -> Iterator[Row]:
    """The rows, in milliseconds and words."""
    for row in rows:
        one, other = 1e3 * row["with_s"], 1e3 * row["without_s"]
        kept = {True: "yes", False: "no", None: None}[row["within"]]
        name = {"left_out": f"{row['renderer']}: {row['what']}", "bar_kept": kept, "off": row["phase_rad"]}
        yield name | {"with, ms": one, "without": other, "saved": one - other, "bar_rad": row["bar_rad"]}
