"""badge.pdf: the page at true scale, in vectors.

Convention: page mm with the origin top left become PDF points with the origin bottom left, here and nowhere else.
Two forms of the lines, each placed absolutely, so that none drifts:

- "dots": every edge on a border between the printer's dots (`moireid.dots`), drawn a quarter of a dot within it.  A
  raster may paint every dot that is touched, as PDF asks for, go by a dot's centre, or use greys; each then paints the
  same dots.
- "vector": edges at the places that the badge file gives, for a printer or a print shop whose dots are not known.  A
  raster that uses greys keeps them to half a dot.  One that paints every touched dot moves each edge by up to a dot
  outwards: lines are wider, but their centres, and so pitch and identity, stay (`moireid bench fabricate`).

The TrimBox is the board; viewers are asked not to scale.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from moireid.artwork.colours import Colour
from moireid.badge import Badge, Cell, Grating, Lens, Rect
from moireid.dots import nearest_dot
from moireid.errors import SpecError
from moireid.fabrication.page.artwork import (
    CROP_MARK_MM,
    SCALE_BAR_MM,
    bar_places,
    clear_of_bars,
    crop_marks,
    dark_lines,
    font_file,
    lettering_places,
    marker_squares,
)
from moireid.fabrication.page.lettering import (
    LINE_HEIGHT,
    PICTURE_DPI,
    lines_for,
    name_note,
    name_picture,
    printable,
    set_name,
)
from moireid.fabrication.sight import sheet_rects
from moireid.files import whole_file
from moireid.frames import Axis, own_rect
from moireid.profiles import FORMS, Printer

POINTS_PER_MM = 72.0 / 25.4
REGULAR, BOLD = "MoireidSans", "MoireidSans-Bold"
NAME_POINTS = 20.0
SMALL_POINTS = 7.0
HAIRLINE_MM = 0.1
#: Of a badge that does not say how it is printed.
DEFAULT_DPI = 1200
#: Share of a dot by which a line is drawn within its dots, half of what either kind of raster leaves.
INSET_DOTS = 0.25


class PdfPage:
    """A reportlab canvas that takes page millimetres, origin top left.

    scale: drawn over true size along x and y, about the page's middle, which makes up for a printer's own scale;
    dot_mm: the page is made a whole number of such dots high, less than half a dot off, because some rasters count
    from its upper edge and some from its lower.
    """

    def __init__(
        self,
        path: Path,
        page_mm: tuple[float, float],
        title: str,
        scale: tuple[float, float] = (1.0, 1.0),
        dot_mm: float | None = None,
    ) -> None:
        from reportlab.pdfbase import pdfmetrics
        from reportlab.pdfbase.ttfonts import TTFont
        from reportlab.pdfgen.canvas import Canvas

        for name, bold in ((REGULAR, False), (BOLD, True)):
            if name not in pdfmetrics.getRegisteredFontNames():
                pdfmetrics.registerFont(TTFont(name, str(font_file(bold=bold))))
        self.height_mm = round(page_mm[1] / dot_mm) * dot_mm if dot_mm else page_mm[1]
        size = (page_mm[0] * POINTS_PER_MM, self.height_mm * POINTS_PER_MM)
        # invariant leaves out the date, so that the same badge gives the same bytes.
        # Each page begins with a font set, which would else be a Helvetica that the file does not carry.
        # reportlab's stub takes the name for a number.
        begin: Any = {"initialFontName": REGULAR}
        self.canvas = Canvas(str(path), pagesize=size, invariant=True, pageCompression=1, **begin)
        self.canvas.setTitle(title)
        self.canvas.setCreator("moireid")
        self.canvas.setViewerPreference("PrintScaling", "None")
        self.page_mm, self.scale = page_mm, scale
        #: Place on the sheet of the origin of what is drawn, mm: a sheet may hold several boards.
        self.origin_mm = (0.0, 0.0)

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Where a place is drawn, mm, on a sheet that may be scaled and holds what is drawn at `origin_mm`."""
        x, y = x + self.origin_mm[0], y + self.origin_mm[1]
        width, height, across, down = *self.page_mm, *self.scale
        return width / 2 + (x - width / 2) * across, height / 2 + (y - height / 2) * down

    def fill(self, rects: list[Rect], grey: float = 0.0, colour: Colour | None = None) -> None:
        """Fill rectangles as one path, so that those that touch leave no seam; colour: in place of the grey."""
        self.fill_drawn([(*self.place(x0, y0), *self.place(x1, y1)) for x0, y0, x1, y1 in rects], grey, colour)

    def fill_drawn(self, rects: list[Rect], grey: float = 0.0, colour: Colour | None = None) -> None:
        """Fill rectangles that are given as they are drawn, scale included."""
        path: Any = self.canvas.beginPath()
        for x0, y0, x1, y1 in rects:
            path.rect(
                x0 * POINTS_PER_MM,
                (self.height_mm - y1) * POINTS_PER_MM,
                (x1 - x0) * POINTS_PER_MM,
                (y1 - y0) * POINTS_PER_MM,
            )
        if colour is None:
            self.canvas.setFillGray(grey)
        else:
            self.canvas.setFillColorRGB(*colour)
        self.canvas.drawPath(path, stroke=0, fill=1)

    def fill_loops(self, loops: list[list[tuple[float, float]]], grey: float = 0.0) -> None:
        """Fill polygons, given by their corners as they are drawn, scale included, as one path."""
        path: Any = self.canvas.beginPath()
        for corners in loops:
            points = [(x * POINTS_PER_MM, (self.height_mm - y) * POINTS_PER_MM) for x, y in corners]
            path.moveTo(*points[0])
            for point in points[1:]:
                path.lineTo(*point)
            path.close()
        self.canvas.setFillGray(grey)
        self.canvas.drawPath(path, stroke=0, fill=1)

    def picture(self, picture: Image.Image, corner_mm: tuple[float, float], dot_mm: float) -> None:
        """Place a grey picture whose pixels are `dot_mm` wide; corner_mm: its upper left one."""
        from reportlab.lib.utils import ImageReader

        dot = dot_mm * POINTS_PER_MM
        # A raster may count a dot that the picture's border merely touches, and stretch the picture over it.
        inset = 0.05 * dot
        width, height = picture.width * dot, picture.height * dot
        x, y = corner_mm[0] * POINTS_PER_MM, (self.height_mm - corner_mm[1]) * POINTS_PER_MM - height
        reader = ImageReader(picture)
        self.canvas.drawImage(reader, x + inset, y + inset, width - 2 * inset, height - 2 * inset)

    def stroke(self, x0: float, y0: float, x1: float, y1: float, width_mm: float = HAIRLINE_MM) -> None:
        """Draw a black line."""
        (x0, y0), (x1, y1) = self.place(x0, y0), self.place(x1, y1)
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setStrokeGray(0.0)
        self.canvas.line(
            x0 * POINTS_PER_MM,
            (self.height_mm - y0) * POINTS_PER_MM,
            x1 * POINTS_PER_MM,
            (self.height_mm - y1) * POINTS_PER_MM,
        )

    def text(
        self, x: float, y: float, words: str, *, points: float, font: str = REGULAR, align: str = "center"
    ) -> None:
        """Write a line whose baseline is at y."""
        x, y = self.place(x, y)
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

    def turn_page(self, page_mm: tuple[float, float]) -> None:
        """Finish the page, and begin one of that size."""
        self.canvas.showPage()
        self.page_mm, self.height_mm = page_mm, page_mm[1]
        self.canvas.setPageSize((page_mm[0] * POINTS_PER_MM, page_mm[1] * POINTS_PER_MM))

    def save(self) -> None:
        """Finish the page and write the file."""
        self.canvas.showPage()
        self.canvas.save()


