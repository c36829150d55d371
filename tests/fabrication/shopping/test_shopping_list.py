"""The shopping list: its quantities and its files."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS
from moireid.errors import SpecError
from moireid.fabrication.mount_parts import Parts, plan_parts
from moireid.fabrication.printed.mount import KINDS
from moireid.fabrication.process_figures import MountFigures
from moireid.fabrication.shopping.shopping_list import (
    ShoppingList,
    lens_pieces,
    mount_times,
    shopping_list,
    with_spare,
)
from moireid.fabrication.sight import sheet_rects

WITHOUT = Parts("none", None, MountFigures())


@pytest.fixture(scope="module")
def card() -> Badge:
    """A badge of card size on a sheet that is sold."""
    return design_badge(Order("A", format="cr80", range_m=(0.3, 0.6)), bytes(8))


def listed(badge: Badge, parts: Parts, people: int, form: str | None = "cr80") -> ShoppingList:
    return shopping_list(badge, parts, people, (210.0, 297.0), form=form)


def amounts(found: ShoppingList) -> dict[str, int]:
    return {line.key: line.quantity for line in found.lines}


def test_quantities_follow_from_the_badge_and_the_people(card: Badge) -> None:
    """Catches: a spare share that is left out, pages counted as badges, pieces of another size than the badge's."""
    found = listed(card, WITHOUT, 40)
    (piece,), ((x0, y0, x1, y1),) = lens_pieces(card, 42), sheet_rects(card)
    assert (piece.across_mm, piece.along_mm) == pytest.approx((x1 - x0, y1 - y0))
    to_a_sheet = math.floor(204 / piece.across_mm) * math.floor(291 / piece.along_mm)
    # Nine on a page, and the pitch bands on one of their own.
    pages = math.ceil(40 / 9) + 1
    assert amounts(found) == {
        "lens-sheet": math.ceil(42 / to_a_sheet),
        "tape": math.ceil(2 * 42 * (piece.along_mm + 10) / 1000),
        "paper": pages + math.ceil(0.05 * pages),
        "holder": 42,
        "lanyard": 42,
    }
    assert "75 LPI" in found.lines[0].what and "18 mil" in found.lines[0].what
    for people in (0, -3, 10_001):
        with pytest.raises(SpecError, match="people are not possible"):
            listed(card, WITHOUT, people)


def test_lenses_of_two_fields_run_as_each_field_needs_them() -> None:
    """Catches: a piece whose lenses run across the field; a second field that gets no piece."""
    badge = design_badge(Order("A", lens="50lpi", axes="xy", range_m=(0.8, 1.5)), bytes(8))
    pieces = lens_pieces(badge, 1)
    assert {grating.axis for grating in badge.gratings} == {"x", "y"} and sum(piece.count for piece in pieces) == 2
    for grating in badge.gratings:
        x0, y0, x1, y1 = grating.rect_mm
        # Across the lenses is along the axis that the fringes sense.
        across, along = (x1 - x0, y1 - y0) if grating.axis == "x" else (y1 - y0, x1 - x0)
        assert any(one.across_mm >= across - 1e-3 and one.along_mm >= along - 1e-3 for one in pieces), (across, along)


def test_a_printed_mount_has_its_hours_and_grams(card: Badge) -> None:
    """Catches: the time of one mount given for all; grams without the spare; a mount without figures shown as free."""
    parts = replace(WITHOUT, printed="lanyard")
    (filament,) = (line for line in listed(card, parts, 400).lines if line.key == "filament")
    hours, grams = mount_times()["cr80", "lanyard"]
    assert filament.quantity == math.ceil(420 * grams) and f"{400 * hours:.1f} h for all" in filament.note
    unknown = listed(card, parts, 40, form=None)
    assert "filament" not in amounts(unknown) and "was not sliced" in unknown.notes[0]
    # Each format has each mount, and none takes a night; a slow test slices one of them again.
    assert set(mount_times()) == {(form, kind) for form in FORMATS for kind in KINDS}
    assert all(0.2 < hours <= 2 and 3 < grams < 300 for hours, grams in mount_times().values())


def test_the_spare_share_is_rounded_up_and_exact() -> None:
    """Catches: a spare that is lost in rounding, or one too many because a share in decimals is a little more."""
    assert [with_spare(count) for count in (1, 20, 21, 40, 100)] == [2, 21, 23, 42, 105]


def test_a_mask_takes_film_and_spacers() -> None:
    """Catches: a cutting plan for lens sheets that no one buys; a mask without its film."""
    badge = design_badge(Order("A", lens="50lpi", front="mask", range_m=(0.8, 1.5)), bytes(8))
    found = listed(badge, WITHOUT, 10, form=None)
    assert found.cutting is None and amounts(found)["film"] == 11 and "lens-sheet" not in amounts(found)
    assert amounts(found)[f"spacer-{badge.lens.thickness_mm:g}mm"] == 11


def test_an_acrylic_stack_lists_its_parts_and_screws() -> None:
    """Catches: plates of one thickness counted once for all three; screws for one badge."""
    badge = design_badge(Order("A", format="a6", lens="40lpi-2mm", range_m=(0.4, 1.0)), bytes(8))
    parts = replace(plan_parts(badge, "lanyard"), printed="none")
    assert parts.acrylic is not None
    found = shopping_list(badge, parts, 10, (297.0, 210.0), form="a6")
    wanted: dict[str, int] = {"screws": 11 * len(parts.acrylic.screws)}
    for plate in parts.acrylic.plates:
        key = f"acrylic-{plate.thickness_mm:g}mm"
        wanted[key] = wanted.get(key, 0) + 11
    assert wanted.items() <= amounts(found).items() and not {"filament", "holder"} & set(amounts(found))
