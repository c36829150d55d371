"""Flaws of print, sheet and assembly in the fast renderer, held against closed forms.

Frames are those of `kit.seen_gratings`.  Next to each test: what it would catch.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.seen_gratings import View, instant, law_phase, left_over, render, steepness, transposed, view
from moireid.lenticule import view_law
from moireid.simulate.analytic import analytic_renderer
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.analytic.page_light import page_light
from moireid.simulate.analytic.traced_page import _spread
from moireid.simulate.analytic.traced_sheet import land, sheet_as_built, traced_gap_mm
from moireid.simulate.analytic.uneven_sheet import STEP_MM, _smooth, air_waves, lens_asides
from moireid.simulate.build import BAND_MM, SMOOTH_MM, Build, build_named, flawed
from moireid.simulate.flaw_table import FLAWS
from moireid.simulate.scene import Scene

STRAIGHT = (0.0, 0.0, -1001.0)


def test_an_ideal_build_is_traced_the_fast_way_without_tables(prototype):
    """Catches: a flaw that costs time where it is not; a build as designed that is not `Build()`, as it was before."""
    ideal = AnalyticRenderer(Scene(prototype, build_named("ideal", 7)))
    assert ideal.scene.build == Build() == flawed(Build(), {name: _none(name) for name in FLAWS})
    assert math.isfinite(ideal._spread(instant(STRAIGHT))) and ideal._light is None
    assert (ideal._board.places.size, ideal._board.asides.size, ideal._board.waves.size) == (1, 1, 1)
    typical = AnalyticRenderer(Scene(prototype, Build.typical(7)))
    assert math.isfinite(typical._spread(instant(STRAIGHT))) and typical._light is None


def _none(name: str) -> float:
    """The value of a flaw that a badge as designed has."""
    return getattr(Build(), FLAWS[name].field) / FLAWS[name].factor


def test_ink_widens_lines_on_both_sides(prototype):
    """Catches: growth of each edge by the whole; an edge that stays, which turns the phase; growth by a share.

    The third harmonic of lines of duty d is |sin 3 pi d|, whatever the lens makes of it.
    """
    wider_um, cell = 60.0, prototype.gratings[0].cells[0]
    plain, inked = (view(prototype, STRAIGHT, Build(ink_um=um)) for um in (0.0, wider_um))
    third = []
    for seen in (plain, inked):
        law = law_phase(prototype, seen, STRAIGHT)
        assert abs(left_over(seen, law)) < 0.01
        third.append(abs((seen.brightness * np.hanning(seen.x_mm.size) * np.exp(-3j * law)).sum()))
    duties = cell.duty, cell.duty + wider_um / 1000 / cell.pitch_mm
    ratio = math.sin(3 * math.pi * duties[1]) / math.sin(3 * math.pi * duties[0])
    assert third[1] / third[0] == pytest.approx(abs(ratio), abs=0.03)
    dark = [(0.85 - seen.brightness.mean()) / 0.79 for seen in (plain, inked)]
    assert dark[1] - dark[0] == pytest.approx(duties[1] - duties[0], abs=0.01)


@pytest.mark.parametrize("by_px", [0.25, 0.6, 1.4])
def test_ink_widens_what_is_not_a_line_too(by_px):
    """Catches: growth of lines alone; whole pixels; growth by the light, which would widen the white."""
    page = np.ones((80, 80), np.float32)
    page[20:60, 20:60] = 0.0
    lost = (page - _spread(page, by_px)).sum()
    assert lost == pytest.approx(4 * 40 * by_px + 4 * by_px**2, abs=2.0)


def test_lenses_that_wander_turn_the_phase(prototype, monkeypatch):
    """Catches: a wander of the page; the sense of a shift; 2 pi d / p_r in place of 2 pi d / p_f (0.03 rad)."""
    shift = np.full((1, 99, 99), 0.1)
    monkeypatch.setattr(analytic_renderer, "lens_asides", lambda _: shift)
    seen = view(prototype, STRAIGHT, Build(wander_mm=0.1))
    turned = left_over(seen, law_phase(prototype, seen, STRAIGHT))
    assert turned == pytest.approx(2 * math.pi * 0.1 / prototype.lens.pitch_mm, abs=0.01)


def test_a_gradient_of_the_pitch_bends_the_phase(prototype):
    """Catches: a gradient for each half; one that moves the middle; a linear phase.  2 pi G x^2 / (2 W p_f)."""
    share = 0.01
    seen, plain = (view(prototype, STRAIGHT, Build(pitch_gradient=one)) for one in (share, 0.0))
    low, _, high, _ = prototype.gratings[0].rect_mm
    parts = np.array_split(np.arange(seen.x_mm.size), 3)
    turned = []
    for part in parts:
        own, even = (View(one.brightness[:, part], one.x_mm[part], one.y_mm) for one in (seen, plain))
        law = law_phase(prototype, own, STRAIGHT)
        turned.append(left_over(own, law) - left_over(even, law))
    places = np.array([seen.x_mm[part].mean() for part in parts])
    wanted = math.pi * share * places**2 / ((high - low) * prototype.lens.pitch_mm)
    bend = turned[0] + turned[2] - 2 * turned[1]
    assert bend == pytest.approx(wanted[0] + wanted[2] - 2 * wanted[1], rel=0.08)
    assert abs(turned[0] - turned[2]) < 0.1


def test_smooth_fields_have_their_size_and_reach(prototype):
    """Catches: white noise; a field of another rms; an even shift or stretch left in; one draw for all badges."""
    one, other = (Scene(prototype, Build(wander_mm=0.02, air_wave_mm=0.04, seed=seed)) for seed in (1, 2))
    aside = lens_asides(one)[0]
    low, begin, high, end = one.own_rect_mm(prototype.gratings[0], prototype.gratings[0].rect_mm)
    place = STEP_MM * (np.arange(len(aside)) - len(aside) // 2)
    inside = np.ix_((place >= begin) & (place <= end), (place >= low) & (place <= high))
    assert aside[inside].std() == pytest.approx(0.02, rel=1e-6)
    slope = np.polyfit(place[(place >= low) & (place <= high)], aside[inside].mean(axis=0), 1)[0]
    assert abs(slope) < 1e-9
    assert air_waves(one)[0][inside].std() == pytest.approx(0.04, rel=1e-6)
    assert not np.array_equal(aside, lens_asides(other)[0])
    assert np.array_equal(aside, lens_asides(Scene(prototype, one.build))[0])
    steps = round(SMOOTH_MM / STEP_MM)
    near, far = [], []
    for seed in range(12):
        field = _smooth(Scene(prototype, Build(seed=seed)), 0, 5)
        near.append((field[1:] * field[:-1]).mean() / (field**2).mean())
        far.append((field[steps:] * field[:-steps]).mean() / (field**2).mean())
    assert np.mean(near) > 0.95 and np.mean(far) == pytest.approx(math.exp(-1), abs=0.2)


def test_waves_of_air_add_to_the_gain_there(prototype, monkeypatch):
    """Catches: waves of the page alone; a wave that counts twice.  An even wave is a gap (test_renderer)."""
    camera = (150.0, 0.0, -1001.0)
    gap, bare = (view(prototype, camera, Build(air_gap_mm=air)) for air in (0.05, 0.02))
    monkeypatch.setattr(analytic_renderer, "air_waves", lambda _: np.full((1, 99, 99), 0.03))
    waved = view(prototype, camera, Build(air_gap_mm=0.02, air_wave_mm=0.03))
    law = law_phase(prototype, gap, camera)
    assert left_over(waved, law) == pytest.approx(left_over(gap, law), abs=0.004)
    assert abs(left_over(bare, law) - left_over(gap, law)) > 0.04


@pytest.mark.parametrize("index", [1.49, 1.56])
def test_an_ellipse_of_one_conic_focuses_in_one_line(prototype, index):
    """Catches: the circle's normals; +1/n^2; a root for circles.  Source: Descartes; R = g (n - 1) / n, k = -1/n^2."""
    lens = replace(prototype.lens, refractive_index=index, radius_mm=None, thickness_mm=1.2)
    sheet = sheet_as_built(Scene(replace(prototype, lens=lens), Build(conic=-1 / index**2)))
    round_one = sheet._replace(conic=0.0)
    starts = np.linspace(-0.49, 0.49, 21) * sheet.pitch
    spread, wide = (max(abs(land(float(x), 0.0, 0.0, 0.0, 0.0, one)[0]) for x in starts) for one in (sheet, round_one))
    assert spread < 1e-12 and wide > 0.005
    # Equal optical paths make the way from the surface to the focus L = g - d/n; a ray x out lands t dx/d(x/L) / n
    # aside, which is less than t g/n: coma.
    x = np.linspace(-0.5, 0.5, 4001) * sheet.pitch
    deep = x**2 / (sheet.radius + np.sqrt(sheet.radius**2 - (1 + sheet.conic) * x**2))
    moved = 1 / np.gradient(x / (1.2 - deep / index), x) / index
    assert traced_gap_mm(sheet, 0.52) == pytest.approx(moved.mean(), rel=0.004)


