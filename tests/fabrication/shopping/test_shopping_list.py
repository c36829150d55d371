"""The shopping list: its quantities, its files, and what it refuses."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace

import ezdxf
import pypdfium2 as pdfium
import pytest

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.errors import FabricationError, SpecError
from moireid.fabrication.mount_parts import Parts, plan_parts
from moireid.fabrication.printed.mount import KINDS
from moireid.fabrication.process_figures import MountFigures
from moireid.fabrication.shopping.cutting import StockSheet
from moireid.fabrication.shopping.list_files import list_csv
from moireid.fabrication.shopping.mount_times import hours_of, mount_times, time_words
from moireid.fabrication.shopping.needs import ShoppingWish, lens_pieces, shopping_list
from moireid.fabrication.shopping.written import write_shopping
from moireid.fabrication.sight import sheet_rects

A4 = StockSheet(210.0, 297.0)
WITHOUT = Parts("none", None, MountFigures())


@pytest.fixture(scope="module")
def card() -> Badge:
    """A badge of card size on a sheet that is sold."""
    return design_badge(in_format(Request("A"), "cr80", range_m=(0.3, 0.6)), bytes(8))


def test_quantities_follow_from_the_badge_and_the_people(card: Badge) -> None:
    """Catches: a spare share that is left out, pages counted as badges, pieces of another size than the badge's."""
    found = shopping_list(card, WITHOUT, ShoppingWish(40, A4, form="cr80"))
    amounts = {line.key: line.quantity for line in found.lines}
    (piece,) = lens_pieces(card, 42)
    ((x0, y0, x1, y1),) = sheet_rects(card)
    assert (piece.across_mm, piece.along_mm) == pytest.approx((x1 - x0, y1 - y0))
    to_a_sheet = math.floor(204 / piece.across_mm) * math.floor(291 / piece.along_mm)
    assert amounts["lens-sheet"] == math.ceil(42 / to_a_sheet) == found.cutting.sheet_count
    assert amounts["holder"] == amounts["lanyard"] == 42
    pages = math.ceil(40 / 8)
    assert amounts["paper"] == pages + math.ceil(0.05 * pages)
    assert "75 LPI" in found.lines[0].what and "18 mil" in found.lines[0].what
    none = shopping_list(card, WITHOUT, ShoppingWish(40, A4, spare_share=0.0, form="cr80"))
    assert {line.key: line.quantity for line in none.lines}["holder"] == 40


def test_lenses_of_two_fields_run_as_each_field_needs_them() -> None:
    """Catches: a piece whose lenses run across the field; a second field that gets no piece."""
    badge = design_badge(Request("A", axes="xy", range_m=(0.8, 1.5)), bytes(8))
    pieces = lens_pieces(badge, 1)
    rects = sheet_rects(badge)
    axes = {grating.axis for grating in badge.gratings}
    assert axes == {"x", "y"} and sum(piece.count for piece in pieces) == len(rects) == 2
    wanted = []
    for grating in badge.gratings:
        x0, y0, x1, y1 = grating.rect_mm
        # Across the lenses is along the axis that the fringes sense.
        wanted.append((x1 - x0, y1 - y0) if grating.axis == "x" else (y1 - y0, x1 - x0))
    for across, along in wanted:
        assert any(one.across_mm >= across - 1e-3 and one.along_mm >= along - 1e-3 for one in pieces), (across, along)
    plan = shopping_list(badge, WITHOUT, ShoppingWish(3, A4)).cutting
    sizes = {piece.name: (piece.across_mm, piece.along_mm) for piece in plan.wanted}
    for sheet in plan.sheets:
        for name, rect in sheet.pieces:
            assert (rect[2] - rect[0], rect[3] - rect[1]) == pytest.approx(sizes[name])


def test_the_csv_adds_up_and_its_cells_are_no_formulas(card: Badge) -> None:
    """Catches: a total that is not the sum of its rows, or counts what has no price; a cell that is a formula."""
    wish = ShoppingWish(40, A4, form="cr80", prices={"lens-sheet": 4.5, "holder": 0.35})
    rows = list(csv.DictReader(io.StringIO(list_csv(shopping_list(card, WITHOUT, wish)))))
    *lines, last = rows
    priced = [float(row["total"]) for row in lines if row["total"]]
    assert len(priced) == 2 and float(last["total"]) == pytest.approx(sum(priced))
    for row in lines:
        if row["unit_price"]:
            assert float(row["total"]) == pytest.approx(float(row["quantity"]) * float(row["unit_price"]))
    assert {row["key"] for row in lines} >= {"lens-sheet", "paper", "holder", "lanyard"} and last["key"] == "total"
    assert not any(cell.startswith(("=", "+", "-", "@")) for row in rows for cell in row.values())
    bare = list(csv.DictReader(io.StringIO(list_csv(shopping_list(card, WITHOUT, ShoppingWish(2, A4))))))
    assert all(not row["unit_price"] and not row["total"] for row in bare)


