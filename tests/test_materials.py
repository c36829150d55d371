"""The table of materials: what its labels mean."""

from __future__ import annotations

from moireid.materials import materials
from moireid.sheets import PRODUCTS

LABELLED = {row.label: row for row in materials() if row.label is not None}


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
