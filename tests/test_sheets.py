"""Sheets as sold: the table, and how far fringes can move under them.  Each test names what it would catch."""

from __future__ import annotations

import math

import pytest

from moireid.badge import badge_from_json
from moireid.designer import Order, design_badge
from moireid.errors import SpecError
from moireid.lenticule import trace_law
from moireid.materials import materials
from moireid.profiles import lens_named, mask_named
from moireid.sheets import (
    DEFAULT_LENS,
    PRODUCTS,
    angles_in_focus_deg,
    effective_gap_mm,
    possible_gains,
    repeat_deg,
    sheet_lens,
)

OLD = {"40lpi": 1.25, "50lpi": 1.00, "60lpi": 0.84, "75lpi": 0.67}


@pytest.mark.parametrize("label", PRODUCTS)
def test_every_product_says_what_its_label_says(label):
    """Catches: figures that slipped by a row; a sheet that cannot be traced, or not where it is wider than stated."""
    lens = lens_named(label)
    assert lens.radius_mm > 1.1 * lens.pitch_mm / 2
    assert label.startswith(f"{25.4 / lens.pitch_mm:g}lpi")
    if label.endswith("mil"):
        assert lens.thickness_mm == pytest.approx(0.0254 * float(label.split("-")[1][:-3]))
    rear = 1.02 * lens.pitch_mm
    traced = trace_law(lens, rear).effective_gap_mm(rear)
    # Rays that meet a half circle's flank go to the next lens in one trace, and are lost in the other.
    assert effective_gap_mm(lens, rear) == pytest.approx(traced, rel=0.04)


@pytest.mark.claim
def test_the_angles_that_sellers_state_are_not_the_laws() -> None:
    """Catches: a row whose radius can be solved from its angle after all, and must be; an angle of half a period."""
    # The published prototype: a picture repeats after 2 asin(n sin(atan(p / 2 g))) by the ray through a lens's top.
    lens = lens_named("50lpi")
    chief = 2 * math.degrees(math.asin(1.56 * math.sin(math.atan(0.508 / 2 / 1.00))))
    assert repeat_deg(lens) == pytest.approx(chief, rel=0.05)
    for row in materials():
        if row.label is not None and row.angle_deg is not None:
            low, high = angles_in_focus_deg(PRODUCTS[row.label])
            assert row.angle_deg < low <= high < 75, row.label
    # docs/decisions/printing.md.
    assert repeat_deg(PRODUCTS[DEFAULT_LENS]) == pytest.approx(53.6, abs=0.2)
    assert 51 < angles_in_focus_deg(PRODUCTS[DEFAULT_LENS])[0] < 52.5


def test_a_gap_adds_its_own_depth_near_the_axis():
    """Catches: a gap divided by the index, or added to the sheet.  Chief rays leave as they came."""
    lens = sheet_lens(0.508, 3.0, 1.56)
    bare, apart = (effective_gap_mm(lens, 0.52, gap) for gap in (0.0, 0.1))
    assert apart - bare == pytest.approx(0.1, rel=0.02)
    prototype = lens_named("50lpi")
    more = effective_gap_mm(prototype, 0.52, 0.05) / effective_gap_mm(prototype, 0.52)
    assert more == pytest.approx(1.10, abs=0.002)  # docs/explanation/physics.md
    mask = mask_named("50lpi", 1.5)
    assert effective_gap_mm(mask, 0.52) == pytest.approx(1.5 / 1.49, rel=2e-3)
    assert effective_gap_mm(mask, 0.52, 0.2) - effective_gap_mm(mask, 0.52) == pytest.approx(0.2)


def test_gains_reach_from_the_thinnest_sheet_to_the_thickest_with_a_gap():
    """Catches: the half gain of a forger thought a sheet's; the common thin sheet or a gap of 0.1 mm left out."""
    for label in OLD:
        lens = lens_named(label)
        low, high = possible_gains(lens, 1.02 * lens.pitch_mm)
        assert 0.55 < low < 0.72 and high > 1.35
    thin = sheet_lens(25.4 / 75, 0.457, 1.56)
    lens = lens_named("75lpi")
    rear = 1.02 * lens.pitch_mm
    ratio = effective_gap_mm(thin, rear) / effective_gap_mm(lens, rear)
    low, high = possible_gains(lens, rear)
    assert low <= ratio and effective_gap_mm(lens, rear, 0.1) / effective_gap_mm(lens, rear) < high


def test_a_badge_is_designed_for_the_sheet_that_was_measured():
    """Catches: a thickness that is asked for and forgotten, or lost in badge.json; one given for a mask."""
    wish = Order("Thin", lens="75lpi", lens_thickness_mm=0.457)
    badge = design_badge(wish, bytes(8))
    assert badge.lens == sheet_lens(25.4 / 75, 0.457, 1.56)
    assert badge_from_json(badge.to_json()).lens == badge.lens
    with pytest.raises(SpecError, match="gap"):
        design_badge(Order("Mask", lens="50lpi", front="mask", lens_thickness_mm=0.457), bytes(8))


def test_a_sheet_of_another_thickness_still_meets_and_focuses():
    """Catches: cylinders that do not meet; a thick sheet that is left out of focus."""
    lens = lens_named("75lpi")
    thin, thick = (sheet_lens(lens.pitch_mm, mm, 1.56) for mm in (0.457, 0.8))
    assert thin.thickness_mm == 0.457 and thin.radius_mm >= lens.pitch_mm / 2
    assert thick.radius_mm == pytest.approx(0.8 * 0.56 / 1.56)
    for wrong in (0.0, -1.0, 0.1, math.nan, math.inf):
        with pytest.raises(SpecError):
            sheet_lens(lens.pitch_mm, wrong, 1.56)
