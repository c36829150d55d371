"""pitch-test.pdf and pitch-test.json: the pitch test sheet with its numbers, and how to read it.

The lines, markers, crop marks and scale bars are those of a badge's page; only the words differ.
"""

from __future__ import annotations

from pathlib import Path

from moireid.badge import Badge, load_badge
from moireid.errors import FabricationError
from moireid.fabrication.page.canvas import BOLD, POINTS_PER_MM, REGULAR, PdfPage
from moireid.fabrication.page.pdf import draw_upright, write_badge_pdf
from moireid.files import planned, whole_file
from moireid.ink_strip import ink_patches
from moireid.sheets import MM_PER_INCH

PDF, JSON = "pitch-test.pdf", "pitch-test.json"
HEADING_POINTS, TEXT_POINTS, LABEL_POINTS = 15.0, 7.5, 8.5
LINE_MM = 4.2
#: White between a band and its label; between words and markers.
LABEL_GAP_MM, SIDE_GAP_MM = 2.0, 4.0
#: Width of a band's number; its lines per inch are next to it.
NUMBER_MM = 7.0


def print_chart(chart: Badge, folder: Path, *, overwrite: bool = False) -> dict[str, Path]:
    """Write the sheet and its description into `folder`; both or, where something fails, neither.

    Returns: path by name.
    Raises: SpecError where a file is in the way; FabricationError where the description does not read back.
    """
    sheet, description = folder / PDF, folder / JSON
    planned([sheet, description], overwrite=overwrite)
    # The description goes last, so that where it exists the sheet exists too.
    with whole_file(description) as new_description, whole_file(sheet) as new_sheet:
        write_badge_pdf(chart, new_sheet, write_words=_write_words)
        new_description.write_text(chart.to_json(), encoding="utf-8")
        if load_badge(new_description) != chart:
            raise FabricationError(f"{JSON} does not read back as it was written; report this")
    return {PDF: sheet, JSON: description}


def band_label(number: int, pitch_mm: float) -> tuple[str, str]:
    """A band's number and its lines per inch, as printed on the sheet."""
    lines_per_inch = MM_PER_INCH / pitch_mm
    # For a measured sheet, the bands' lines per inch are not whole tenths.
    decimals = 1 if abs(round(lines_per_inch, 1) - lines_per_inch) < 1e-6 else 2
    return str(number), f"{lines_per_inch:.{decimals}f} LPI"


def _write_words(sheet: PdfPage, chart: Badge) -> None:
    """Heading and instructions between the upper markers, what to do next between the lower, labels at the bands."""
    assert chart.range_m is not None
    grating = chart.gratings[0]
    middle, half = chart.page_mm[0] / 2, chart.squares.size_mm / 2
    top_mm = chart.squares.centers_mm[0][1] - half
    room_mm = chart.squares.centers_mm[1][0] - chart.squares.centers_mm[0][0] - 2 * (half + SIDE_GAP_MM)
    sheet.text(
        middle,
        top_mm + HEADING_POINTS / POINTS_PER_MM,
        f"Pitch test, {MM_PER_INCH / grating.pitch_mm:.4g} lines per inch",
        points=HEADING_POINTS,
        font=BOLD,
    )
    _lines(
        sheet,
        middle,
        top_mm + 11.5,
        room_mm,
        [
            "1. Lay the lens sheet on the bands, ribs up and along the lines. Leave one row of numbers free.",
            f"2. Look from {chart.range_m[0]:g} m away. Turn the sheet until the fringes are upright. The band that is",
            "all light or all dark from edge to edge, and changes at once as you move a little, has the sheet's pitch.",
        ],
    )
    _lines(
        sheet,
        middle,
        chart.squares.centers_mm[3][1] - 10.0,
        room_mm,
        [
            "3. Photograph the whole chart with all four squares. Leave the lowest row of patches free:",
            "it shows by how much the printer widens lines.",
            f"Then:  moireid calibrate PHOTO --chart {JSON} --out sheet.json",
        ],
    )
    draw_upright(sheet, [line for patch in ink_patches(chart) for line in patch.lines_mm], "x")
    for number, cell in enumerate(grating.cells, 1):
        baseline = (cell.rect_mm[1] + cell.rect_mm[3]) / 2 + 0.36 * LABEL_POINTS / POINTS_PER_MM
        name, pitch = band_label(number, cell.pitch_mm)
        left, right = cell.rect_mm[0] - LABEL_GAP_MM, cell.rect_mm[2] + LABEL_GAP_MM
        sheet.text(left, baseline, name, points=LABEL_POINTS, font=BOLD, align="right")
        sheet.text(left - NUMBER_MM, baseline, pitch, points=TEXT_POINTS, align="right")
        sheet.text(right, baseline, name, points=LABEL_POINTS, font=BOLD, align="left")
        sheet.text(right + NUMBER_MM, baseline, pitch, points=TEXT_POINTS, align="left")


def _lines(sheet: PdfPage, middle: float, first: float, room_mm: float, lines: list[str]) -> None:
    """Lines of text below one another, all set so small that the longest fits."""
    longest = max(sheet.text_width_mm(line, TEXT_POINTS) for line in lines)
    points = TEXT_POINTS * min(1.0, room_mm / longest)
    for k, line in enumerate(lines):
        sheet.text(middle, first + k * LINE_MM, line, points=points, font=REGULAR)
