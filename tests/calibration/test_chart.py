"""The pitch test sheet: its bands by numbers, its page as text and as dots, and its description read back."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pytest
from PIL import Image

from kit.programs import needs
from moireid.badge import Badge, load_badge
from moireid.calibration.chart_reading import printed_frequencies
from moireid.designer.chart import STEP_LPI, design_chart
from moireid.dots import line_edges_mm
from moireid.errors import DesignError, SpecError
from moireid.fabrication.page.chart_page import JSON, PDF, print_chart
from moireid.profiles import FORMS

SHEETS = [("40lpi", "a4", 19), ("50lpi", "a4", 10), ("50lpi", "letter", 17), ("75lpi", "letter", 1), ("60lpi", "a4", 5)]


def page(path: Path) -> pdfium.PdfPage:
    """Page 1 of a PDF."""
    return pdfium.PdfDocument(path)[0]


@pytest.mark.parametrize(("lens", "paper", "steps"), SHEETS)
def test_bands_are_a_tenth_of_a_line_apart_about_the_nominal_pitch(lens, paper, steps):
    """Catches: steps in mm instead of lines per inch, a nominal band off the middle, an order upside down."""
    chart = design_chart(lens=lens, paper=paper, steps=steps)
    lines = np.array([25.4 / cell.pitch_mm for cell in chart.gratings[0].cells])
    assert len(lines) == 2 * steps + 1
    assert np.diff(lines) == pytest.approx(np.full(2 * steps, STEP_LPI), abs=1e-9)
    assert lines[steps] == pytest.approx(float(lens[:2]), abs=1e-9) == 25.4 / chart.gratings[0].pitch_mm


def test_every_band_has_a_dark_line_on_the_common_middle():
    """Catches: edges aligned instead of lines, or bands that each begin at their own left end."""
    chart = design_chart()
    grating = chart.gratings[0]
    middle = (grating.rect_mm[0] + grating.rect_mm[2]) / 2
    for cell in grating.cells:
        centres = line_edges_mm(grating, cell).mean(axis=1)
        assert np.abs(centres - middle).min() < 1e-9


def test_charts_and_badges_are_distinguished_by_their_markers():
    """Catches: a badge, or the chart of another sheet, that is read as this chart."""
    ids = [set(design_chart(lens=lens).markers.ids) for lens in ("40lpi", "50lpi", "60lpi", "75lpi")]
    together = set.union({0, 1, 2, 3}, *ids)
    assert len(together) == 20 and max(together) < 50


def painted(pdf: Path, dpi: int) -> np.ndarray:
    """Page 1 as dots, True where dark, by Poppler; PDFium stretches pictures by a dot."""
    tool = needs("pdftoppm")
    out = pdf.with_suffix("")
    subprocess.run([tool, "-mono", "-r", str(dpi), "-singlefile", pdf, out], check=True)
    return np.asarray(Image.open(out.with_suffix(".pbm")).convert("L")) < 128


def middles_mm(row: np.ndarray, dot_mm: float) -> np.ndarray:
    """Middles of the dark runs of a row that holds both their ends."""
    steps = np.diff(row.astype(int))
    begins, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    ends = ends[ends > begins[0]]
    return (begins[: len(ends)] + ends) / 2 * dot_mm


@pytest.mark.parametrize("form", FORMS)
def test_the_bands_are_painted_at_the_pitch_that_a_reader_takes_them_for(form, tmp_path):
    """Catches: bands drawn at another's pitch, realised pitches of the wrong sign, a page that is scaled."""
    dpi = 600
    chart = design_chart(printer_dpi=dpi, form=form, steps=4)
    print_chart(chart, tmp_path)
    dark, dot = painted(tmp_path / PDF, dpi), 25.4 / dpi
    for cell, frequency in zip(chart.gratings[0].cells, printed_frequencies(chart), strict=True):
        x0, y0, x1, y1 = cell.rect_mm
        middles = middles_mm(dark[int((y0 + y1) / 2 / dot), int((x0 - 1) / dot) : int((x1 + 1) / dot)], dot)[1:-1]
        pitch = np.polyfit(np.arange(len(middles)), middles, 1)[0]
        # A plain vector's edges are rounded by the raster, of which the reader knows nothing.
        assert pitch * frequency == pytest.approx(1, abs=100e-6 if form == "vector" else 10e-6)
        assert len(middles) == pytest.approx((x1 - x0) * frequency, abs=3.01)


def test_the_description_reads_back_and_repeats(tmp_path):
    """Catches: figures that the schema refuses or JSON rounds; a date in the PDF; files written over unasked."""
    for lens, paper, steps in SHEETS:
        chart: Badge = design_chart(lens=lens, paper=paper, steps=steps)
        print_chart(chart, tmp_path / lens, overwrite=True)
        assert load_badge(tmp_path / lens / JSON) == chart and chart.id is None
    before = (tmp_path / "60lpi" / PDF).read_bytes()
    with pytest.raises(SpecError, match="overwrite=True"):
        print_chart(chart, tmp_path / "60lpi")
    print_chart(chart, tmp_path / "60lpi", overwrite=True)
    assert (tmp_path / "60lpi" / PDF).read_bytes() == before
    assert sorted(path.name for path in (tmp_path / "60lpi").iterdir()) == [JSON, PDF]


@pytest.mark.parametrize(("paper", "most"), [("a4", 19), ("letter", 17)])
def test_too_many_or_no_steps_are_refused_with_what_fits(paper, most):
    """Catches: bands too thin to be distinguished, a chart of one band, advice that is refused in its turn."""
    for steps in (0, -3, most + 1, 10**9):
        with pytest.raises(DesignError, match=f"1 to {most}") as refused:
            design_chart(paper=paper, steps=steps)
        assert refused.value.details["most_steps"] == most
    assert len(design_chart(paper=paper, steps=most).gratings[0].cells) == 2 * most + 1
