"""Badges under a lens array: two gratings in one field.  Each test names the fault that it catches."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.badge import badge_from_json
from moireid.designer import Request, design_badge
from moireid.designer.formats import in_format
from moireid.designer.grid import RIM_MM
from moireid.errors import DesignError

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
REQUEST = Request("Ada", front="array", range_m=(0.8, 2.0))


def sides(grating) -> tuple[float, float]:
    """Length of a coded cell along the grating's axis, and height of its row."""
    cell = next(cell for cell, role in zip(grating.cells, grating.code.roles, strict=True) if role == "phase")
    wide, high = cell.rect_mm[2] - cell.rect_mm[0], cell.rect_mm[3] - cell.rect_mm[1]
    return (wide, high) if grating.axis == "x" else (high, wide)


def test_both_gratings_fill_one_field_and_rows_of_one_are_columns_of_the_other():
    """Catches: fields side by side, or a cell of one that spans two of the other."""
    x, y = design_badge(REQUEST, PAYLOAD).gratings
    assert (x.axis, y.axis) == ("x", "y")
    assert x.rect_mm == y.rect_mm
    assert sides(x) == pytest.approx(sides(y)[::-1])


def test_a_strip_is_read_over_a_whole_period_of_the_other_fringes():
    """Catches: a beat of the usual length, under which one grating's fringes drag the other's along."""
    badge = design_badge(REQUEST, PAYLOAD)
    for own, other in (badge.gratings, badge.gratings[::-1]):
        read_mm = sides(own)[1] - 2 * RIM_MM
        code = other.code
        middle = code.base_frequency_per_mm + 3.5 * code.frequency_step_per_mm
        assert middle == pytest.approx(-1 / read_mm)
        coded = next(c for c, role in zip(other.cells, code.roles, strict=True) if role == "phase")
        assert 1 / (1 / badge.lens.pitch_mm - 1 / coded.pitch_mm) == pytest.approx(read_mm, rel=0.15)


def test_an_array_badge_survives_its_file():
    """Catches: a kind of lens that the schema does not know."""
    badge = design_badge(REQUEST, PAYLOAD)
    assert badge_from_json(badge.to_json()) == badge


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"axes": "hex"}, "senses x and y"),
        ({"range_m": (0.8, 2.6)}, "too fine beyond"),
        ({"size_mm": (48.0, 48.0), "range_m": (0.2, 0.3)}, "larger board"),
    ],
)
def test_what_an_array_cannot_do_is_refused(change, words):
    """Catches: a badge that is made and cannot be read."""
    with pytest.raises(DesignError, match=words):
        design_badge(replace(REQUEST, **change), PAYLOAD)


def test_an_array_within_a_frame_has_both_gratings_too():
    """Catches: a frame's layout that knows no array, whose one grating has cells for half of the word."""
    badge = design_badge(replace(REQUEST, markers="frame"), bytes(16))
    assert [grating.axis for grating in badge.gratings] == ["x", "y"]


def test_the_default_range_is_cut_to_what_fine_fringes_allow():
    """Catches: a refusal of --front array by itself."""
    near_m, far_m = in_format(Request("Ada", front="array"), "board").range_m
    assert near_m == 0.8 and 2.0 < far_m < 2.5
