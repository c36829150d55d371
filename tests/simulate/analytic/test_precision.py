"""The fast renderer against an outside tracer, and what it refuses to build."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.errors import SpecError
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.build import Build
from moireid.simulate.scene import Scene
from moireid_lab.bench.simulate.reference import refract
from moireid_lab.bench.simulate.scenes import STEEP_TANGENT, eleven
from moireid_lab.bench.simulate.simulate_suite import FINE, error_of, truth_of

SETTINGS = {setting.name: setting for setting in eleven()}
FEW = ("prototype, 1 m", "turned in the picture by 30 degrees", "both axes", "thick sheet, 3 mm", "line mask")


@pytest.mark.claim("The renderer agrees with an outside tracer")
@pytest.mark.slow
@pytest.mark.parametrize("name", FEW)
def test_the_renderer_agrees_with_an_outside_tracer(name):
    """Catches: a wrong lens, law, axis, sense of a twist or edge; float32 that loses the phase."""
    setting = SETTINGS[name]
    contrast = setting.scene.paper - setting.scene.ink
    renderer = AnalyticRenderer(setting.scene, rays=FINE)
    for tangent, limit_rad in ((-0.4, 0.005), (0.25, 0.005), (STEEP_TANGENT, 0.02)):
        truth = truth_of(setting, tangent, budget=150_000)
        found = error_of(renderer.render(truth.instant), truth, contrast)
        assert found.phase_rad < limit_rad and found.image < 0.035


def test_float32_and_float64_see_the_same():
    """Catches: places far away given in float32; a neighbour taken at the wrong slant; tangents held in a pixel."""
    for name in FEW:
        setting = SETTINGS[name]
        instant = setting.seen_at(0.3)
        fast, careful = (
            AnalyticRenderer(setting.scene, precision=precision).render(instant).radiance
            for precision in ("float32", "float64")
        )
        assert np.sqrt(np.mean((fast - careful) ** 2)) < 0.005


def test_the_outside_tracer_refracts_by_snell():
    """Catches: a reference that bends the wrong way, which would agree with nothing and prove nothing."""
    way = np.array([[np.sin(0.7), 0.0, np.cos(0.7)]])
    bent = refract(way, np.array([[0.0, 0.0, -1.0]]), 1.5)
    assert bent[0] == pytest.approx([np.sin(0.7) / 1.5, 0.0, np.sqrt(1 - (np.sin(0.7) / 1.5) ** 2)])


def test_what_cannot_be_built_is_refused(prototype):
    """Catches: lenses spread beyond their diameter, without glass between, that render something."""
    with pytest.raises(SpecError):
        AnalyticRenderer(Scene(prototype, Build(lens_scale=1.5)))
