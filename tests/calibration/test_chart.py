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
from moireid.designer.chart import BOARD_WIDTH_MM, MIN_BAND_MM, STEP_LPI, design_chart
from moireid.dots import line_edges_mm
from moireid.errors import DesignError, SpecError
from moireid.fabrication.page.chart_page import JSON, PDF, band_label, print_chart
from moireid.profiles import FORMS, PAPERS_MM

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


@pytest.mark.parametrize(("lens", "paper", "steps"), SHEETS)
def test_bands_lie_one_below_another_in_the_middle_of_the_page(lens, paper, steps):
    """Catches: a board off the paper or off its middle, bands that overlap or are too low, markers over the lines."""
    chart = design_chart(lens=lens, paper=paper, steps=steps)
    rects = np.array([cell.rect_mm for cell in chart.gratings[0].cells])
    assert np.array_equal(rects[1:, 1], rects[:-1, 3])
    assert np.all(np.ptp(rects[:, [0, 2]], axis=0) == 0) and (rects[:, 3] - rects[:, 1]).min() >= MIN_BAND_MM - 0.002
    width, height = PAPERS_MM[paper]
    board = chart.outline_mm
    assert (board[0] + board[2], board[1] + board[3]) == pytest.approx((width, height), abs=0.002)
    assert board[2] - board[0] == pytest.approx(BOARD_WIDTH_MM) and board[1] >= 11.99
    reach = chart.markers.size_mm / 2 * (1 + 2 / 6)
    for _, y in chart.markers.centers_mm:
        assert y + reach < rects[0, 1] + 1e-6 or y - reach > rects[-1, 3] - 1e-6


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


@pytest.mark.parametrize(("paper", "most"), [("a4", 19), ("letter", 17)])
def test_too_many_or_no_steps_are_refused_with_what_fits(paper, most):
    """Catches: bands too thin to be distinguished, a chart of one band, advice that is refused in its turn."""
    for steps in (0, -3, most + 1, 10**9):
        with pytest.raises(DesignError, match=f"1 to {most}") as refused:
            design_chart(paper=paper, steps=steps)
        assert refused.value.details["most_steps"] == most
    assert len(design_chart(paper=paper, steps=most).gratings[0].cells) == 2 * most + 1


@pytest.mark.parametrize("dpi", [300, 600, 1200, 2400, 4800])
def test_printers_from_300_to_4800_dpi_draw_every_sheet(dpi, tmp_path):
    """Catches: a limit made for badges, whose code asks for finer dots than a uniform band does."""
    for lens in ("40lpi", "75lpi"):
        chart = design_chart(lens=lens, printer_dpi=dpi, steps=2)
        print_chart(chart, tmp_path / f"{lens}{dpi}")
        drawn = 25.4 * printed_frequencies(chart)
        # Half a dot over the field, at most, and far less at the resolutions that people print at.
        assert np.abs(drawn / [25.4 / c.pitch_mm for c in chart.gratings[0].cells] - 1).max() < 0.2 * 25.4 / dpi / 136
    with pytest.raises(DesignError, match="dots wide"):
        design_chart(lens="75lpi", printer_dpi=144)


@pytest.mark.parametrize(("lens", "paper", "steps"), SHEETS)
def test_numbers_and_pitches_are_left_and_right_of_their_bands(lens, paper, steps, tmp_path):
    """Catches: labels left out, off by one, off the page, on the lines, or next to another band."""
    chart = design_chart(lens=lens, paper=paper, steps=steps)
    print_chart(chart, tmp_path)
    sheet = page(tmp_path / PDF)
    text, height = sheet.get_textpage(), sheet.get_height()
    for number, cell in enumerate(chart.gratings[0].cells, 1):
        x0, y0, x1, y1 = (value * 72 / 25.4 for value in cell.rect_mm)
        name, pitch = band_label(number, cell.pitch_mm)
        assert pitch == f"{float(lens[:2]) + (number - 1 - steps) * 0.1:.1f} LPI"
        board = [value * 72 / 25.4 for value in chart.outline_mm]
        for left, right in ((board[0], x0), (x1, board[2])):
            words = text.get_text_bounded(left=left, right=right, bottom=height - y1, top=height - y0).split()
            assert sorted(words) == sorted([name, *pitch.split()])
        assert not text.get_text_bounded(left=x0, right=x1, bottom=height - y1, top=height - y0).strip()


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
    with pytest.raises(SpecError, match="--overwrite"):
        print_chart(chart, tmp_path / "60lpi")
    print_chart(chart, tmp_path / "60lpi", overwrite=True)
    assert (tmp_path / "60lpi" / PDF).read_bytes() == before
    assert sorted(path.name for path in (tmp_path / "60lpi").iterdir()) == [JSON, PDF]
