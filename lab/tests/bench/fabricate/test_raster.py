"""The identity and the markers read off a painted page alone, by the ordinary decoder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kit.programs import needs
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid_lab.bench.fabricate.painted import edge_errors, painted_figures
from moireid_lab.bench.fabricate.raster import Raster, paint, read_page, without_lines

#: Half a dot, and what binary fractions of a millimetre leave.
HALF = 0.5 + 1e-3


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
    size = (186.0, 200.0) if axes == "xy" else (146.0, 160.0)
    wish = Order("Ada", lens="50lpi", printer_dpi=600, form=form, axes=axes, size_mm=size, range_m=(0.8, 1.5))
    badge = design_badge(wish, payload)
    reading = read_page(page_of(badge, tmp_path, raster), without_lines(badge))
    assert reading is not None and reading.markers == (0, 1, 2, 3) and reading.marker_error_mm < 0.05
    assert reading.found.payload == payload and reading.found.beats_agree and reading.found.corrected == 0
    # Half a dot at 600 dpi would be 0.25 rad if all lines of a cell went one way.
    assert reading.phase_error_rad < 0.1


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_bent_lines_are_read_and_hold_their_edges(axes, rng, tmp_path) -> None:
    """Catches: cells read where their neighbours bend them; edges compared with straight lines; lines bent elsewhere
    than badge.json says; rows of dots that are rounded together."""
    size = (186.0, 200.0) if axes == "xy" else (146.0, 160.0)
    wish = Order("Ada", lens="50lpi", printer_dpi=600, axes=axes, size_mm=size, range_m=(0.8, 1.5), pattern="silk")
    badge = design_badge(wish, rng.bytes(8))
    page = page_of(badge, tmp_path)
    figures = painted_figures(page, badge)
    assert figures["read"] and figures["phase_rad"] < 0.2
    # Numbers are turned into dots by the pitch of the cell, which bent lines have nearly.
    assert np.abs(figures["errors"]).max() <= 1.02 * HALF and np.std(figures["errors"]) < 0.33
    assert max(map(abs, figures["pitches"])) < 60e-6


def test_the_pitch_family_is_read_too(rng, tmp_path) -> None:
    """Catches: beats of the wrong sign, bands read from below."""
    badge = design_badge(Order("Ada", lens="50lpi", printer_dpi=600, code="pitch"), rng.bytes(3))
    reading = read_page(page_of(badge, tmp_path), without_lines(badge))
    assert reading is not None and reading.found.payload is not None and reading.found.payload.hex() == badge.id


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


def test_a_page_without_markers_or_lines_reads_as_nothing(rng, tmp_path) -> None:
    """Catches: an identity made up from white paper; an exception where a marker is torn off."""
    badge = design_badge(Order("Ada", lens="50lpi", printer_dpi=600), rng.bytes(8))
    page = page_of(badge, tmp_path)
    assert read_page(replace(page, packed=np.zeros_like(page.packed)), without_lines(badge)) is None
    torn = page.packed.copy()
    torn[: len(torn) // 2, : torn.shape[1] // 2] = 0
    reading = read_page(replace(page, packed=torn), without_lines(badge))
    assert (
        reading is not None and len(reading.markers) == 3 and reading.found.payload in (None, bytes.fromhex(badge.id))
    )


@pytest.mark.parametrize(
    ("form", "raster", "dots"),
    [
        ("dots", "poppler", HALF),
        ("dots", "ghostscript", HALF),
        ("dots", "poppler-grey", HALF),
        ("vector", "poppler-grey", HALF),
        ("vector", "poppler", 1.01),
        ("vector", "ghostscript", 1.01),
    ],
)
def test_each_form_holds_its_edges_as_its_docstring_says(form, raster, dots, tmp_path) -> None:
    """Catches: dots that no longer suit every raster; a plain vector that is off by more than what touching adds."""
    badge = design_badge(Order("Ada", lens="50lpi", printer_dpi=600, form=form, pattern="cells"), bytes(range(8)))
    errors, pitches = edge_errors(page_of(badge, tmp_path, raster), badge)
    assert np.abs(errors).max() <= dots
    # Lines that are painted too wide are so on both sides: their centres, and so the pitch, stay.
    assert abs(errors.mean()) < 0.05
    assert max(map(abs, pitches)) < (10e-6 if form == "vector" else 60e-6)
    if dots > HALF:
        assert np.abs(errors).max() > 0.9, "the plain form has become better than its docstring says"


def test_a_file_that_is_no_page_is_reported(tmp_path) -> None:
    """Catches: a raster's own error handed on as a traceback."""
    (tmp_path / "no.pdf").write_text("no PDF")
    with pytest.raises(FabricationError, match=r"no\.pdf"):
        paint(tmp_path / "no.pdf", installed("poppler"), 72)