def write_badge_pdf(
    badge: Badge,
    path: Path,
    *,
    form: str | None = None,
    measured_scale: tuple[float, float] = (1.0, 1.0),
    write_words: Callable[[PdfPage, Badge], None] | None = None,
) -> None:
    """Write the badge's page, whole or not at all; page 1 is the badge at true scale.

    Parameters
    ----------
    badge : Badge
        What is drawn.
    path : Path
        The PDF; an older file is replaced.
    form : str, optional
        Of the printed lines, one of `moireid.profiles.FORMS`; None for the badge's own.
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.  The page is drawn at the
        inverse scale, so that it is printed at true size.
    write_words : callable, optional
        Writes the words on the board; None for the badge's name and id.

    Raises
    ------
    SpecError
        For another form.

    Notes
    -----
    Convention: page mm with the origin top left become PDF points (1/72 inch) with the origin bottom left.
    Source: "dots" puts every edge on a border between the printer's dots; "vector" keeps the edges of the badge.
    """
    form = form or str((badge.print or {}).get("form", FORMS[0]))
    if form not in FORMS:
        raise SpecError(f"form {form!r} of the page is not known; choose one of {', '.join(FORMS)}")
    with whole_file(path) as temporary:
        scale = (1 / measured_scale[0], 1 / measured_scale[1])
        dot_mm = Printer(int((badge.print or {}).get("dpi", DEFAULT_DPI))).dot_mm
        whole = None if form == "vector" else dot_mm
        sheet = PdfPage(temporary, badge.page_mm, f"Moiré badge {badge.id or badge.name}", scale, whole)
        board = badge.outline_mm
        (x0, y0), (x1, y1) = sheet.place(board[0], board[1]), sheet.place(board[2], board[3])
        trim_mm = (x0, sheet.height_mm - y1, x1, sheet.height_mm - y0)
        sheet.canvas.setTrimBox([v * POINTS_PER_MM for v in trim_mm])
        draw_board(sheet, badge, form, dot_mm, board, write_words)
        draw_scale_bars(sheet, board)
        if badge.lens.kind == "mask":
            sheet.canvas.showPage()
            draw_mask(sheet, badge, form, dot_mm)
        sheet.save()


