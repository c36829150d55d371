"""The parts of mounts as a list, and how long they take to print."""

from __future__ import annotations

import pytest
from moireid.fabrication.printing_times import PRINTING_TIMES

from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.fabrication.package import plan_parts
from moireid.fabrication.part_list import ACRYLIC, CARD, FILM, list_parts
from moireid.fabrication.printed.mount import KINDS


def test_no_mount_takes_more_than_two_hours() -> None:
    """Catches: a format or a mount without a time, one that takes a night; a slow test slices one of them again."""
    assert set(PRINTING_TIMES) == {(form, kind) for form in FORMATS for kind in KINDS}
    assert max(minutes for minutes, _ in PRINTING_TIMES.values()) <= 120


def test_parts_are_those_that_are_made() -> None:
    """Catches: a film listed as acrylic, layers of card forgotten, screws of another badge, times of another mount."""
    badge = design_badge(in_format(Request("Ada"), "a6", orientation="landscape"), bytes(8))
    found = list_parts(plan_parts(badge, "stand"), "a6")
    tray, stand = found["printed"]
    assert (tray.name, stand.name) == ("tray", "stand")
    assert (tray.minutes, tray.grams) == PRINTING_TIMES["a6", "stand"] and stand.minutes is None
    assert tray.size_mm == pytest.approx((148 + 4.6, 105 + 2.3))
    cut = {part.name: part for part in found["acrylic"]}
    assert [cut[name].thickness_mm for name in ("base", "frame", "cover")] == [3.0, 2.0, 2.0]
    assert {cut[name].material for name in ("base", "frame", "cover")} == {ACRYLIC} and cut["lips"].material == FILM
    layers = cut["layer below the page"]
    assert (layers.material, layers.count, layers.thickness_mm) == (CARD, 4, pytest.approx(0.3))
    assert layers.size_mm == pytest.approx((148.0, 105.0))
    assert cut["M3 button-head screw with nut"].count == 6
    holder = list_parts(plan_parts(badge, "holder"))["printed"]
    assert [part.name for part in holder] == ["holder"] and holder[0].minutes is None
