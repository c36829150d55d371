"""The fast renderer against an outside tracer, its own error estimate, and stiff scenes."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.errors import SpecError
from moireid.simulate.analytic.accuracy import cheapest, estimate_error
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, ray_places
from moireid_lab.bench.simulate.reference import refract
from moireid_lab.bench.simulate.scenes import STEEP_TANGENT, eleven
from moireid_lab.bench.simulate.simulate_suite import FINE, error_of, speed_at_equal_error, truth_of
from moireid_lab.bench.simulate.stiff_scenes import render_case, stiff_scenes

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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["prototype, 1 m", "as built: twist, offset, scale", "both axes"])
def test_the_estimate_is_near_the_truth(name):
    """Catches: an estimate of something else, in other units, or that flatters.  Measured 0.6 to 2.1 of the truth."""
    setting = SETTINGS[name]
    contrast = setting.scene.paper - setting.scene.ink
    renderer, squares, images = AnalyticRenderer(setting.scene), [], []
    instants = []
    # As many strips in all, whether of one grating or of two; each costs the outside tracer half a second.
    per_grating = 3 // len(setting.badge.gratings)
    for tangent in (-0.4, -0.1, 0.15, 0.4):
        truth = truth_of(setting, tangent, per_grating=per_grating, budget=200_000)
        found = error_of(renderer.render(truth.instant), truth, contrast)
        squares.append(found.phase_rad**2)
        images.append(found.image)
        instants.append(truth.instant)
    estimate = estimate_error(setting.scene, instants)
    assert 0.4 < estimate.phase_rad / np.sqrt(np.mean(squares)) < 4
    assert 0.7 < estimate.image / np.mean(images) < 1.4


@pytest.mark.slow
def test_the_cheapest_setting_that_meets_the_wish_is_taken():
    """Catches: a ladder climbed from the top; a wish that is not met in silence."""
    setting = SETTINGS["prototype, 1 m"]
    instants = [setting.seen_at(0.2)]
    loose, tight = (cheapest(setting.scene, instants, error) for error in (0.05, 0.001))
    assert np.prod(loose.rays) < np.prod(tight.rays) and tight.phase_rad <= 0.001
    with pytest.raises(SpecError, match="larger --error"):
        cheapest(setting.scene, instants, 1e-9)


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


def test_rays_share_no_column_and_no_row():
    """Catches: a grid that is not sheared, rays outside of the pixel, a centre that is off."""
    for shape in ((16, 1), (8, 2), (1, 1), (5, 7)):
        places = ray_places(*shape)
        count = shape[0] * shape[1]
        even = (np.arange(count) + 0.5) / count - 0.5
        for axis in (0, 1):
            assert np.sort(places[axis]) == pytest.approx(even, abs=1e-6)


def test_the_outside_tracer_refracts_by_snell():
    """Catches: a reference that bends the wrong way, which would agree with nothing and prove nothing."""
    way = np.array([[np.sin(0.7), 0.0, np.cos(0.7)]])
    bent = refract(way, np.array([[0.0, 0.0, -1.0]]), 1.5)
    assert bent[0] == pytest.approx([np.sin(0.7) / 1.5, 0.0, np.sqrt(1 - (np.sin(0.7) / 1.5) ** 2)])


STIFF = ("pitch ratio 1 + 1e-09", "distance 100 m", "view at 70 degrees", "sheet 10 mm", "n = 2", "no light")


@pytest.mark.slow
@pytest.mark.parametrize("name", STIFF)
def test_stiff_scenes_are_right_within_their_bar(name):
    """Catches: phases formed from large differences, roots that cancel, tangents held over a wide pixel."""
    (case,) = [case for case in stiff_scenes() if case.name == name]
    row = render_case(case)
    assert row["outcome"] == "right", row


@pytest.mark.parametrize("name", ["n = 1", "lenses spread beyond their diameter"])
def test_what_cannot_be_built_is_refused(name):
    """Catches: a lens without focus or without glass between that renders something."""
    (case,) = [case for case in stiff_scenes() if case.name == name]
    row = render_case(case)
    assert row["outcome"] == "refused" and row["why"]


def test_speed_is_compared_at_equal_error():
    """Catches: the fastest of all taken for the one that errs as little; the worst of Mitsuba for the best."""
    work = [
        {"renderer": name, "camera": "1080p", "setting": [1, 1], "seconds": seconds, "phase_rad": error}
        for name, seconds, error in (
            ("analytic", 0.001, 0.01),
            ("analytic", 0.004, 0.001),
            ("mitsuba a", 0.4, 0.005),
            ("mitsuba a", 0.2, 0.02),
            ("mitsuba b", 9.0, 0.0001),
        )
    ]
    found = speed_at_equal_error(work)
    assert found["times"] == pytest.approx(100) and found["phase_rad"] == 0.005