def draw_board(
    sheet: PdfPage,
    badge: Badge,
    form: str,
    dot_mm: float,
    block: Rect,
    write_words: Callable[[PdfPage, Badge], None] | None = None,
    mark_mm: float = CROP_MARK_MM,
) -> None:
    """Draw all that belongs to one board, its crop marks included.

    Parameters: block: the rectangle around which the sheet's scale bars are drawn, mm on the sheet; write_words: in
        place of name and id; mark_mm: length of the crop marks.
    """
    for grating in badge.gratings:
        draw_lines(sheet, badge, grating, form, dot_mm)
    for square, white in marker_squares(badge):
        sheet.fill([square])
        sheet.fill(white, grey=1.0)
    (write_words or _write_name)(sheet, badge)
    bars, (left, top) = bar_places(sheet.page_mm, block), sheet.origin_mm
    for x0, y0, x1, y1 in crop_marks(badge.outline_mm, mark_mm):
        x0, y0, x1, y1 = clear_of_bars((x0 + left, y0 + top, x1 + left, y1 + top), sheet.page_mm, bars)
        sheet.stroke(x0 - left, y0 - top, x1 - left, y1 - top)


def draw_lines(sheet: PdfPage, badge: Badge, grating: Grating, form: str, dot_mm: float) -> None:
    """Draw all dark lines of a grating of the badge, or over one, in one of the `FORMS`; turned ones as they are.

    Source: a line at an angle to the rows of dots has no border between dots to follow (`moireid.dots.on_dots`).
    """
    lines = [line for cell in grating.cells for line in dark_lines(grating, cell)]
    if not isinstance(grating.axis, str):
        frame = badge.frame_of(grating)
        sheet.fill_loops([[sheet.place(x, y) for x, y in frame.corners_mm(line).tolist()] for line in lines])
        return
    drawn = [(*sheet.place(x0, y0), *sheet.place(x1, y1)) for x0, y0, x1, y1 in lines]
    sheet.fill_drawn(drawn if form == "vector" else [on_dots(line, grating.axis, dot_mm) for line in drawn])