def test_a_printed_mount_has_its_hours_and_grams(card: Badge) -> None:
    """Catches: the time of one mount given for all; grams without the spare; a mount without figures shown as free."""
    parts = replace(WITHOUT, printed="lanyard")
    found = shopping_list(card, parts, ShoppingWish(40, A4, form="cr80"))
    each = mount_times()["cr80", "lanyard"]
    assert found.mount == each and found.hours == pytest.approx(40 * each.hours)
    assert {line.key: line.quantity for line in found.lines}["filament"] == math.ceil(42 * each.grams)
    unknown = shopping_list(card, parts, ShoppingWish(40, A4, form=None))
    assert unknown.mount is None and unknown.hours is None and "was not sliced" in unknown.notes[0]
    assert hours_of("1d 2h 30m 36s") == pytest.approx(26.51) and time_words(3.585) == "3 h 35 min"
    with pytest.raises(ValueError, match="no time"):
        hours_of("soon")
    # Each format has each mount, and none takes a night; a slow test slices one of them again.
    assert set(mount_times()) == {(form, kind) for form in FORMATS for kind in KINDS}
    assert all(0.2 < one.hours <= 2 and 3 < one.grams < 300 for one in mount_times().values())


def test_an_acrylic_stack_lists_its_plates_and_screws() -> None:
    """Catches: plates of one thickness counted once for all three; screws for one badge; a stack that is not made."""
    badge = design_badge(in_format(Request("A"), "a6", lens="40lpi-2mm", range_m=(0.4, 1.0)), bytes(8))
    parts = plan_parts(badge, "lanyard")
    assert parts.acrylic is not None
    found = shopping_list(badge, parts, ShoppingWish(10, A4.turned, form="a6", made="acrylic"))
    amounts = {line.key: line.quantity for line in found.lines}
    assert amounts["screws"] == 11 * len(parts.acrylic.screws)
    keys = {f"acrylic-{plate.thickness_mm:g}mm" for plate in parts.acrylic.plates}
    assert keys == {key for key in amounts if key.startswith("acrylic")} and "filament" not in amounts
    x0, y0, x1, y1 = parts.acrylic.base.outline.bounds
    for key in keys:
        alike = [plate for plate in parts.acrylic.plates if f"acrylic-{plate.thickness_mm:g}mm" == key]
        area = 11 * len(alike) * (x1 - x0) * (y1 - y0)
        assert amounts[key] >= area / (304.8 * 609.6)
    without = replace(parts, acrylic=None, left_out={"acrylic": "the sheet is too thin"})
    with pytest.raises(FabricationError, match="no acrylic stack can be made: the sheet is too thin"):
        shopping_list(badge, without, ShoppingWish(10, A4.turned, made="acrylic"))


def test_the_files_say_what_the_plan_says(card: Badge, tmp_path) -> None:
    """Catches: a missing page; a drawing in inches or without cuts; files that change each time."""
    found = shopping_list(card, WITHOUT, ShoppingWish(25, A4, form="cr80"))
    files = write_shopping(found, tmp_path / "one")
    again = write_shopping(found, tmp_path / "two")
    assert {name: path.read_bytes() for name, path in files.items()} == {
        name: path.read_bytes() for name, path in again.items()
    }
    pages = [page.get_textpage().get_text_range() for page in pdfium.PdfDocument(files["cutting-plan.pdf"])]
    assert len(pages) == len(found.cutting.sheets)
    assert all("Never turn a piece" in words and "210 x 297" in words for words in pages)
    words = pdfium.PdfDocument(files["shopping-list.pdf"])[0].get_textpage().get_text_range()
    for line in found.lines:
        assert line.amount in words, line.key
    drawing = ezdxf.readfile(files["cutting-plan.dxf"])
    layers = [entity.dxf.layer for entity in drawing.modelspace()]
    assert drawing.units == ezdxf.units.MM and layers.count("SHEET") == len(found.cutting.sheets)
    assert layers.count("PIECE") == sum(len(sheet.pieces) for sheet in found.cutting.sheets)
    for entity in drawing.modelspace():
        if entity.dxf.layer == "CUT-1":
            # From edge to edge of its sheet.
            assert abs(entity.dxf.end.x - entity.dxf.start.x) == pytest.approx(210.0)
    with pytest.raises(SpecError, match="exists already"):
        write_shopping(found, tmp_path / "one")


def test_impossible_wishes_are_refused(card: Badge) -> None:
    """Catches: a list for no one, or for more than fit a plan; a price of what is not on the list, or below nothing."""
    for people in (0, -3, 10_001):
        with pytest.raises(SpecError, match="people are not possible"):
            ShoppingWish(people, A4)
    with pytest.raises(SpecError, match="spare share"):
        ShoppingWish(1, A4, spare_share=-0.1)
    with pytest.raises(SpecError, match="choose one of lens-sheet, paper"):
        shopping_list(card, WITHOUT, ShoppingWish(1, A4, prices={"gold": 1.0}))
    with pytest.raises(SpecError, match="price paper=-1"):
        shopping_list(card, WITHOUT, ShoppingWish(1, A4, prices={"paper": -1.0}))
    with pytest.raises(FabricationError, match="does not fit a sheet"):
        shopping_list(card, WITHOUT, ShoppingWish(1, StockSheet(50.0, 50.0)))
