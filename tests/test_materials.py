"""The table of materials: what its labels mean."""

from __future__ import annotations

from moireid.materials import materials
from moireid.sheets import PRODUCTS

LABELLED = {row.label: row for row in materials() if row.label is not None}


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
            assert row.per_pack or "packs" in (row.unstated or ""), row.words
            assert "adhesive" in f"{row.figures}{row.unstated}", row.words
        if row.kind == "lens sheet":
            stated = sorted(", ".join(row.figures.values()).split(", "))
            held = {"pitch": row.lines_per_inch, "thickness": row.thick_mm, "angle": row.angle_deg}
            held |= {"plastic": row.plastic, "index": row.refractive_index, "radius": row.label}
            held |= {"sizes": row.sizes_mm, "pack": row.per_pack, "price": row.price}
            assert [one for one in stated if one != "adhesive back"] == sorted(w for w, one in held.items() if one)


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
    found = {label: (lens.pitch_mm, lens.thickness_mm, lens.refractive_index) for label, lens in PRODUCTS.items()}
    assert found == {label: (25.4 / lines, *rest) for label, (lines, *rest) in wanted.items()}
    assert [label for label, row in LABELLED.items() if not row.sold] == ["40lpi", "50lpi", "60lpi", "75lpi"]
