"""Flaws of print, sheet and assembly in the fast renderer, held against closed forms.

Frames are those of `kit.seen_gratings`.  Next to each test: what it would catch.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.seen_gratings import View, instant, law_phase, left_over, render, steepness, view
from moireid.designer.formats import FORMATS
from moireid.lenticule import view_law
from moireid.profiles import lens_named
from moireid.simulate.analytic import analytic_renderer
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.analytic.traced_sheet import land, sheet_as_built, traced_gap_mm
from moireid.simulate.build import Build, flawed
from moireid.simulate.flaw_table import FLAWS
from moireid.simulate.scene import Scene

STRAIGHT = (0.0, 0.0, -1001.0)


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


@pytest.mark.parametrize("label", sorted({form.lens for form in FORMATS.values()}))
def test_ellipses_move_fringes_a_little_less(prototype, label):
    """Catches: another figure than docs/first-physical-film.md has for the sheets of formats."""
    lens = lens_named(label)
    round_one = sheet_as_built(Scene(replace(prototype, lens=lens)))
    pitch_mm, ellipse = 1.024 * lens.pitch_mm, round_one._replace(conic=-1 / lens.refractive_index**2)
    share = traced_gap_mm(ellipse, pitch_mm) / traced_gap_mm(round_one, pitch_mm)
    assert 0.98 < share < 0.99


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
