"""Backgrounds and borders: over all that is free, and never over what is read."""

from __future__ import annotations

import itertools

import pytest

from moireid.artwork.backgrounds import background_rects, border_rects, without
from moireid.artwork.clear import AIR_MM, BLEED_MM, clear_zones, overlap
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.formats import ORIENTATIONS


def badge_for(name: str, orientation: str, markers: str) -> Badge:
    order = Order("Ada", markers=markers, format=name, orientation=orientation, head=0.4, foot=0.1)
    return design_badge(order, bytes(8))


@pytest.mark.parametrize("markers", ["squares", "frame"])
@pytest.mark.parametrize("name", ["cr80", "a6"])
def test_backgrounds_and_borders_keep_clear_of_what_is_read(name: str, markers: str) -> None:
    """Catches: a shade up to a marker, under the lens sheet or within a coded frame; a border across the fringes."""
    for orientation in ORIENTATIONS:
        badge = badge_for(name, orientation, markers)
        zones = [(x0 - AIR_MM, y0 - AIR_MM, x1 + AIR_MM, y1 + AIR_MM) for _, (x0, y0, x1, y1) in clear_zones(badge)]
        x0, y0, x1, y1 = badge.outline_mm
        tint, stripes = (background_rects(badge, kind) for kind in ("tint", "stripes"))
        for rects in (tint, stripes, *(border_rects(badge, kind) for kind in ("line", "double", "bars"))):
            assert rects and not any(overlap(rect, zone) for rect in rects for zone in zones)
            assert all(x0 - BLEED_MM <= r[0] and y0 - BLEED_MM <= r[1] for r in rects)
            assert all(r[2] <= x1 + BLEED_MM and r[3] <= y1 + BLEED_MM for r in rects)
        assert not any(overlap(one, other) for one, other in itertools.combinations(tint, 2))
        assert min(rect[1] for rect in tint) == y0 - BLEED_MM and max(rect[3] for rect in tint) == y1 + BLEED_MM


def test_what_is_left_of_a_rectangle_has_the_right_area() -> None:
    """Catches: a corner that is lost, or counted twice."""
    zones = [(2.0, 2.0, 4.0, 4.0), (3.0, 3.0, 6.0, 5.0), (9.0, -1.0, 12.0, 1.0)]
    left = without((0.0, 0.0, 10.0, 10.0), zones)
    assert sum((r[2] - r[0]) * (r[3] - r[1]) for r in left) == pytest.approx(100 - 4 - 6 + 1 - 1)
    assert without((0.0, 0.0, 1.0, 1.0), [(-1.0, -1.0, 2.0, 2.0)]) == []