def test_a_soft_sheet_is_traced_with_its_radius(prototype):
    """Catches: a radius that the renderer does not see; one over that of a sheet of the design's thickness."""
    build = Build(focus_ratio=1.3, thickness_ratio=0.9)
    lens = Scene(prototype, build).lens
    index = lens.refractive_index
    assert lens.radius_mm == pytest.approx(1.3 * 0.9 * prototype.lens.thickness_mm * (index - 1) / index)
    camera = (250.0, 0.0, -1001.0)
    seen = view(prototype, camera, build)
    assert abs(left_over(seen, law_phase(replace(prototype, lens=lens), seen, camera))) < 0.02


def test_a_bow_along_y_turns_lenses_across_y_alone(prototype):
    """Catches: a direction that is not used, or exchanged."""
    radius_m = 1.0
    along = Build(bow_radius_m=radius_m, bow_angle_rad=math.pi / 2)
    still = view(prototype, STRAIGHT, along)
    assert abs(steepness(still, law_phase(prototype, still, STRAIGHT), axis=1)) < 2e-3
    lying = view(transposed(prototype), STRAIGHT, along)
    seen = View(lying.brightness.T, lying.y_mm, lying.x_mm)
    pitch = prototype.gratings[0].cells[0].pitch_mm
    more = 2 * math.pi * view_law(prototype.lens, pitch).effective_gap_mm(pitch) / pitch / (1000 * radius_m)
    assert steepness(seen, law_phase(prototype, seen, STRAIGHT), axis=1) == pytest.approx(more, rel=0.08)