def draw_mask(sheet: PdfPage, badge: Badge, form: str, dot_mm: float, count: int = 1) -> None:
    """The page that is printed on clear film: the mask's lines where each grating lies, with cutting marks.

    Parameters: count: how many badges of one layout the mask is for; each needs a print of the page.

    Drawn about the same places as the badge's page, so that what a printer does to one it does to the other.
    """
    for grating in badge.gratings:
        draw_lines(sheet, badge, mask_grating(badge.lens, grating), form, dot_mm)
    x0, y0, x1, y1 = badge.outline_mm
    centre_x, centre_y = (x0 + x1) / 2, (y0 + y1) / 2
    for left, low, right, high in sheet_rects(badge):
        # The film reaches to the board's edges, where a mount holds it.
        for mark in crop_marks((centre_x + left, centre_y - high, centre_x + right, centre_y - low)):
            sheet.stroke(*mark)
    whose = f"Mask of moiré badge {badge.id}: print" if count == 1 else f"Mask of {count} badges: print {count} times"
    lines = "page 1" if count == 1 else "each badge"
    words = (
        f"{whose} on clear film at 100 %,",
        f"cut along the marks, and lay it, printed side down, on {badge.lens.thickness_mm:g} mm",
        f"of clear acrylic over the lines of {lines}.",
    )
    # Above the lines: on the film, or outside it where the film has no room.
    above = min(badge.bounds_of(grating)[1] for grating in badge.gratings) - y0
    first = y0 + 8 if above > 22 else y0 - 22
    for k, line in enumerate(words):
        sheet.text((x0 + x1) / 2, first + 5 * k, line, points=SMALL_POINTS + 1)
    draw_scale_bars(sheet, badge.outline_mm)


def mask_grating(lens: Lens, grating: Grating) -> Grating:
    """The mask's own lines over one grating, an opening on its middle, as a grating to draw."""
    assert lens.open_fraction is not None
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    edge = (low + high) / 2 + lens.open_fraction / 2 * lens.pitch_mm
    cell = Cell(grating.rect_mm, lens.pitch_mm, edge, 1 - lens.open_fraction)
    return Grating(grating.rect_mm, grating.axis, lens.pitch_mm, "mask", (cell,))


def on_dots(line: Rect, axis: Axis, dot_mm: float) -> Rect:
    """A line with its edges along `axis` on the nearest borders between dots, drawn a quarter of a dot within them."""
    k = 0 if axis == "x" else 1
    edges = list(line)
    begin, end = nearest_dot(np.array([line[k], line[k + 2]]), dot_mm)
    edges[k], edges[k + 2] = (begin + INSET_DOTS) * dot_mm, (max(end, begin + 1) - INSET_DOTS) * dot_mm
    return (edges[0], edges[1], edges[2], edges[3])


def _write_name(sheet: PdfPage, badge: Badge) -> None:
    """The name between the upper markers, the id between the lower ones; a name too long is broken and set smaller."""
    centers, half = lettering_places(badge)
    room_mm = (centers[1][0] - centers[0][0] - 2 * half - 6.0, 2 * half)
    middle = (centers[0][0] + centers[1][0]) / 2
    label = f"moireid {badge.id}"
    # It refuses a name of which nothing can be printed.
    name_note(badge.name)
    name = set_name(badge.name)
    if name.font and not printable(name.words):
        grey = name_picture(name.words, name.font, room_mm, NAME_POINTS, PICTURE_DPI)
        # A printer would screen grey edges into dots of its own.
        picture = grey.point([0] * 128 + [255] * 128)
        x, y = sheet.place(middle, centers[0][1])
        dot_mm = Printer(PICTURE_DPI).dot_mm
        corner = (x - picture.width / 2 * dot_mm, y - picture.height / 2 * dot_mm)
        sheet.picture(picture, corner, dot_mm)
    elif name.words:
        _write_lines(sheet, name.words, (middle, centers[0][1]), room_mm, NAME_POINTS, BOLD)
    _write_lines(sheet, label, (middle, centers[3][1]), room_mm, SMALL_POINTS + 1, REGULAR)


def _write_lines(
    sheet: PdfPage, words: str, middle: tuple[float, float], room_mm: tuple[float, float], points: float, font: str
) -> None:
    """Words about a place, as large as `points` or as their room allows."""
    line_mm = LINE_HEIGHT * points / POINTS_PER_MM
    lines, share = lines_for(words, lambda line: sheet.text_width_mm(line, points, font), room_mm, line_mm)
    for k, line in enumerate(lines):
        # A letter's middle is 0.35 of the size above the baseline.
        down = (k - (len(lines) - 1) / 2) * line_mm * share + 0.35 * points * share / POINTS_PER_MM
        sheet.text(middle[0], middle[1] + down, line, points=points * share, font=font)


def draw_scale_bars(sheet: PdfPage, block: Rect) -> None:
    """A level bar below everything on the sheet, an upright one at its left: `SCALE_BAR_MM` long, ticks every 10 mm."""
    page_mm = sheet.page_mm
    x, y = bar_places(page_mm, block)
    middle_x, middle_y = page_mm[0] / 2, page_mm[1] / 2
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
