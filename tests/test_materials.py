"""The table of materials: its schema, its sources, and that defaults are products."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from moireid.cli.printing.print_cmd import print_command
from moireid.designer.formats import FORMATS
from moireid.errors import SpecError
from moireid.materials import TABLE, materials, materials_for, read_materials, sheet_labelled
from moireid.sheets import PLASTICS, PRODUCTS


def test_each_row_states_its_source_and_what_is_missing() -> None:
    """Catches: a figure without a source; a product whose missing price or maker is passed over in silence."""
    for row in materials():
        assert len(row.source) > 5, row
        if row.sold:
            missing = row.unstated or ""
            assert row.price is not None or "price" in missing or row.kind == "lens sheet", row
            assert row.maker is not None or "maker" in missing, row
        if row.kind == "lens sheet" and row.sold:
            for figure, word in ((row.thick_mm, "thickness"), (row.angle_deg, "angle"), (row.plastic, "plastic")):
                assert figure is not None or word in (row.unstated or ""), (row.words, word)
            assert row.sizes_mm or "sheet sizes" in (row.unstated or ""), row.words


def test_the_default_sheet_of_each_format_is_a_product() -> None:
    """Catches: a default that no one sells, as the shape of the published prototype."""
    for name, form in FORMATS.items():
        row = sheet_labelled(form.lens)
        assert row is not None and row.sold and row.angle_deg is not None, name


def test_labels_keep_their_optics() -> None:
    """Catches: a table that changes what a label means, so that a stored badge has another sheet than its label.

    The figures are those of the code from before the table.
    """
    mil = 0.0254
    wanted = {
        "40lpi": (40.0, 1.25, 1.56),
        "50lpi": (50.0, 1.00, 1.56),
        "60lpi": (60.0, 0.84, 1.56),
        "75lpi": (75.0, 0.67, 1.56),
        "20lpi-2mm": (20.0, 2.0, 1.57),
        "30lpi-47mil": (30.0, 47 * mil, 1.57),
        "40lpi-33mil": (40.0, 33 * mil, 1.57),
        "40lpi-2mm": (40.0, 2.0, 1.49),
        "60lpi-1.2mm": (60.0, 1.2, 1.57),
        "62lpi-27mil": (62.0, 27 * mil, 1.57),
        "75lpi-18mil": (75.0, 18 * mil, 1.575),
        "100lpi-14mil": (100.0, 14 * mil, 1.575),
    }
    found = {label: (one.lines_per_inch, one.thickness_mm, one.refractive_index) for label, one in PRODUCTS.items()}
    assert found == wanted
    assert [label for label, one in PRODUCTS.items() if not one.sold] == ["40lpi", "50lpi", "60lpi", "75lpi"]
    assert {one.plastic for one in materials() if one.label} <= set(PLASTICS)


def test_acrylic_is_listed_in_what_shops_stock() -> None:
    """Catches: a thickness of 2, 3 or 4 mm for which the list finds no plate; one of 0.8 mm for which it finds some."""
    for thickness in (2.0, 3.0, 4.0):
        assert materials_for("acrylic", thickness_mm=thickness), thickness
    assert not materials_for("acrylic", thickness_mm=0.8)


def test_the_help_lists_every_label_with_its_figures() -> None:
    """Catches: a label that the help leaves out, or gives another thickness or angle; words that name no source."""
    words = " ".join((print_command.help or "").split())
    for label, one in PRODUCTS.items():
        figure = f"{one.thickness_mm:.2f} mm" if one.angle_deg is None else f"{one.angle_deg:g} degrees"
        assert re.search(rf"{re.escape(label)}\b[^,]*?{re.escape(figure)}", words), label
    assert "resellers" not in words and "moireid materials" in words


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('kind = "lens sheet"', 'kind = "lens"'), "kind"),
        (("lines_per_inch = 40", "lines_per_inch = -40"), "lines_per_inch"),
        (("thickness_mm = 1.25", "thickness_mm = 1.25\nthickness_mil = 40"), "both given"),
        (("price = 990\n", ""), "price and currency"),
        (('label = "50lpi"', 'label = "40lpi"'), "twice"),
        (('plastic = "PETG"\nrefractive_index = 1.56', "refractive_index = 1.56"), "plastic"),
        (("\nsold = false", "\nsodl = false"), "sodl"),
        (("format = 1", "format = 2"), "format 2"),
        (("[[material]]", "[[material"), "cannot be read"),
    ],
)
def test_a_wrong_table_is_refused_with_the_place(change: tuple[str, str], words: str, tmp_path: Path) -> None:
    """Catches: a schema that lets an unknown key, a wrong kind or figures that contradict each other pass."""
    text = TABLE.read_text(encoding="utf-8")
    assert change[0] in text
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(text.replace(*change, 1), encoding="utf-8")
    with pytest.raises(SpecError, match=r"table of materials wrong\.toml") as caught:
        read_materials(wrong)
    assert words in str(caught.value)
