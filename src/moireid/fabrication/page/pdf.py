"""badge.pdf: the page's shapes in mm, and the page at true scale, in vectors.

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

import math
from collections.abc import Callable, Iterable

import numpy as np

from moireid.badge import Badge, Cell, Grating, Lens, Rect
from moireid.dots import INSET_DOTS, ink_growth_mm, nearest_dot
from moireid.fabrication.page.canvas import POINTS_PER_MM, RIM_MM, PdfPage
from moireid.fabrication.page.marks import Mark, draw_marks, marker_marks, marks
from moireid.fabrication.page.pitch_bands import ERRORS, look_m, pitch_bands
from moireid.fabrication.page.smooth_page import draw_smooth_lines
from moireid.fabrication.sight import sheet_rects
from moireid.files import AnyPath, as_path, whole_file
from moireid.frames import Axis, own_rect
from moireid.layers import is_smooth
from moireid.profiles import drawn_dot_mm
from moireid.sheets import MM_PER_INCH

CROP_MARK_MM = 6.0
CROP_GAP_MM = 2.0
#: A bar of 150 mm shows a scale error of 0.3 % as half a millimetre, which a ruler reads; a short one would not.
SCALE_BAR_MM = 150.0
#: Length of the bar's ticks, and height of all of a level one, its words among its ticks, mm.
TICK_MM, BAR_HIGH_MM = 3.0, 4.5
#: Air between a crop mark and a scale bar, mm.
BAR_GAP_MM = 0.5
#: From the end of the level scale bar to the upright one, mm: room for a ruler.
BARS_APART_MM = 8.0
SMALL_POINTS = 7.0


def dark_lines(grating: Grating, cell: Cell, ink_mm: float = 0.0) -> list[Rect]:
    """The dark lines of one cell, cut at its border.

    Parameters: ink_mm: by which the printer widens a line; each is drawn narrower by that, about its middle.
    Convention: lines begin at edge_mm + k pitch_mm along the grating's axis and are duty pitch_mm wide.
    Returns: rectangles as the cell's own is given: page mm, or in the frame of a turned grating (`moireid.frames`).
    Source: each edge is computed from k, never by adding up a rounded pitch, so that nothing drifts.
    """
    low, top, high, bottom = own_rect(grating.axis, cell.rect_mm)
    first = math.floor((low - cell.edge_mm) / cell.pitch_mm)
    last = math.ceil((high - cell.edge_mm) / cell.pitch_mm)
    lines: list[Rect] = []
    for k in range(first, last + 1):
        begin = cell.edge_mm + k * cell.pitch_mm
        start, stop = max(begin, low), min(begin + cell.duty * cell.pitch_mm, high)
        start, stop = start + ink_mm / 2, stop - ink_mm / 2
        if stop - start > 1e-9:
            lines.append(own_rect(grating.axis, (start, top, stop, bottom)))
    return lines


def crop_marks(board: Rect, length_mm: float = CROP_MARK_MM) -> list[tuple[float, float, float, float]]:
    """Eight strokes (x0, y0, x1, y1) outside the corners of the board, along its edges."""
    marks = []
    for x, outward_x in ((board[0], -1), (board[2], 1)):
        for y, outward_y in ((board[1], -1), (board[3], 1)):
            begin, end = CROP_GAP_MM, CROP_GAP_MM + length_mm
            marks.append((x + outward_x * begin, y, x + outward_x * end, y))
            marks.append((x, y + outward_y * begin, x, y + outward_y * end))
    return marks


def bar_places(page_mm: tuple[float, float], block: Rect) -> tuple[float, float]:
    """Where the two scale bars of a sheet are drawn: x of the upright one, y of the level one, mm.

    They are up to 14 mm from everything else on the sheet, as far as the paper and the printer's rim allow.  Around a
    small board the upright one is farther out, clear of the end of the level one.
    """
    clear = page_mm[0] / 2 - SCALE_BAR_MM / 2 - BARS_APART_MM
    x, y = min(block[0] - 14.0, clear), min(block[3] + 14.0, page_mm[1] - RIM_MM - BAR_HIGH_MM)
    return max(x, RIM_MM + TICK_MM), y


def draw_crop_marks(sheet: PdfPage, rect: Rect, block: Rect | None, length_mm: float = CROP_MARK_MM) -> None:
    """Draw crop marks, their outer ends cut off where the printer's rim or a scale bar begins.

    Parameters: block: the rectangle around which the sheet's scale bars are drawn, mm on the sheet; None without bars.
    """
    (left, top), (width, height), reach = sheet.origin_mm, sheet.page_mm, SCALE_BAR_MM / 2 + 1.0
    bar_x, bar_y = bar_places(sheet.page_mm, block) if block else (0.0, height)
    for mark in crop_marks(rect, length_mm):
        (x0, x1), (y0, y1) = (mark[0] + left, mark[2] + left), (mark[1] + top, mark[3] + top)
        least_x = max(RIM_MM, bar_x + BAR_GAP_MM if abs(y0 - height / 2) <= reach else 0.0)
        most_y = min(height - RIM_MM, bar_y - BAR_GAP_MM if abs(x0 - width / 2) <= reach else height)
        x0, x1 = (min(max(x, least_x), width - RIM_MM) - left for x in (x0, x1))
        y0, y1 = (min(max(y, RIM_MM), most_y) - top for y in (y0, y1))
        sheet.stroke(x0, y0, x1, y1)


def write_badge_pdf(
    badge: Badge,
    path: AnyPath,
    *,
    measured_scale: tuple[float, float] = (1.0, 1.0),
    write_words: Callable[[PdfPage, Badge], None] | None = None,
) -> None:
    """Write the badge's page, whole or not at all; page 1 is the badge at true scale.

    Parameters
    ----------
    badge : Badge
        What is drawn.
    path : str or Path
        The PDF; an older file is replaced.
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.  The page is drawn at the
        inverse scale, so that it is printed at true size.
    write_words : callable, optional
        Writes all words on the board, in place of artwork, name and id.

    Raises
    ------
    SpecError
        For a printer or a form of lines that is none.

    Notes
    -----
    Convention: page mm with the origin top left become PDF points (1/72 inch) with the origin bottom left.
    Source: "dots" puts every edge on a border between the printer's dots; "vector" keeps the edges of the badge.
    """
    path = as_path(path)
    with whole_file(path) as temporary:
        scale = (1 / measured_scale[0], 1 / measured_scale[1])
        title = f"Moiré badge {badge.id or badge.name}"
        sheet = PdfPage(temporary, badge.page_mm, title, scale, drawn_dot_mm(badge))
        board = badge.outline_mm
        (x0, y0), (x1, y1) = sheet.place(board[0], board[1]), sheet.place(board[2], board[3])
        trim_mm = (x0, sheet.height_mm - y1, x1, sheet.height_mm - y0)
        sheet.canvas.setTrimBox([v * POINTS_PER_MM for v in trim_mm])
        draw_board(sheet, badge, board, marker_marks(badge) if write_words else marks(badge))
        if write_words:
            write_words(sheet, badge)
        draw_scale_bars(sheet, board, badge.range_m)
        drawn = write_words is not None or draw_bands(sheet, badge, board)
        if badge.lens.kind == "mask":
            draw_mask(sheet, badge)
        if not drawn:
            draw_bands_alone(sheet, badge)
        sheet.save()


def draw_board(
    sheet: PdfPage,
    badge: Badge,
    block: Rect,
    found: Iterable[Mark],
    mark_mm: float = CROP_MARK_MM,
) -> None:
    """Draw all that belongs to one board, its crop marks included.

    Parameters: block: the rectangle around which the sheet's scale bars are drawn, mm on the sheet; found: all marks
        of the board; mark_mm: length of the crop marks.
    """
    for grating in badge.gratings:
        draw_lines(sheet, badge, grating, ink_growth_mm(badge))
    draw_marks(sheet, found)
    draw_crop_marks(sheet, badge.outline_mm, block, mark_mm)


def draw_lines(sheet: PdfPage, badge: Badge, grating: Grating, ink_mm: float = 0.0) -> None:
    """Draw all dark lines of a grating of the badge, or over one, on the sheet's dots if it has any.

    Parameters: ink_mm: as for `dark_lines`.  It is measured on paper, so the mask on clear film goes without.

    Source: a line at an angle to the rows of dots has no border between dots to follow (`moireid.dots.on_dots`).
    """
    if is_smooth(grating):
        draw_smooth_lines(sheet, badge.frame_of(grating), grating, ink_mm)
        return
    lines = [line for cell in grating.cells for line in dark_lines(grating, cell, ink_mm)]
    if not isinstance(grating.axis, str):
        frame = badge.frame_of(grating)
        sheet.fill_loops([[sheet.place(x, y) for x, y in frame.corners_mm(line).tolist()] for line in lines])
        return
    draw_upright(sheet, lines, grating.axis)


def draw_upright(sheet: PdfPage, lines: Iterable[Rect], axis: Axis) -> None:
    """Fill lines that are upright or level, each at its place along `axis`; on the sheet's dots if it has any."""
    drawn, dot_mm = [(*sheet.place(x0, y0), *sheet.place(x1, y1)) for x0, y0, x1, y1 in lines], sheet.dot_mm
    sheet.fill_drawn(drawn if dot_mm is None else [on_dots(line, axis, dot_mm) for line in drawn])


