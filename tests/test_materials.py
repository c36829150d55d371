"""The table of materials: what its labels mean."""

from __future__ import annotations

from moireid.designer.formats import FORMATS
from moireid.materials import materials


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


def test_what_is_no_product_is_no_default() -> None:
    """Catches: the prototype's shape, which no one sells, offered as a sheet to buy."""
    assert [row.label for row in materials() if not row.sold] == ["40lpi", "50lpi", "60lpi", "75lpi"]
    assert {one.lens for one in FORMATS.values()} <= {row.label for row in materials() if row.sold}
