"""badge.pdf: the page at true scale, in vectors.

Convention: page mm with the origin top left become PDF points with the origin bottom left, here and nowhere else.
Lines and modules are filled paths with absolute coordinates; a printer's raster rounds each edge for itself, so an
error never adds up.  The TrimBox is the board; viewers are asked not to scale.
"""

from __future__ import annotations

import unicodedata
from pathlib import Path
from typing import Any

from moireid.badge import Badge, Rect
from moireid.fabrication.artwork import SCALE_BAR_MM, crop_marks, dark_lines, font_file, marker_squares
from moireid.files import whole_file

POINTS_PER_MM = 72.0 / 25.4
REGULAR, BOLD = "MoireidSans", "MoireidSans-Bold"
NAME_POINTS = 20.0
SMALL_POINTS = 7.0
HAIRLINE_MM = 0.1


class Sheet:
    """A reportlab canvas that takes page millimetres, origin top left."""

    def __init__(self, path: Path, page_mm: tuple[float, float], title: str) -> None:
        from reportlab.pdfbase import pdfmetrics
        from reportlab.pdfbase.ttfonts import TTFont
        from reportlab.pdfgen.canvas import Canvas

        for name, bold in ((REGULAR, False), (BOLD, True)):
            if name not in pdfmetrics.getRegisteredFontNames():
                pdfmetrics.registerFont(TTFont(name, str(font_file(bold=bold))))
        size = (page_mm[0] * POINTS_PER_MM, page_mm[1] * POINTS_PER_MM)
        # invariant leaves out the date, so that the same badge gives the same bytes.
        self.canvas = Canvas(str(path), pagesize=size, invariant=True, pageCompression=1)
        self.canvas.setTitle(title)
        self.canvas.setCreator("moireid")
        self.canvas.setViewerPreference("PrintScaling", "None")
        self.page_mm, self.height_mm = page_mm, page_mm[1]

    def fill(self, rects: list[Rect], grey: float = 0.0) -> None:
        """Fill rectangles as one path, so that those that touch leave no seam."""
        path: Any = self.canvas.beginPath()
        for x0, y0, x1, y1 in rects:
            path.rect(
                x0 * POINTS_PER_MM, (self.height_mm - y1) * POINTS_PER_MM,
                (x1 - x0) * POINTS_PER_MM, (y1 - y0) * POINTS_PER_MM,
            )  # fmt: skip
        self.canvas.setFillGray(grey)
        self.canvas.drawPath(path, stroke=0, fill=1)

    def stroke(self, x0: float, y0: float, x1: float, y1: float, width_mm: float = HAIRLINE_MM) -> None:
        """Draw a black line."""
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setStrokeGray(0.0)
        self.canvas.line(
            x0 * POINTS_PER_MM, (self.height_mm - y0) * POINTS_PER_MM,
            x1 * POINTS_PER_MM, (self.height_mm - y1) * POINTS_PER_MM,
        )  # fmt: skip

    def text(
        self, x: float, y: float, words: str, *, points: float, font: str = REGULAR, align: str = "center"
    ) -> None:
        """Write a line whose baseline stands at y."""
        self.canvas.setFillGray(0.0)
        self.canvas.setFont(font, points)
        draw = {
            "center": self.canvas.drawCentredString,
            "left": self.canvas.drawString,
            "right": self.canvas.drawRightString,
        }
        draw[align](x * POINTS_PER_MM, (self.height_mm - y) * POINTS_PER_MM, words)

    def text_width_mm(self, words: str, points: float, font: str = REGULAR) -> float:
        """Width of a line of text, mm."""
        return float(self.canvas.stringWidth(words, font, points)) / POINTS_PER_MM

    def save(self) -> None:
        """Finish the page and write the file."""
        self.canvas.showPage()
        self.canvas.save()


def write_badge_pdf(badge: Badge, path: Path) -> None:
    """Write the badge's page, whole or not at all; page 1 is the badge at true scale."""
    with whole_file(path) as temporary:
        sheet = Sheet(temporary, badge.page_mm, f"Moiré badge {badge.id}")
        board = badge.outline_mm
        sheet.canvas.setTrimBox(
            [v * POINTS_PER_MM for v in (board[0], badge.page_mm[1] - board[3], board[2], badge.page_mm[1] - board[1])]
        )
        for grating in badge.gratings:
            for cell in grating.cells:
                sheet.fill(dark_lines(grating, cell))
        for square, white in marker_squares(badge):
            sheet.fill([square])
            sheet.fill(white, grey=1.0)
        _write_name(sheet, badge)
        for mark in crop_marks(board):
            sheet.stroke(*mark)
        _draw_scale_bars(sheet, board)
        sheet.save()


def printable(words: str) -> bool:
    """Whether the badge's font can set the words right: a glyph for every letter, and none read from right to left.

    PDF text is drawn in the order given and unjoined, which would spell Hebrew or Arabic wrong.
    """
    from reportlab.pdfbase.ttfonts import TTFontFile

    glyphs = TTFontFile(str(font_file(bold=True))).charToGlyph
    return all(ord(letter) in glyphs and unicodedata.bidirectional(letter) not in ("R", "AL") for letter in words)


def _write_name(sheet: Sheet, badge: Badge) -> None:
    """The name between the upper markers, the id between the lower ones; a name too long is set smaller."""
    centers, half = badge.markers.centers_mm, badge.markers.size_mm / 2
    room_mm = centers[1][0] - centers[0][0] - 2 * half - 6.0
    middle = (centers[0][0] + centers[1][0]) / 2
    label = f"moireid {badge.id}"
    name = badge.name if printable(badge.name) else label
    points = min(NAME_POINTS, NAME_POINTS * room_mm / sheet.text_width_mm(name, NAME_POINTS, BOLD))
    sheet.text(middle, centers[0][1] + 0.35 * points / POINTS_PER_MM, name, points=points, font=BOLD)
    points = min(SMALL_POINTS + 1, (SMALL_POINTS + 1) * room_mm / sheet.text_width_mm(label, SMALL_POINTS + 1))
    sheet.text(middle, centers[3][1] + 0.35 * points / POINTS_PER_MM, label, points=points)


def _draw_scale_bars(sheet: Sheet, board: Rect) -> None:
    """A bar across below the board and one down beside it, each `SCALE_BAR_MM` long, ticked every 10 mm."""
    # As far from the board as the paper lets them, up to 14 mm; printers leave a rim of 3 to 5 mm white.
    page_mm = sheet.page_mm
    middle_x, y = page_mm[0] / 2, min(board[3] + 14.0, page_mm[1] - 11.5)
    middle_y, x = page_mm[1] / 2, max(board[0] - 14.0, 7.5)
    for k in range(int(SCALE_BAR_MM / 10) + 1):
        tick = 3.0 if k % 5 == 0 else 1.5
        along = 10.0 * k - SCALE_BAR_MM / 2
        sheet.stroke(middle_x + along, y, middle_x + along, y + tick)
        sheet.stroke(x, middle_y + along, x - tick, middle_y + along)
    half = SCALE_BAR_MM / 2
    sheet.stroke(middle_x - half, y, middle_x + half, y)
    sheet.stroke(x, middle_y - half, x, middle_y + half)
    advice = f"Print at 100 % (no “fit to page”). Both bars must measure {SCALE_BAR_MM:.0f} mm."
    sheet.text(middle_x, y + 6.6, advice, points=SMALL_POINTS)
