"""The light's effect by Mitsuba against the analytic renderer's: phase of the fringes, brightness, glare.

Measured here (one band of Ada Lovelace's badge at 1 m; Mitsuba - analytic, with Mitsuba's own standard error, 1024 rays
six times by `llvm_ad_rgb`; the effect is the light's own turn of the phase by the analytic renderer):

| light                        | u    | effect, rad | apart, rad        |
|------------------------------|------|-------------|-------------------|
| even sky                     | 0.3  | -0.005      | +0.0023 +- 0.0005 |
| window                       | 0    | +0.017      | -0.0043 +- 0.0036 |
| window                       | 0.3  | +0.014      | +0.0121 +- 0.0021 |
| window                       | -0.3 |             | -0.0081 +- 0.0041 |
| box of 8 degrees and no sky  | 0    | +0.017      | +0.0088 +- 0.0026 |
| box of 8 degrees and no sky  | 0.2  | +0.086      | +0.009 +- 0.009   |
| box of 8 degrees and no sky  | -0.3 | -0.111      | -0.017 +- 0.007   |
| box of 8 degrees and no sky  | -0.4 | -0.192      | -0.032 +- 0.007   |

So 0.02 rad is kept wherever the picture is not dark; the last row, a fifth as bright as straight on, is beyond it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.payloads import payload_for_name
from kit.rendered_frames import analytic_frame, beyond_law_rad, cut, pixels_of, seen_from, turn_rad
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.simulate.analytic.analytic_renderer import BoardRadiance
from moireid.simulate.light import LIGHTS, DiscLight
from moireid.simulate.mitsuba.mitsuba_renderer import MitsubaRenderer
from moireid.simulate.scene import Scene

RUNS = 4


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi"), payload_for_name("Ada Lovelace", family="pitch"))


def frames(scene: Scene, u: float, samples: int) -> tuple[list[BoardRadiance], BoardRadiance, float, list[float]]:
    """Mitsuba's frames of a band by independent seeds, the analytic one, and both their phases beyond the law."""
    instant, cell = seen_from((1000 * u, 0, -1000)), scene.badge.gratings[0].cells[5]
    crop = pixels_of(scene, instant, cell.rect_mm)
    renderer = MitsubaRenderer(scene, samples=samples, variant="scalar_rgb")
    traced = [renderer.render(instant, crop=crop) for _ in range(RUNS)]
    found = [frame for frame in traced if frame is not None]
    assert len(found) == RUNS
    whole = analytic_frame(scene, instant, (32, 4))
    reference = BoardRadiance(cut(whole, crop).astype(np.float32), found[0].coverage, crop[0], crop[1])
    phases = [beyond_law_rad(frame, scene, instant, cell) for frame in found]
    return found, reference, beyond_law_rad(reference, scene, instant, cell), phases


@pytest.mark.parametrize(("u", "samples"), [(0.0, 144), pytest.param(0.3, 144, marks=pytest.mark.slow)])
def test_a_soft_box_turns_the_fringes_alike(badge: Badge, u: float, samples: int) -> None:
    """Two places, one facing the box's bright bands and one off them; the Monte-Carlo error is that of the seeds.

    Catches: a light mirrored left to right (the two places change their brightness), bands at another place of the
    pitch, light that passes no lens.
    """
    scene = Scene(badge, light=LIGHTS["softbox"])
    found, reference, expected, phases = frames(scene, u, samples)
    apart = np.array([turn_rad(phase, expected) for phase in phases])
    error = apart.std(ddof=1) / math.sqrt(RUNS)
    assert error < 0.008, f"{apart} rad apart"
    assert abs(apart.mean()) < 0.02, f"Mitsuba - analytic {apart.mean():.4f} +- {error:.4f} rad at u = {u}"
    mean = np.mean([frame.radiance for frame in found])
    assert mean == pytest.approx(reference.radiance.mean(), rel=0.04)


@pytest.mark.slow
def test_the_two_places_differ_in_brightness(badge: Badge) -> None:
    """What the test above rests on: mirrored, the box would show in a half of the brightness."""
    scene = Scene(badge, light=LIGHTS["softbox"])
    crop = [pixels_of(scene, seen_from((1000 * u, 0, -1000)), badge.gratings[0].cells[5].rect_mm) for u in (0.3, -0.3)]
    bright, dark = (
        cut(analytic_frame(scene, seen_from((1000 * u, 0, -1000)), (8, 2)), box).mean()
        for u, box in zip((0.3, -0.3), crop, strict=True)
    )
    assert abs(bright / dark - 1) > 0.15


@pytest.mark.slow
def test_the_streak_of_glare_is_as_bright(badge: Badge) -> None:
    """A lamp's glare on black paper, so that nothing else is seen: mean over the streak, and next to it nothing.

    Catches: Fresnel's share at the wrong angle, a streak too wide or too narrow, the disc at another height.
    """
    # A light of 100 mm, 40 mm up: mirrored half way between its height and the camera's.  One ray in 600 finds it,
    # a thousand in all, so that the noise is 3 %.
    light = DiscLight((400.0, -40.0, -1000.0), 50.0, 1.0)
    scene, instant = Scene(badge, ink=0.0, paper=0.0, light=light), seen_from((0, 0, -1000))
    crop = pixels_of(scene, instant, (92.0, 106.0, 104.0, 186.0))
    mitsuba = MitsubaRenderer(scene, samples=484, variant="scalar_rgb").render(instant, crop=crop)
    assert mitsuba is not None
    analytic = cut(analytic_frame(scene, instant, (32, 8)), crop)
    rows = mitsuba.radiance.mean(axis=1), analytic.mean(axis=1)
    lit = rows[1] > 0.5 * rows[1].max()
    assert 4 < np.count_nonzero(lit) < 0.8 * len(lit)
    assert rows[0][lit].mean() == pytest.approx(rows[1][lit].mean(), rel=0.08)
    assert rows[0][rows[1] == 0].max(initial=0.0) < 0.02 * rows[0].max()
