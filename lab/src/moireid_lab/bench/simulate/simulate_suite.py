"""The simulate suite, with its table.

Error against run time of the renderers, and both compared with an independent tracer (`reference`).

against: on the eleven scenes, the analytic renderer's fringe phase and brightness at a fine setting, over view tangents
    up to 0.4 and at 60 degrees; and its own estimate of the error, compared with the true error at the usual setting.
work: seconds a frame of the badge's region against RMS phase error, for each renderer, setting and resolution; medians
    and spreads of repeated runs, compile time and scene set-up apart.

Phase is measured as in `simulate.analytic.accuracy`; the truth is the independent tracer's at the same pixels.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.accuracy import Difference, PixelStrip, brightness, difference, estimate_error, strips_of
from moireid.simulate.analytic.analytic_renderer import RAYS, AnalyticRenderer, BoardRadiance
from moireid.simulate.scene import Camera, Instant, Scene
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.simulate.reference import Setup, trace_pixels
from moireid_lab.bench.simulate.scenes import STEEP_TANGENT, TANGENTS, SceneSetting, eleven

Array = NDArray[np.float64]
FINE = (64, 4)
#: Rays of the independent tracer for one view of one scene; near views have many pixels, so each needs fewer rays.
BUDGET, LEAST_SAMPLES, MOST_SAMPLES = 600_000, 89, 610
SETTINGS = ((2, 1), (4, 1), (8, 1), (16, 1), (32, 1), (32, 2), (64, 4))
MITSUBA_SETTINGS = ((16, 4), (16, 16), (64, 16), (256, 16), (64, 4), (64, 32))
CAMERAS = {"1080p": Camera(), "720p": Camera(1280, 720, 966.7), "2160p": Camera(3840, 2160, 2900.0)}
RUNS, QUICK_RUNS = 15, 5
#: Keys of a frame's times: median, least and spread.
SECONDS = ("seconds", "seconds_least", "seconds_spread")
WORK_TANGENTS = (-0.3, 0.05, 0.35)


@dataclass(frozen=True)
class SceneTruth:
    """One view of one scene: the frame, some strips, and their brightness by the outside tracer."""

    instant: Instant
    strips: list[PixelStrip]
    radiance: list[Array]
    escaped: float


def rows(wish: Wish) -> Iterator[Row]:
    """Scenes against the outside tracer, and error against run time."""
    settings = eleven()
    for setting in settings:
        yield against_reference(setting, quick=wish.quick)
    for name in CAMERAS if not wish.quick else ("1080p",):
        yield from work_precision(replace(settings[0], camera=CAMERAS[name]), name, quick=wish.quick, seed=wish.seed)


def truth_of(setting: SceneSetting, tangent: float, *, per_grating: int = 1, budget: int = BUDGET) -> SceneTruth | None:
    """The outside tracer's picture of strips from the middle of each grating; None where no strip is seen."""
    scene, instant = setting.scene, setting.seen_at(tangent)
    shape = AnalyticRenderer(scene, rays=(1, 1)).render(instant)
    if shape is None:
        return None
    height, width = shape.radiance.shape
    strips = strips_of(scene, instant, (shape.left, shape.top, shape.left + width, shape.top + height))
    some: list[PixelStrip] = []
    for grating in range(len(scene.badge.gratings)):
        own = [strip for strip in strips if strip.grating == grating]
        first = max(0, (len(own) - per_grating) // 2)
        some += own[first : first + per_grating]
    if not some:
        return None
    samples = int(np.clip(budget // sum(len(strip.rows) for strip in some), LEAST_SAMPLES, MOST_SAMPLES))
    build, pose = scene.build, instant.first
    setup = Setup(
        scene.badge, build.lens_offset_mm, build.twist_rad, build.print_scales, build.lens_scale, scene.ink, scene.paper
    )
    traced = [
        trace_pixels(
            setup, scene.camera.matrix, pose.camera_mm[0], pose.rotation[0], strip.columns, strip.rows, samples=samples
        )
        for strip in some
    ]
    return SceneTruth(instant, some, [one.radiance for one in traced], max(one.escaped for one in traced))


def rms(figures: list[float | None]) -> float | None:
    """Root mean square of the known figures; None if there are none."""
    known = [figure for figure in figures if figure is not None]
    return float(np.sqrt(np.mean(np.square(known)))) if known else None


def error_of(picture: BoardRadiance, truth: SceneTruth, contrast: float) -> Difference:
    """How far a rendered frame is from the truth, at the truth's strips."""
    pairs = [
        (strip, brightness(picture, strip), true) for strip, true in zip(truth.strips, truth.radiance, strict=True)
    ]
    return difference(pairs, contrast)


def against_reference(setting: SceneSetting, *, quick: bool) -> dict[str, Any]:
    """One scene's row: errors at the fine setting, and at the usual one the estimated and the true error."""
    scene = setting.scene
    tangents = [*(TANGENTS[::2] if quick else TANGENTS), STEEP_TANGENT]
    truths = [truth_of(setting, tangent, budget=BUDGET // 3 if quick else BUDGET) for tangent in tangents]
    contrast = scene.paper - scene.ink
    found: dict[str, Any] = {"name": setting.name}
    for label, rays in (("fine", FINE), ("usual", RAYS)):
        renderer = AnalyticRenderer(scene, rays=rays)
        errors = []
        for truth in truths:
            picture = renderer.render(truth.instant) if truth else None
            errors.append(error_of(picture, truth, contrast) if picture and truth else None)
        found[label] = {
            "phase_rad": rms([error.phase_rad for error in errors[:-1] if error]),
            "steep_phase_rad": errors[-1].phase_rad if errors[-1] else None,
            "image": max((error.image for error in errors[:-1] if error), default=None),
            "steep_image": errors[-1].image if errors[-1] else None,
        }
    estimate = estimate_error(scene, [truth.instant for truth in truths[:-1] if truth])
    found["estimate_rad"], found["estimate_image"] = estimate.phase_rad, estimate.image
    return found


def work_precision(setting: SceneSetting, camera_name: str, *, quick: bool, seed: int) -> list[dict[str, Any]]:
    """Seconds and errors of every renderer's settings at one resolution."""
    scene = setting.scene
    truths = [
        truth for tangent in WORK_TANGENTS if (truth := truth_of(setting, tangent, per_grating=3, budget=2 * BUDGET))
    ]
    runs = QUICK_RUNS if quick else RUNS
    rows = []
    kinds: list[tuple[str, tuple[int, int], Callable[[], Callable[[Instant], BoardRadiance | None]]]] = []
    for rays in SETTINGS:
        kinds.append(("analytic", rays, partial(_analytic, scene, rays)))
    kinds.append(("analytic float64", RAYS, lambda: AnalyticRenderer(scene, rays=RAYS, precision="float64").render))
    for samples, segments in mitsuba_settings(camera_name, quick=quick):
        kinds.append(("mitsuba", (samples, segments), partial(_mitsuba, scene, samples, segments, seed)))
    for name, figures, make in kinds:
        row = _timed(make, truths, 3 if name.startswith("mitsuba") else runs, scene.paper - scene.ink)
        rows.append({"renderer": name, "camera": camera_name, "setting": list(figures), **row})
    return rows


def _timed(
    make: Callable[[], Callable[[Instant], BoardRadiance | None]], truths: list[SceneTruth], runs: int, contrast: float
) -> dict[str, Any]:
    """Set-up apart: median and spread of the seconds of a frame, and its errors over all views."""
    clock = time.perf_counter()
    render = make()
    pictures = [render(truth.instant) for truth in truths]
    first = time.perf_counter() - clock
    seconds = []
    for _ in range(runs):
        for truth in truths:
            clock = time.perf_counter()
            render(truth.instant)
            seconds.append(time.perf_counter() - clock)
    errors = [error_of(picture, truth, contrast) for picture, truth in zip(pictures, truths, strict=True) if picture]
    low, middle, high = np.percentile(seconds, [25, 50, 75])
    return {
        "seconds": float(middle),
        "seconds_least": float(min(seconds)),
        "seconds_spread": float(high - low),
        "first_s": first,
        "runs": len(seconds),
        "phase_rad": rms([error.phase_rad for error in errors]),
        "image": rms([error.image for error in errors]),
    }


def mitsuba_settings(camera_name: str, *, quick: bool) -> tuple[tuple[int, int], ...]:
    """Settings of Mitsuba: few where they change no phase error, none where it is not installed."""
    if find_spec("mitsuba") is None:
        return ()
    return MITSUBA_SETTINGS[:3] if quick or camera_name != "1080p" else MITSUBA_SETTINGS


def _analytic(scene: Scene, rays: tuple[int, int]) -> Callable[[Instant], BoardRadiance | None]:
    return AnalyticRenderer(scene, rays=rays).render


def _mitsuba(scene: Scene, samples: int, segments: int, seed: int) -> Callable[[Instant], BoardRadiance | None]:
    from moireid.simulate.mitsuba.mitsuba_renderer import MitsubaRenderer

    return MitsubaRenderer(scene, samples=samples, segments=segments, seed=seed).render


COLUMNS = {"against the outside tracer": "name <36", "phase": "fine.phase_rad >8.4f"}
COLUMNS |= {
    "at 60": "fine.steep_phase_rad >8.4f",
    "image": "fine.image >7.2%",
    "image at 60": "fine.steep_image >11.2%",
}
COLUMNS |= {"usual": "usual.phase_rad >8.4f", "estimate": "estimate_rad >9.4f", "usual image": "usual.image >11.2%"}
COLUMNS |= {"renderer": "<24", "camera": ">8", "setting": "set >10", "ms": ">9.2f", "least": ">8.2f"}
COLUMNS |= {"spread": ">8.2f", "phase error": "phase_rad >11.4f", "image error": "image >11.2%"}


def table(rows: list[Row]) -> Iterator[Row]:
    """The rows of both parts."""
    yield from (row for row in rows if "fine" in row)
    for row in work_of(rows):
        ms = {name: 1e3 * row[key] for name, key in zip(("ms", "least", "spread"), SECONDS, strict=True)}
        yield row | ms | {"set": " x ".join(map(str, row["setting"]))}


def work_of(rows: list[Row]) -> list[Row]:
    """The rows of error against run time."""
    return [row for row in rows if "setting" in row]


PLOT = ("phase_rad", "seconds", "renderer", "camera")
BENCH = Bench(rows, COLUMNS, table=table, plot=PLOT)