def test_a_lifted_corner_tilts_the_fringes(prototype):
    """Catches: the twist's sense; a lift shared by fewer corners.  The lenses turn by t y: 2 pi g_eff t / p_r a mm."""
    lift_mm = -8.0
    half_x, half_y = Scene(prototype).board_half_mm
    twist = lift_mm / (4 * half_x * half_y)
    seen = view(prototype, STRAIGHT, Build(corner_lift_mm=lift_mm))
    pitch = prototype.gratings[0].cells[0].pitch_mm
    wanted = 2 * math.pi * view_law(prototype.lens, pitch).effective_gap_mm(pitch) / pitch * twist
    assert steepness(seen, law_phase(prototype, seen, STRAIGHT), axis=0) == pytest.approx(wanted, rel=0.08)


def test_a_bent_page_keeps_its_length(prototype):
    """Catches: marks on a bent page that are placed along its chord: at R = 0.3 m, 73 mm out, 0.7 mm too far out."""
    radius_mm, half = 300.0, Scene(prototype).board_half_mm[0]
    shot = render(prototype, instant(STRAIGHT), Build(bow_radius_m=radius_mm / 1000), rays=(16, 4))
    out = radius_mm * math.sin(half / radius_mm)
    deep = radius_mm * (1 - math.cos(half / radius_mm))
    width_px = 2 * out / (1001.0 + deep) * 1450.0
    row = shot.coverage[shot.coverage.shape[0] // 2]
    assert row.sum() == pytest.approx(width_px, abs=0.5)


def test_a_bent_board_is_not_cut_off(prototype):
    """Catches: a box of pixels for the flat board, where a bend reaches beyond it."""
    camera, build = (200.0, 60.0, -600.0), Build(bow_radius_m=0.25, bow_angle_rad=0.6, corner_lift_mm=15.0)
    shot = render(prototype, instant(camera), build, rays=(4, 1))
    renderer = AnalyticRenderer(Scene(prototype, build), rays=(4, 1))
    high, wide = shot.coverage.shape
    crop = (shot.left - 20, shot.top - 20, shot.left + wide + 20, shot.top + high + 20)
    wider = renderer.render(instant(camera), crop=crop)
    assert wider is not None and wider.coverage.sum() == pytest.approx(shot.coverage.sum(), rel=1e-3)


def test_haze_takes_its_share_of_the_contrast(prototype):
    """Catches: a blur of the picture, which leaves wide fringes as they are; haze outside the sheet; light lost."""
    plain, hazy = (view(prototype, STRAIGHT, Build(haze=share)).brightness for share in (0.0, 0.4))
    inner = slice(20, -20)
    assert hazy[inner, inner].std() / plain[inner, inner].std() == pytest.approx(0.6, abs=0.01)
    assert hazy[inner, inner].mean() == pytest.approx(plain[inner, inner].mean(), abs=0.02)
    corner = slice(0, 40)
    ends = [render(prototype, instant(STRAIGHT), Build(haze=share)).radiance[corner, corner] for share in (0.0, 0.4)]
    assert np.array_equal(*ends)


def test_bands_and_side_light_multiply(prototype):
    """Catches: bands along the lenses; bands that move with the camera; a side exchanged."""
    build = Build(banding=0.1, side_light=0.2, seed=4)
    plain, seen = (render(prototype, instant(STRAIGHT), one) for one in (Build(), build))
    factor = (seen.radiance / np.maximum(plain.radiance, 1e-6))[4:-4, 4:-4]
    sides = factor.mean(axis=0)
    assert sides[-1] / sides[0] == pytest.approx(1.2 / 0.8, rel=0.03)
    bands = factor.mean(axis=1) / factor.mean()
    turned = np.exp(2j * math.pi * np.arange(len(bands)) * 1001.0 / 1450.0 / BAND_MM)
    assert 2 * abs((bands - bands.mean()) @ turned) / len(bands) == pytest.approx(0.1, rel=0.1)
    moved = render(prototype, instant((100.0 * 1001.0 / 1450.0, 30 * 1001.0 / 1450.0, -1001.0)), build)
    rows = slice(0, 40)
    assert np.allclose(moved.radiance[rows, rows], seen.radiance[rows, rows], atol=1e-4)
    assert page_light(Scene(prototype)) is None


@pytest.mark.parametrize("end", ["low", "high"])
def test_the_ends_of_every_range_can_be_filmed(prototype, end):
    """Catches: a range that promises what the tracer cannot do: nan, an exception, or a picture out of bounds."""
    for name, one in FLAWS.items():
        value = getattr(one, end)
        if name == "ellipse" and end == "high":
            value = 0.3
        if name in ("focus", "thickness") and end == "low":
            # These lenses would not meet, which is refused (test_build).
            value = 0.8
        if name == "lens-scale" and end == "high":
            value = 1.05
        shot = AnalyticRenderer(Scene(prototype, flawed(Build(), {name: value})), rays=(4, 1)).render(
            instant((200.0, 100.0, -600.0))
        )
        assert shot is not None, name
        assert np.isfinite(shot.radiance).all() and shot.radiance.min() >= 0 and shot.radiance.max() < 20, name
