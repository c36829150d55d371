"""A smooth field as the tracer reads it.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.payloads import payload_for_name
from moireid.designer import Order, design_badge
from moireid.simulate.analytic.traced_page import cell_table, printed_scales
from moireid.simulate.cameras import Camera
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
        (columns, rows) = (
            np.clip((at - begin) * per_mm, 0, last).astype(int)
            for at, (begin, per_mm, last, even) in zip((across, along), cells.bins[number], strict=True)
            if even
        )
        level, per_mm, duty, slant = cells.print[number, rows, columns].astype(float).T
        assert per_mm.min() > 0
        off = level + across * per_mm + along * slant - wanted
        off -= np.round(off)
        assert np.abs(off).max() < 0.04 and np.sqrt(np.mean(off**2)) < 0.006
        assert duty == pytest.approx(0.5)
