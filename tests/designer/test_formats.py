"""Formats: sizes that holders are made for, each with a sheet and a range at which it can be read."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.design import filled
from moireid.designer.formats import FORMATS, ORIENTATIONS
from moireid.designer.reach import CALL, PHONE, read_of, verdict_reach_m
from moireid.errors import DesignError
from moireid.frames import own_rect
from moireid.idcodes.pitch import code_of
from moireid.sheets import MM_PER_INCH

PAYLOAD = bytes.fromhex("7097c67b0fafc59b")
EACH = list(itertools.product(FORMATS, ORIENTATIONS, ("a4", "letter")))


@pytest.fixture(scope="module", params=EACH, ids=lambda case: "-".join(case))
def case(request: pytest.FixtureRequest) -> tuple[str, str, Badge]:
    name, orientation, paper = request.param
    wish = Order("Ada", paper=paper, format=name, orientation=orientation)
    return name, orientation, design_badge(wish, PAYLOAD)


def test_a_format_has_its_size_and_lies_whole_on_the_paper(case: tuple[str, str, Badge]) -> None:
    """Catches: width and height exchanged, a board over the paper's edge, no room for crop marks."""
    name, orientation, badge = case
    x0, y0, x1, y1 = badge.outline_mm
    sides = (x1 - x0, y1 - y0)
    assert sorted(sides) == pytest.approx(sorted(FORMATS[name].size_mm))
    assert (sides[0] > sides[1]) == (orientation == "landscape")
    assert min(x0, y0, badge.page_mm[0] - x1, badge.page_mm[1] - y1) >= 15 - 1e-9


def test_cells_have_enough_lenses_and_markers_enough_pixels(case: tuple[str, str, Badge]) -> None:
    """Catches: a coarser sheet or a smaller marker than docs/decisions/printing.md says."""
    name, _, badge = case
    grating = badge.gratings[0]
    roles = zip(grating.cells, code_of(grating).roles, strict=True)
    wide = [cell.rect_mm[2] - cell.rect_mm[0] for cell, role in roles if role == "phase"]
    assert min(wide) > 11 * badge.lens.pitch_mm
    assert round(MM_PER_INCH / badge.lens.pitch_mm) in (62, 75)
    assert name == "board" or badge.squares.size_mm * PHONE.focal_px / (1000 * badge.range_m[1]) > 19


def test_a_format_is_read_over_its_range_by_the_link_budget(case: tuple[str, str, Badge]) -> None:
    """Catches: a range that the markers or cells do not carry, as seen by the camera that the format is for."""
    name, _, badge = case
    assert badge.range_m is not None
    read = read_of(badge)
    assert read is not None
    receiver = CALL if name == "webcam" else PHONE
    assert min(read.at(metres, receiver).decode_probability for metres in badge.range_m) > 0.999
    # The board is also read from farther than eight seconds of swaying are enough for a verdict.
    assert name == "board" or badge.range_m[1] <= verdict_reach_m(badge)
    # Room for one step to either side, and not merely a point.
    assert badge.range_m[1] >= 2 * badge.range_m[0]
    assert badge.range_m == (FORMATS[name].range_m if name != "board" else badge.range_m)


def test_a_print_half_a_percent_off_and_a_twist_move_fringes_as_far_as_is_said(case: tuple[str, str, Badge]) -> None:
    """Catches: pitches or rows of a new format that leave the figures of docs/decisions/identity.md."""
    grating, lens = case[2].gratings[0], case[2].lens
    beat = abs(1 / grating.pitch_mm - 1 / lens.pitch_mm)
    assert 0.15 < 0.005 / grating.pitch_mm / beat < 0.41
    assert grating.code is not None
    rects = [own_rect(grating.axis, one.rect_mm) for one in grating.cells]
    middles = [(r[1] + r[3]) / 2 for r, role in zip(rects, grating.code.roles, strict=True) if role != "phase"]
    first, second = (b - a for a, b in itertools.pairwise(sorted(middles)))
    # Twists at which rows at even distances agree again.
    assert first != pytest.approx(second) or 0.3 < math.degrees(lens.pitch_mm / first) < 1.05


def test_a_range_is_cut_to_what_the_board_allows_and_kept_where_it_is_given() -> None:
    """Catches: a promise beyond the far end, and a user's own wish that is bent in silence."""
    tall = Order("A", format="board", orientation="landscape", head=0.6)
    near, far = filled(tall).range_m or (0.0, 0.0)
    assert near == 0.8 and 2.0 < far < 2.5
    with pytest.raises(DesignError, match="too small"):
        design_badge(replace(tall, range_m=(0.8, 2.5)), PAYLOAD)
    with pytest.raises(DesignError, match="leaves no room"):
        filled(Order("A", size_mm=(40.0, 40.0), head=0.6))
    full = filled(Order("A"))
    assert filled(full) == full
