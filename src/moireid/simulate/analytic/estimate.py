"""The analytic renderer's own error, estimated before a film, and the cheapest setting that meets a wish.

Some frames are rendered twice: once with the film's rays, and once with four times as many.  Rays are spread so evenly
that four times as many have a third of the error or less.  So the difference is the error of the coarse picture to
within some tenths.  The estimate is its RMS over the frames' strips (`accuracy`).  `moireid bench simulate` compares it
with an independent tracer.  Not part of the estimate: how far the model is from a real sheet.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

from moireid.errors import SpecError
from moireid.simulate.analytic.accuracy import brightness, difference, strips_of
from moireid.simulate.analytic.renderer import RAYS, AnalyticRenderer
from moireid.simulate.scene import Instant, Scene

#: The finer picture has this many times the rays, across and down.
FINER = (2, 2)
#: Settings from cheap to dear; each takes about twice the time of the one before it.
LADDER = ((4, 1), (8, 1), RAYS, (32, 1), (32, 2), (64, 2), (64, 4), (128, 4))


@dataclass(frozen=True)
class Estimate:
    """Expected errors of a setting: phase, RMS over strips, None where no strip shows fringes; brightness, RMS as a
    share of the contrast; and the seconds that a frame takes, without compile time.

    rays: of a pixel, across and down; finer_s: seconds of a frame at the finer setting; pixels: of a frame;
    segments: of each lens, None where the lenses are true cylinders.
    """

    rays: tuple[int, int]
    phase_rad: float | None
    image: float
    frame_s: float
    finer_s: float = 0.0
    pixels: int = 0
    segments: int | None = None


def estimate_error(scene: Scene, instants: Sequence[Instant], rays: tuple[int, int] = RAYS) -> Estimate:
    """Estimate the error of a setting on some frames of a film.

    Convention: module docstring.  Source: the difference from four times the rays.
    Raises: SpecError as `AnalyticRenderer`.
    """
    coarse = AnalyticRenderer(scene, rays=rays)
    fine = AnalyticRenderer(scene, rays=(rays[0] * FINER[0], rays[1] * FINER[1]))
    phases, images, seconds, finer, pixels = [], [], [], [], 0
    for instant in instants:
        one = coarse.render(instant)
        clocks = [time.perf_counter()]
        other = fine.render(instant)
        clocks.append(time.perf_counter())
        if one is None or other is None:
            continue
        coarse.render(instant)
        seconds.append(time.perf_counter() - clocks[1])
        finer.append(clocks[1] - clocks[0])
        pixels = max(pixels, one.radiance.size)
        height, width = one.radiance.shape
        strips = strips_of(scene, instant, (one.left, one.top, one.left + width, one.top + height))
        pairs = [(strip, brightness(one, strip), brightness(other, strip)) for strip in strips]
        found = difference(pairs, scene.paper - scene.ink)
        images.append(found.image)
        if found.phase_rad is not None:
            phases.append(found.phase_rad)
    return Estimate(rays, _rms(phases), _rms(images) or 0.0, min(seconds, default=0.0), min(finer, default=0.0), pixels)


def cheapest(scene: Scene, instants: Sequence[Instant], error_rad: float) -> Estimate:
    """The cheapest setting whose estimated phase error is at most `error_rad`.

    Convention: a film without fringes has no phase error, and gets the cheapest setting.
    Source: `estimate_error` up the `LADDER`.
    Raises: SpecError where even the dearest setting has a larger error.
    """
    found = None
    for rays in LADDER:
        found = estimate_error(scene, instants, rays)
        if found.phase_rad is None or found.phase_rad <= error_rad:
            return found
    assert found is not None
    raise SpecError(
        f"a phase error of {error_rad:g} rad is not met even by {math.prod(LADDER[-1])} rays a pixel "
        f"(estimated {found.phase_rad:.2g} rad); give a larger --error, or come nearer",
        estimated_rad=found.phase_rad,
    )


def _rms(figures: Sequence[float]) -> float | None:
    """Root mean square; None of an empty list."""
    return math.sqrt(sum(figure * figure for figure in figures) / len(figures)) if figures else None
