"""A smooth field as the tracer reads it.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.payloads import payload_for_name
from kit.seen_gratings import instant
from moireid.designer import Order, design_badge
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.analytic.traced_page import cell_table, printed_scales
from moireid.simulate.cameras import Camera
from moireid.simulate.mitsuba.sheet import page_strips
from moireid.simulate.scene import Build, Scene
from moireid.smooth_lines import LineField

BUILD = Build(print_scale=1.004)


@pytest.fixture(scope="module", params=["x", "xy"])
def scene(request) -> Scene:
    return Scene(
        design_badge(Order("Ada", lens="50lpi", axes=request.param, pattern="silk"), payload_for_name("Ada")),
        BUILD,
        Camera(),
    )


def places(scene: Scene, number: int, count: int = 4000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places as printed, across and along from the board's centre; the line's number there, as designed."""
    grating = scene.badge.gratings[number]
    field, (scale, _) = LineField(grating), printed_scales(scene, grating)
    centre = scene.badge.frame_of(grating).places(scene.board_centre_mm)
    rng = np.random.default_rng(3)
    x, y = rng.uniform(field.low, field.high, count), rng.uniform(field.begin, field.end, count)
    return scale[0] * (x - centre[0]), scale[1] * (y - centre[1]), field.numbers(x, y)


def test_patches_have_the_field_s_numbers(scene):
    """Catches: a patch one row off; a slant of the wrong sign; a print scale on one side only; the second grating's
    patches counted as the first one's."""
    cells = cell_table(scene)
    for number in range(len(scene.badge.gratings)):
        across, along, wanted = places(scene, number)
        columns, rows = (
            np.searchsorted(cells.cuts[number, k], at, side="right") for k, at in ((0, across), (1, along))
        )
        patch = cells.grid[number, rows, columns]
        assert patch.min() >= 0
        edge, per_mm, duty, slant = cells.lines[patch].T
        off = (across - edge) * per_mm + along * slant - wanted
        off -= np.round(off.mean())
        assert np.abs(off).max() < 0.04 and np.sqrt(np.mean(off**2)) < 0.006
        assert duty == pytest.approx(0.5)


@pytest.mark.parametrize("distance_mm", [500.0, 1000.0, 1500.0])
def test_rays_that_meet_many_patches_are_traced_at_once(scene, distance_mm):
    """Catches: the wrong patch among those around a pixel, by a row, a column or a width; a field that is left to the
    careful tracer, which takes four times as long."""
    seen = instant((80.0, -60.0, -distance_mm))
    fast, careful = (AnalyticRenderer(scene, precision=p).render(seen).radiance for p in ("float32", "float64"))
    assert np.any(fast != careful)
    # The two differ in a ray now and then; a patch taken for another is a third of the contrast off and more.
    contrast = scene.paper - scene.ink
    assert np.sqrt(np.mean((fast - careful) ** 2)) < 0.01 * contrast


def test_strips_of_ink_cover_half_of_the_field(scene):
    """Catches: strips of paper over ink; slices in another grating's frame; lines that are lost at the field's ends."""
    for grating in scene.badge.gratings:
        strips = page_strips(scene, grating)
        ink, paper = (
            float((np.ptp(strips[name].across, axis=1) * np.ptp(strips[name].along, axis=1)).sum())
            for name in ("ink", "paper")
        )
        low, top, high, bottom = grating.rect_mm
        assert ink + paper == pytest.approx(1.004**2 * (high - low) * (bottom - top), rel=1e-3)
        assert ink / paper == pytest.approx(1.0, abs=0.02)