def draw_bands(sheet: PdfPage, badge: Badge, board: Rect) -> bool:
    """Draw the pitch bands with their labels above a board on the sheet; False, and nothing, where there is no room."""
    bands = pitch_bands(badge, board)
    if bands is None:
        return False
    draw_lines(sheet, badge, bands, ink_growth_mm(badge))
    for cell, error in zip(bands.cells, ERRORS, strict=True):
        x0, y0, x1, y1 = cell.rect_mm
        baseline, lines_per_inch = (y0 + y1) / 2 + 0.9, MM_PER_INCH / badge.lens.pitch_mm / (1 + error)
        signed = f"{100 * error:+.0f} %".replace("-", "−") if error else "0"
        sheet.text(x0 - 1.5, baseline, signed, points=SMALL_POINTS, align="right")
        sheet.text(x1 + 1.5, baseline, f"{lines_per_inch:.1f} LPI", points=SMALL_POINTS, align="left")
    what = "film and acrylic" if badge.lens.kind == "mask" else "the uncut lens sheet, ribs up and upright"
    words = f"First lay {what}, here. From {look_m(badge):g} m the band without stripes shows its pitch; 0 is right."
    sheet.text(sheet.page_mm[0] / 2, bands.rect_mm[1] - 1.5, words, points=SMALL_POINTS)
    return True


