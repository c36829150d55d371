"""The identity and the markers read off a painted page alone, by the ordinary decoder."""

from __future__ import annotations

from pathlib import Path

import pytest

from kit.programs import needs
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid_lab.bench.fabricate.painted import painted_figures
from moireid_lab.bench.fabricate.raster import Raster, paint, read_page, without_lines


def installed(raster: str) -> str:
    needs("gs" if raster == "ghostscript" else "pdftoppm")
    return raster


def page_of(badge: Badge, folder: Path, raster: str = "poppler") -> Raster:
    write_badge_pdf(badge, folder / "badge.pdf")
    page = paint(folder / "badge.pdf", installed(raster), int((badge.print or {})["dpi"]))
    assert page is not None
    return page


@pytest.mark.parametrize("raster", ["poppler", "ghostscript"])
@pytest.mark.parametrize(("form", "bits", "axes"), [("dots", 64, "x"), ("dots", 128, "xy"), ("vector", 64, "x")])
def test_the_identity_is_read_off_the_raster_alone(form, bits, axes, raster, rng, tmp_path) -> None:
    """Catches: a page whose lines spell another identity than badge.json; symbols, cells or axes in another order;
    lines shifted the wrong way; markers that a camera would not find."""
    payload = rng.bytes(bits // 8)
    size = (180.0, 200.0) if axes == "xy" else (146.0, 160.0)
    wish = Order("Ada", lens="50lpi", printer_dpi=600, form=form, axes=axes, size_mm=size, range_m=(0.8, 1.5))
    badge = design_badge(wish, payload)
    reading = read_page(page_of(badge, tmp_path, raster), without_lines(badge))
    assert reading is not None and reading.markers == (0, 1, 2, 3) and reading.marker_error_mm < 0.05
    assert reading.found.payload == payload and reading.found.beats_agree and reading.found.corrected == 0
    # Half a dot at 600 dpi would be 0.25 rad if all lines of a cell went one way.
    assert reading.phase_error_rad < 0.1


def test_the_reader_knows_no_line(rng, tmp_path) -> None:
    """Catches: a reader that is given what it should read; a page that reads as the badge it is compared with."""
    printed, other = (design_badge(Order("Ada", lens="50lpi", printer_dpi=600), rng.bytes(8)) for _ in range(2))
    known = without_lines(other)
    assert known == without_lines(printed) and known.id is None
    assert {(cell.pitch_mm, cell.edge_mm) for cell in known.gratings[0].cells} == {(0.508, 0.0)}
    page = page_of(printed, tmp_path)
    assert painted_figures(page, printed)["read"] and not painted_figures(page, printed)["wrong"]
    figures = painted_figures(page, other)
    assert figures["wrong"] and not figures["read"]
