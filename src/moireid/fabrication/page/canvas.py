"""The canvas of every PDF: page millimetres in, PDF points out.

Convention: page mm with the origin top left become PDF points with the origin bottom left, here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from moireid.artwork.colours import Colour
from moireid.badge import Rect
from moireid.fabrication.text.fonts import plot_fonts
from moireid.fabrication.text.pdf_text import draw_line
from moireid.fabrication.text.shaping import ShapedLine

T = TypeVar("T")
POINTS_PER_MM = 72.0 / 25.4
REGULAR, BOLD = "MoireidSans", "MoireidSans-Bold"
#: Office printers leave up to so much of a page's edge white: all that is printed keeps clear of it, mm.
RIM_MM = 6.0
#: Width of a single line, and of a path's, mm.
HAIRLINE_MM, PATH_LINE_MM = 0.1, 0.15
#: Height of all that one filled path holds, mm.  PDFium drops what comes after 4,194,304 crossings of borders with rows
#: of pixels in a path (1024 blocks of 4096 cells), two a row: 22 m at 2400 dpi.
MOST_PATH_MM = 10_000.0


@cache
def font_file(*, bold: bool = False) -> Path:
    """The font of instructions, which has arrows and signs: the DejaVu Sans that matplotlib ships."""
    return plot_fonts() / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")


def register_fonts() -> None:
    """Give reportlab the files of the fonts `REGULAR` and `BOLD`, and have it write streams as bytes.

    Otherwise it writes them as letters (ASCII85), a quarter longer and in Python, which takes longer than the page.
    """
    from reportlab import rl_config
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    rl_config.useA85 = 0
    for name, bold in ((REGULAR, False), (BOLD, True)):
        if name not in pdfmetrics.getRegisteredFontNames():
            pdfmetrics.registerFont(TTFont(name, str(font_file(bold=bold))))


class PdfPage:
    """A reportlab canvas that takes page millimetres, origin top left.

    scale: drawn over true size along x and y, about the page's middle, which makes up for a printer's own scale;
    dot_mm: the printer's, None where nothing is set on its dots; the page is a whole number of them high, less than
    half a dot off, because some rasters count from its upper edge and some from its lower.
    """

    def __init__(
        self,
        path: Path,
        page_mm: tuple[float, float],
        title: str,
        scale: tuple[float, float] = (1.0, 1.0),
        dot_mm: float | None = None,
    ) -> None:
        from reportlab.pdfgen.canvas import Canvas

        register_fonts()
        self.scale, self.dot_mm = scale, dot_mm
        size = self._measure(page_mm)
        # invariant leaves out the date, so that the same badge gives the same bytes.
        # Each page begins with a font set, which would else be a Helvetica that the file does not carry.
        # reportlab's stub takes the name for a number.
        begin: Any = {"initialFontName": REGULAR}
        self.canvas = Canvas(str(path), pagesize=size, invariant=True, pageCompression=1, **begin)
        self.canvas.setTitle(title)
        self.canvas.setCreator("moireid")
        self.canvas.setViewerPreference("PrintScaling", "None")
        #: Place on the sheet of the origin of what is drawn, mm: a sheet may hold several boards.
        self.origin_mm = (0.0, 0.0)

    def _measure(self, page_mm: tuple[float, float]) -> tuple[float, float]:
        """Take a page's size, and return it in PDF points."""
        self.page_mm, dot_mm = page_mm, self.dot_mm
        self.height_mm = round(page_mm[1] / dot_mm) * dot_mm if dot_mm else page_mm[1]
        return page_mm[0] * POINTS_PER_MM, self.height_mm * POINTS_PER_MM

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Where a place is drawn, mm, on a sheet that may be scaled and holds what is drawn at `origin_mm`."""
        x, y = x + self.origin_mm[0], y + self.origin_mm[1]
        width, height, across, down = *self.page_mm, *self.scale
        return width / 2 + (x - width / 2) * across, height / 2 + (y - height / 2) * down

    def _points(self, x: float, y: float) -> tuple[float, float]:
        """A place as it is drawn, mm, in PDF points."""
        return x * POINTS_PER_MM, (self.height_mm - y) * POINTS_PER_MM

    def _fill_with(self, grey: float, colour: Colour | None) -> None:
        # Printers set black from black ink alone only where it is a grey.
        if colour is None or len(set(colour)) == 1:
            self.canvas.setFillGray(grey if colour is None else colour[0])
        else:
            self.canvas.setFillColorRGB(*colour)

    def fill(self, rects: list[Rect], grey: float = 0.0, colour: Colour | None = None) -> None:
        """Fill rectangles as one path, so that those that touch leave no seam; colour: in place of the grey."""
        self.fill_drawn([(*self.place(x0, y0), *self.place(x1, y1)) for x0, y0, x1, y1 in rects], grey, colour)

    def fill_drawn(self, rects: ArrayLike, grey: float = 0.0, colour: Colour | None = None) -> None:
        """Fill rectangles (n, 4) that are given as they are drawn, scale included."""
        from reportlab.pdfgen.pathobject import PDFPathObject

        rects = np.asarray(rects, float).reshape(-1, 4)
        # From left to right, so that two paths meet where lines have white between them.
        rects = rects[np.argsort(rects[:, 0], kind="stable")]
        x0, y0, x1, y1 = rects.T
        numbers = np.stack([x0, self.height_mm - y1, x1 - x0, y1 - y0], axis=-1) * POINTS_PER_MM
        # Rectangles on a printer's dots share most of their numbers, and each takes a microsecond or more to write.
        distinct, places = np.unique(numbers, return_inverse=True)
        digits = 6 - np.log10(np.maximum(np.abs(distinct), 1.0)).astype(int)
        written = [_written(number, count) for number, count in zip(distinct.tolist(), digits.tolist(), strict=True)]
        columns = [[written[place] for place in column] for column in places.reshape(-1, 4).T.tolist()]
        lines = [f"{x} {y} {wide} {high} re" for x, y, wide, high in zip(*columns, strict=True)]
        self._fill_with(grey, colour)
        for part in _parts(lines, (y1 - y0).tolist()):
            self.canvas.drawPath(PDFPathObject(code=["n", *part]), stroke=0, fill=1)

    def fill_loops(self, loops: Sequence[Sequence[tuple[float, float]]]) -> None:
        """Fill loops in black that do not lie on each other, given as they are drawn, scale included, mm."""
        heights = [max(y for _, y in loop) - min(y for _, y in loop) for loop in loops]
        for first, *others in _parts(loops, heights):
            self.path(first, 0.0, None, holes=others)

    def path(
        self,
        points: Sequence[tuple[float, float]],
        fill: float | None,
        line: float | None,
        *,
        closed: bool = True,
        holes: Iterable[Sequence[tuple[float, float]]] = (),
        dash_mm: float | None = None,
    ) -> None:
        """Draw a path of straight lines, given as it is drawn, scale included, mm.

        Parameters
        ----------
        fill, line : float or None
            Grey of its filling and of its line, 0 to 1; None to leave it out.
        holes : iterable of loops
            Further loops; where two loops lie on each other, nothing is filled.
        dash_mm : float, optional
            Length of a dash of a broken line, mm.
        """
        path: Any = self.canvas.beginPath()
        for loop in (points, *holes):
            for k, (x, y) in enumerate(loop):
                put = path.lineTo if k else path.moveTo
                put(*self._points(x, y))
            if closed:
                path.close()
        if fill is not None:
            self.canvas.setFillGray(fill)
        if line is not None:
            self.canvas.setLineWidth(PATH_LINE_MM * POINTS_PER_MM)
            self.canvas.setLineJoin(1)
            self.canvas.setDash([dash_mm * POINTS_PER_MM] * 2 if dash_mm else [])
            self.canvas.setStrokeGray(line)
        self.canvas.drawPath(path, stroke=int(line is not None), fill=int(fill is not None), fillMode=0)
        if dash_mm:
            self.canvas.setDash([])

    def picture(self, picture: Image.Image, rect: Rect) -> None:
        """Stretch a picture over a rectangle."""
        from reportlab.lib.utils import ImageReader

        (left, low), (right, high) = (
            self._points(*self.place(*place)) for place in ((rect[0], rect[3]), (rect[2], rect[1]))
        )
        self.canvas.drawImage(ImageReader(picture), left, low, right - left, high - low, mask="auto")

    def stroke(self, x0: float, y0: float, x1: float, y1: float, width_mm: float = HAIRLINE_MM) -> None:
        """Draw a black line."""
        (x0, y0), (x1, y1) = self.place(x0, y0), self.place(x1, y1)
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setStrokeGray(0.0)
        self.canvas.line(*self._points(x0, y0), *self._points(x1, y1))

    def text(
        self,
        x: float,
        y: float,
        words: str,
        *,
        points: float,
        font: str = REGULAR,
        align: str = "center",
        colour: Colour | None = None,
    ) -> None:
        """Write a line whose baseline is at y; black, if no colour is given."""
        self._fill_with(0.0, colour)
        self.canvas.setFont(font, points)
        draw = {
            "center": self.canvas.drawCentredString,
            "left": self.canvas.drawString,
            "right": self.canvas.drawRightString,
        }
        draw[align](*self._points(*self.place(x, y)), words)

    def line(self, x: float, y: float, line: ShapedLine, *, points: float, colour: Colour | None = None) -> None:
        """Write a line of glyphs whose baseline begins at a place; black, if no colour is given."""
        self._fill_with(0.0, colour)
        draw_line(self.canvas, line, points, *self._points(*self.place(x, y)))

    def text_width_mm(self, words: str, points: float, font: str = REGULAR) -> float:
        """Width of a line of text, mm."""
        return float(self.canvas.stringWidth(words, font, points)) / POINTS_PER_MM

    def turn_page(self, page_mm: tuple[float, float]) -> None:
        """Finish the page, and begin one of that size."""
        self.canvas.showPage()
        self.canvas.setPageSize(self._measure(page_mm))

    def save(self) -> None:
        """Finish the page and write the file."""
        self.canvas.showPage()
        self.canvas.save()


def _written(number: float, digits: int) -> str:
    """A number as reportlab writes it, in half the time."""
    text = f"{number:.{digits}f}".rstrip("0").rstrip(".").lstrip("0")
    return text or "0"


def _parts(drawn: Sequence[T], heights_mm: Sequence[float]) -> list[list[T]]:
    """What is drawn, in parts that each fit one path (`MOST_PATH_MM`)."""
    parts: list[list[T]] = []
    room_mm = 0.0
    for one, height_mm in zip(drawn, heights_mm, strict=True):
        if not parts or height_mm > room_mm:
            parts.append([])
            room_mm = MOST_PATH_MM
        parts[-1].append(one)
        room_mm -= height_mm
    return parts
