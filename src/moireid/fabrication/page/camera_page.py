"""camera-chart.pdf: the board that a camera is calibrated with, and how to film it."""

from __future__ import annotations

from pathlib import Path

from moireid.camera_chart import COLUMNS, ROWS, SQUARE_MM, chart_board
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.page.marks import runs_mm
from moireid.files import planned, whole_file
from moireid.profiles import PAPERS_MM

#: Modules along a marker, its border among them.
MODULES = 7
TEXT_POINTS, LINE_MM = 8.0, 3.8
WORDS = (
    "Glue this chart to something flat, such as glass. Film it for 20 seconds in even light, from all sides and from "
    "near",
    "to far, in every corner of the picture; hold still for a moment each time. Then: moireid calibrate FILM "
    "--camera --out camera.yaml",
)


def print_camera_chart(path: Path, paper: str, *, overwrite: bool = False) -> None:
    """Write the chart for a paper of `profiles.PAPERS_MM`.  Raises: SpecError where the file is in the way."""
    planned([path], overwrite=overwrite)
    width, height = PAPERS_MM[paper]
    # A marker is three quarters of a square wide, in the middle of it: both are whole numbers of this part.
    part = SQUARE_MM / 8 / MODULES
    picture = chart_board().generateImage((COLUMNS * 8 * MODULES, ROWS * 8 * MODULES))
    left, top = (width - COLUMNS * SQUARE_MM) / 2, (height - ROWS * SQUARE_MM) / 2 - LINE_MM
    black = runs_mm(picture < 128, (left, top), part)
    with whole_file(path) as new:
        page = PdfPage(new, (width, height), "Camera chart")
        page.fill(black)
        for k, words in enumerate(WORDS):
            page.text(width / 2, top + ROWS * SQUARE_MM + (k + 1.5) * LINE_MM, words, points=TEXT_POINTS)
        page.save()
