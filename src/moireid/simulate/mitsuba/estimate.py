"""Mitsuba's own error, estimated on one frame before a film, and the cheapest setting that meets a wish.

Two renders of one frame with independent seeds differ by the square root of two times the rays' noise.  A third one
with twice the segments in each lens differs from their mean by that noise and by the segments' error.  That error
falls with the square of their number, so three quarters of it show.  The estimate combines both.

Not included: an error that finer segments share, such as Mitsuba's offset of rays (`page_depth_mm`), 0.001 rad;
and the difference to the independent tracer of `moireid bench simulate`, 0.004 rad at tangents of 0.3, because Mitsuba
weights rays by the light that the lens lets pass.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np

from moireid.errors import SpecError
from moireid.simulate.analytic.accuracy import Difference, brightness, difference, strips_of
from moireid.simulate.analytic.estimate import Estimate
from moireid.simulate.analytic.renderer import Rendered
from moireid.simulate.mitsuba.renderer import MitsubaRenderer
from moireid.simulate.scene import Instant, Scene

#: Rays in a pixel and segments in a lens: the usual setting, and the others from cheap to dear.
USUAL = (64, 16)
LADDER = ((16, 4), (16, 16), USUAL, (256, 16), (256, 32), (1024, 32))


def estimate_mitsuba(
    scene: Scene, instant: Instant, setting: tuple[int, int] = USUAL, *, seed: int = 0, variant: str | None = None
) -> Estimate:
    """Estimate the error of a setting (rays, segments) on one frame.

    Convention: module docstring.  Source: the same.
    Raises: SpecError like `MitsubaRenderer`.
    """
    samples, segments = setting
    renderer = MitsubaRenderer(scene, samples=samples, segments=segments, seed=seed, variant=variant)
    one = renderer.render(instant)
    if one is None:
        return Estimate((samples, 1), None, 0.0, 0.0, segments=segments)
    clock = time.perf_counter()
    other = renderer.render(instant)
    frame_s = time.perf_counter() - clock
    finer = MitsubaRenderer(scene, samples=samples, segments=2 * segments, seed=(seed + 1) % 2**31, variant=variant)
    clock = time.perf_counter()
    fine = finer.render(instant)
    finer_s = time.perf_counter() - clock
    assert other is not None and fine is not None
    mean = replace(one, radiance=(one.radiance + other.radiance) / np.float32(2))
    noise, beyond = _apart(scene, instant, one, other), _apart(scene, instant, fine, mean)
    phase = None
    if noise.phase_rad is not None and beyond.phase_rad is not None:
        phase = _both(noise.phase_rad, beyond.phase_rad)
    return Estimate(
        (samples, 1),
        phase,
        _both(noise.image, beyond.image),
        frame_s,
        finer_s=finer_s,
        pixels=one.radiance.size,
        segments=segments,
    )


def cheapest_mitsuba(
    scene: Scene, instant: Instant, error_rad: float, *, seed: int = 0, variant: str | None = None
) -> Estimate:
    """The cheapest setting whose estimated phase error is at most `error_rad`.

    Convention: a frame without fringes has no phase error, and gets the cheapest setting.
    Source: `estimate_mitsuba` up the `LADDER`.
    Raises: SpecError where even the dearest setting has a larger error.
    """
    for setting in LADDER:
        found = estimate_mitsuba(scene, instant, setting, seed=seed, variant=variant)
        if found.phase_rad is None or found.phase_rad <= error_rad:
            return found
    raise SpecError(
        f"a phase error of {error_rad:g} rad is not met by the mitsuba backend even with {LADDER[-1][0]} rays a pixel "
        f"(estimated {found.phase_rad:.2g} rad); give a larger --error, or use the analytic backend",
        estimated_rad=found.phase_rad,
    )


def _apart(scene: Scene, instant: Instant, one: Rendered, other: Rendered) -> Difference:
    height, width = one.radiance.shape
    strips = strips_of(scene, instant, (one.left, one.top, one.left + width, one.top + height))
    pairs = [(strip, brightness(one, strip), brightness(other, strip)) for strip in strips]
    return difference(pairs, scene.paper - scene.ink)


def _both(noise: float, beyond: float) -> float:
    """Error of one picture, from the difference of two, and of a third with finer segments from their mean."""
    square = noise**2 / 2
    return math.sqrt(square + max(beyond**2 - 1.5 * square, 0.0) * 16 / 9)
