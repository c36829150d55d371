"""Figures of films against the builds that they would come from.  Next to each test: the fault that it catches."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.bringup.build_folder import Figure
from moireid.bringup.film_figures import film_figures
from moireid.designer import Order, design_badge
from moireid.sheets import effective_gap_mm

THICKNESS = Figure("Sheet thickness", 1.0, 0.01, "mm", "by a calliper")


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Order("Ada", lens="50lpi"), bytes(16))


def built(badge: Badge, **figures: float) -> AsBuilt:
    """A badge exactly as designed, but for some figures."""
    usual = {"beat_frequency_per_mm": -0.04, "beat_frequency_sd": 1e-5, "offset_rad": 0.5, "offset_sd": 0.02}
    usual |= {"twist_rad_per_mm": 0.0, "twist_sd": 1e-4, "gain_ratio": 1.0, "gain_sd": 0.01, "third_harmonic": 0.3}
    return AsBuilt(badge.id, **(usual | figures))


def figures_of(badge: Badge, *built: AsBuilt, thickness: Figure | None = THICKNESS) -> dict[str, Figure]:
    return {figure.name: figure for figure in film_figures([], built, badge, thickness)}


@pytest.mark.parametrize("air_mm", [0.0, 0.06, 0.15])
def test_air_is_what_the_thickness_does_not_explain(badge, air_mm):
    """Catches: air as gain times thickness, 30 % off; an error bar without the thickness's; air from a label."""
    pitch = badge.gratings[0].pitch_mm
    gain = effective_gap_mm(badge.lens, pitch, air_mm) / effective_gap_mm(badge.lens, pitch)
    found = figures_of(badge, built(badge, gain_ratio=gain))["Air under the sheet"]
    assert found.value == pytest.approx(air_mm, abs=0.004) and 0.006 < found.sd < 0.02
    assert bool(found.advice) == (air_mm > 0.1)
    blind = figures_of(badge, built(badge, gain_ratio=gain), thickness=None)["Air under the sheet"]
    assert blind.value is None and "calliper" in blind.advice


@pytest.mark.parametrize(("third_harmonic", "advised"), [(0.155, True), (0.165, False)])
def test_a_sheet_that_is_soft_is_told_by_the_third_harmonic(third_harmonic, advised):
    """Catches: another limit than docs/first-physical-film.md has for the sheet of boards."""
    board = design_badge(Order("Ada"), bytes(8))
    assert bool(figures_of(board, built(board, third_harmonic=third_harmonic))["Focus"].advice) == advised


def test_pitch_and_twist_are_those_of_the_sheet(badge):
    """Catches: the beat's sign; phase per mm taken for an angle; the sheet's pitch where the lines' is meant."""
    grating = next(one for one in badge.gratings if one.code is not None)
    lines_mm = grating.cells[grating.code.reference_cell].pitch_mm
    one = built(badge, beat_frequency_per_mm=1 / lines_mm - 1 / 0.5092, twist_rad_per_mm=2 * math.pi * 0.004 / 0.508)
    found = figures_of(badge, one)
    assert found["Pitch on the badge"].value == pytest.approx(0.5092, abs=1e-6)
    assert found["Twist"].value == pytest.approx(math.degrees(0.004 * badge.lens.pitch_mm / 0.508), rel=1e-6)
    far = built(badge, beat_frequency_per_mm=1 / lines_mm - 1 / 0.513, twist_rad_per_mm=-0.2)
    found = figures_of(badge, far)
    assert found["Pitch on the badge"].advice and found["Twist"].advice


def test_two_films_must_agree_within_their_error_bars(badge):
    """Catches: offsets compared across a whole turn; differences over no error bar."""
    one = built(badge, offset_rad=math.pi - 0.01)
    near, far = (replace(one, offset_rad=-math.pi + apart) for apart in (0.01, 0.4))
    agree = figures_of(badge, one, near)["Two films differ by"]
    differ = figures_of(badge, one, far)["Two films differ by"]
    assert agree.value == pytest.approx(0.02 / math.hypot(0.02, 0.02)) and not agree.advice
    assert differ.value > 10 and differ.advice