def draw_bands_alone(sheet: PdfPage, badge: Badge) -> None:
    """A page with the pitch bands alone, for boards that leave them no room."""
    sheet.turn_page(badge.page_mm)
    x0, _, x1, _ = badge.outline_mm
    middle = sheet.page_mm[0] / 2
    draw_bands(sheet, badge, (middle - (x1 - x0) / 2, sheet.page_mm[1] / 2, middle + (x1 - x0) / 2, 0.0))
    draw_scale_bars(sheet, badge.outline_mm)


def draw_mask(sheet: PdfPage, badge: Badge, count: int = 1) -> None:
    """The page that is printed on clear film: the mask's lines where each grating lies, with cutting marks.

    Parameters: count: how many badges of one layout the mask is for; each needs a print of the page.

    Drawn about the same places as the badge's page, so that what a printer does to one it does to the other.
    """
    sheet.turn_page(badge.page_mm)
    for grating in badge.gratings:
        draw_lines(sheet, badge, mask_grating(badge.lens, grating))
    x0, y0, x1, y1 = badge.outline_mm
    centre_x, centre_y = (x0 + x1) / 2, (y0 + y1) / 2
    for left, low, right, high in sheet_rects(badge):
        # The film reaches to the board's edges, where a mount holds it.
        draw_crop_marks(sheet, (centre_x + left, centre_y - high, centre_x + right, centre_y - low), badge.outline_mm)
    whose = f"Mask of moiré badge {badge.id}: print" if count == 1 else f"Mask of {count} badges: print {count} times"
    lines = "page 1" if count == 1 else "each badge"
    words = (
        f"{whose} on clear film at 100 %,",
        f"cut along the marks, and lay it, printed side down, on {badge.lens.thickness_mm:g} mm",
        f"of clear acrylic over the lines of {lines}.",
    )
    # Above the lines: on the film, or outside it where the film has no room.
    above = min(badge.bounds_of(grating)[1] for grating in badge.gratings) - y0
    first = y0 + 8 if above > 22 else max(y0 - 22, RIM_MM + 3)
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


def draw_scale_bars(sheet: PdfPage, block: Rect, range_m: tuple[float, float] | None = None) -> None:
    """A level bar below everything on the sheet, an upright one at its left: `SCALE_BAR_MM` long, ticks every 10 mm.

    Parameters: range_m: from how far a phone films the badge, m, which is then written too.
    """
    (width, height), (x, y) = sheet.page_mm, bar_places(sheet.page_mm, block)
    middle_x, middle_y, half = width / 2, height / 2, SCALE_BAR_MM / 2
    for k in range(int(SCALE_BAR_MM / 10) + 1):
        tick = TICK_MM if k % 5 == 0 else TICK_MM / 2
        along = 10.0 * k - half
        sheet.stroke(middle_x + along, y, middle_x + along, y + tick)
        sheet.stroke(x, middle_y + along, x - tick, middle_y + along)
    sheet.stroke(middle_x - half, y, middle_x + half, y)
    sheet.stroke(x, middle_y - half, x, middle_y + half)
    words = ["Print at 100 % (no “fit to page”).", f"Both bars must measure {SCALE_BAR_MM:.0f} mm."]
    if range_m is not None and range_m[0] < range_m[1]:
        words.append("A phone films it from {:g} to {:g} m.".format(*range_m))
    for k, line in enumerate(words):
        sheet.text(middle_x + 50.0 * (k - 1), y + 3.9, line, points=SMALL_POINTS)
