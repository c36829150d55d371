"""Writes assembly.pdf, the instructions for building a badge, or all badges of a list.

Page 1 shows the parts of each way to build it, what to have and how to print; page 2 the steps, a picture each.  The
pieces of lens sheet follow in true size.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from moireid.badge import Badge, Point, Rect
from moireid.fabrication.assembly import assembly_words
from moireid.fabrication.assembly.assembly_words import BuildPlan, Step
from moireid.fabrication.assembly.exploded import Part, Piece, box_loop, draw_exploded, plain_parts
from moireid.fabrication.assembly.sketches import stripes
from moireid.fabrication.page.canvas import BOLD, POINTS_PER_MM, REGULAR, RIM_MM, PdfPage
from moireid.fabrication.page.lettering import set_name
from moireid.fabrication.page.pdf import draw_crop_marks
from moireid.fabrication.sight import piece_sizes
from moireid.fabrication.text.shaping import shape_line
from moireid.files import whole_file
from moireid.profiles import PAPERS_MM

if TYPE_CHECKING:
    from reportlab.platypus import Paragraph, Table


#: Solids as they are drawn, by "printed" or "acrylic", and by their names.
DrawnMounts = dict[str, dict[str, Piece]]
LEFT_MM, TOP_MM, POINTS, INDENT_POINTS = 18.0, 22.0, 8.0, 10.5
#: Above a heading, and below a paragraph, points.
ABOVE_POINTS, BELOW_POINTS = 6.0, 2.0
#: Between columns, between rows of steps, and below the words, mm.
COLUMN_GAP_MM, ROW_GAP_MM, FOOT_MM = 8.0, 5.0, 10.0
#: Steps in a row; a step's picture is at most so high, and at least, mm.
STEPS_ACROSS, PICTURE_MM = 3, (14.0, 42.0)
#: A name that is wider is set smaller, mm.
NAME_MM = 150.0
#: On the plate: gap between pieces, distance of the lines that sketch lenses, and length of the scale bar.
GAP_MM, LENSES_MM, SCALE_MM = 14.0, 6.0, 100.0
#: Height of the words above the pieces, and with that of the scale below, mm.
HEAD_MM, ROOM_MM = 27.0, 51.0
#: Length of the ticks at a piece's corners, mm.
TICK_MM = 4.0


def write_assembly_pdf(build: BuildPlan, path: Path, drawn: DrawnMounts) -> None:
    """Write the sheet of parts and steps, whole or not at all.

    Parameters: drawn: the solids of "printed" and "acrylic" as they are drawn.
    """
    badge = build.badge
    views = _views(build, drawn)
    paper_mm = PAPERS_MM["letter" if (badge.print or {}).get("paper") == "letter" else "a4"]
    with whole_file(path) as temporary:
        title = "Assembly of moiré badges" if build.for_all else f"Assembly of moiré badge {badge.id}"
        sheet = PdfPage(temporary, paper_mm, title)
        _draw_parts(sheet, build, views)
        sheet.canvas.showPage()
        _draw_steps(sheet, assembly_words.steps(build))
        if badge.lens.kind != "mask":
            _draw_plates(sheet, badge)
        sheet.save()


def _draw_parts(sheet: PdfPage, build: BuildPlan, views: list[tuple[str, list[Part]]]) -> None:
    """The first page: whose badge, its parts pulled apart, what to have, and what to set."""
    right = sheet.page_mm[0] - LEFT_MM
    if build.for_all:
        sheet.text(LEFT_MM, TOP_MM, "How to build these badges", points=16, font=BOLD, align="left")
    else:
        # As the badge itself is lettered.
        line = shape_line(set_name(build.badge.name)[0], bold=True)
        sheet.line(LEFT_MM, TOP_MM, line, points=min(18.0, NAME_MM * POINTS_PER_MM / max(line.width_em, 1e-9)))
        sheet.text(LEFT_MM, TOP_MM + 6, f"How to build this badge · moireid {build.badge.id}", points=9, align="left")
    need = _listed("You need", assembly_words.needs(build))
    settings = _listed("Print settings", assembly_words.settings(build))
    columns, parts = [need, settings], build.parts
    if parts.acrylic:
        instead = "The mount" if parts.printed == "none" else "Or, in place of the printed mount"
        columns = [need + settings, _listed(f"{instead}, in acrylic", assembly_words.acrylic(parts.acrylic))]
    words = _side_by_side(columns, (right - LEFT_MM - COLUMN_GAP_MM) / 2)
    words_top = sheet.page_mm[1] - FOOT_MM - words.wrapOn(sheet.canvas, 0, 0)[1] / POINTS_PER_MM
    words.drawOn(sheet.canvas, LEFT_MM * POINTS_PER_MM, FOOT_MM * POINTS_PER_MM)
    each = (right - LEFT_MM - COLUMN_GAP_MM * (len(views) - 1)) / len(views)
    for k, (heading, shown) in enumerate(views):
        x = LEFT_MM + k * (each + COLUMN_GAP_MM)
        sheet.text(x, TOP_MM + 14, heading, points=10.5, font=BOLD, align="left")
        draw_exploded(sheet, shown, (x, TOP_MM + 19, x + each, words_top - 6))


def _listed(heading: str, lines: Sequence[str]) -> list[Paragraph]:
    """A heading with its list."""
    return [_paragraph(heading, bold=True), *(_paragraph(line, bullet="•") for line in lines)]


def _paragraph(text: str, *, bold: bool = False, bullet: str = "") -> Paragraph:
    """A heading, or a paragraph; bullet: left of it, and the paragraph is then indented."""
    from reportlab.lib.styles import ParagraphStyle
    from reportlab.platypus import Paragraph

    points, before, after = (POINTS + 2.0, ABOVE_POINTS, 3.0) if bold else (POINTS, 0.0, BELOW_POINTS)
    style = ParagraphStyle("", fontName=BOLD if bold else REGULAR, fontSize=points, leading=1.3 * points)
    style.spaceBefore, style.spaceAfter, style.leftIndent = before, after, INDENT_POINTS if bullet else 0.0
    style.bulletFontName, style.bulletFontSize = REGULAR, points
    return Paragraph(escape(text), style, bulletText=bullet or None)


def _side_by_side(columns: Sequence[Sequence[Paragraph]], wide_mm: float) -> Table:
    """Columns of that width, each of paragraphs below each other."""
    from reportlab.platypus import Table

    style = {"LEFTPADDING": 0.0, "RIGHTPADDING": COLUMN_GAP_MM * POINTS_PER_MM, "VALIGN": "TOP"}
    # A cell leaves out what its first paragraph has above it and its last one below.
    style |= {"TOPPADDING": ABOVE_POINTS, "BOTTOMPADDING": BELOW_POINTS}
    commands = [(name, (0, 0), (-1, -1), value) for name, value in style.items()]
    return Table([list(columns)], (wide_mm + COLUMN_GAP_MM) * POINTS_PER_MM, style=commands)


def _draw_steps(sheet: PdfPage, found: list[Step]) -> None:
    """The page of steps, each below its picture."""
    width, height = sheet.page_mm
    sheet.text(LEFT_MM, TOP_MM - 4, "Step by step", points=16, font=BOLD, align="left")
    wide = (width - 2 * LEFT_MM - COLUMN_GAP_MM * (STEPS_ACROSS - 1)) / STEPS_ACROSS
    words = [
        [_paragraph(f"{k}.  {title}", bold=True), _paragraph(text)] for k, (title, text, _) in enumerate(found, start=1)
    ]
    firsts = range(0, len(found), STEPS_ACROSS)
    rows = [_side_by_side(words[k : k + STEPS_ACROSS], wide) for k in firsts]
    needed = [row.wrapOn(sheet.canvas, 0, 0)[1] / POINTS_PER_MM for row in rows]
    # The pictures share what the words leave.
    least, most = PICTURE_MM
    tall = min(most, max(least, (height - TOP_MM - FOOT_MM - sum(needed)) / len(rows) - ROW_GAP_MM))
    top = TOP_MM + 2
    for k, row, words_mm in zip(firsts, rows, needed, strict=True):
        for column, (_, _, draw) in enumerate(found[k : k + STEPS_ACROSS]):
            x = LEFT_MM + column * (wide + COLUMN_GAP_MM)
            draw(sheet, (x, top, x + wide, top + tall))
        top += tall + words_mm
        row.drawOn(sheet.canvas, LEFT_MM * POINTS_PER_MM, (sheet.height_mm - top) * POINTS_PER_MM)
        top += ROW_GAP_MM


def _views(build: BuildPlan, drawn: DrawnMounts) -> list[tuple[str, list[Part]]]:
    """The exploded views, one for each way to build the badge: heading and parts."""
    views, made, figures = [], build.parts, build.parts.figures
    if made.mount_plan is None and made.acrylic is None:
        return [("The parts", plain_parts(build.badge, figures.printed))]
    from moireid.fabrication.assembly.mount_views import acrylic_parts, printed_parts

    if made.mount_plan is not None:
        parts = printed_parts(build.badge, made.mount_plan, figures.printed, drawn["printed"])
        views.append(("The parts, with the printed mount", parts))
    if made.acrylic:
        screw = f"M3 × {assembly_words.screw_length_mm(made.acrylic)}"
        parts = acrylic_parts(build.badge, made.acrylic, figures.acrylic.film_mm, screw, drawn["acrylic"])
        views.append(("The parts, with the mount in acrylic", parts))
    return views


def pieces(badge: Badge) -> list[tuple[str, Point]]:
    """The pieces of a badge's sheet: a name that says how many are cut, and width and length as in `piece_sizes`."""
    sizes = piece_sizes(badge)
    names = [f"piece {letter}" for letter in "ABCDEFGH"] if len(sizes) > 1 else ["the piece"]
    found = zip(names, sizes.items(), strict=False)
    return [(name if count == 1 else f"{name}: cut {count}", size) for name, (size, count) in found]


def placed(found: list[tuple[str, Point]], room: Rect) -> list[list[tuple[str, Rect]]]:
    """Pages of pieces by name and rectangle: from left to right, then below, in a room of the page, mm."""
    pages: list[list[tuple[str, Rect]]] = [[]]
    x, y, low = room[0], room[1], room[1]
    for name, (wide, tall) in found:
        if x > room[0] and x + wide > room[2]:
            x, y = room[0], low + GAP_MM
        if pages[-1] and y + tall > room[3]:
            pages.append([])
            x, y, low = room[0], room[1], room[1]
        pages[-1].append((name, (x, y, x + wide, y + tall)))
        x, low = x + wide + GAP_MM, max(low, y + tall)
    return pages


def _draw_plates(sheet: PdfPage, badge: Badge) -> None:
    """Draw the pages of the plate, each begun anew."""
    found = pieces(badge)
    widest, tallest = (max(size[k] for _, size in found) for k in (0, 1))
    papers = [page for paper_mm in (sheet.page_mm, badge.page_mm) for page in (paper_mm, paper_mm[::-1])]
    room = [page for page in papers if widest <= page[0] - 2 * RIM_MM and tallest <= page[1] - TOP_MM - ROOM_MM]
    width, height = room[0] if room else badge.page_mm
    # A piece as wide as the paper's printable part takes the room of the margins too.
    left = max(RIM_MM, min(LEFT_MM, (width - widest) / 2))
    for page in placed(found, (left, TOP_MM + HEAD_MM, width - RIM_MM, height - ROOM_MM + HEAD_MM)):
        sheet.turn_page((width, height))
        sheet.text(LEFT_MM, TOP_MM, "The lens sheet, in true size", points=16, font=BOLD, align="left")
        lines = (
            "Print at 100 %. Lay the sheet on this page, ribs up, so that its ribs run as the thin lines do. Mark it",
            "where the ticks beyond it point. Along the ribs score in a groove, and bend; across them cut at a steel",
            "ruler, square to the ribs. Measure across: no wider than here, and at most 0.2 mm narrower.",
        )
        for k, line in enumerate(lines):
            sheet.text(LEFT_MM, TOP_MM + 7 + 5 * k, line, points=9, align="left")
        for name, rect in page:
            _draw_piece(sheet, name, rect)
        _scale(sheet, LEFT_MM, height - 14)


def _draw_piece(sheet: PdfPage, name: str, rect: Rect) -> None:
    """A piece's outline, its lenses sketched, and its name."""
    left, top, right, low = rect
    # Lenses part the width evenly, about `LENSES_MM` apart.
    stripes(sheet, box_loop(rect), LENSES_MM, 0.8)
    sheet.path(box_loop((left, low, right, top)), None, 0.0, dash_mm=2.0)
    # The sheet hides its outline, and so the marks are beyond it.
    draw_crop_marks(sheet, rect, None, TICK_MM)
    words = f"{name}, {right - left:.1f} × {low - top:.1f} mm"
    x, y = (left + right) / 2, (top + low) / 2
    half = sheet.text_width_mm(words, 10) / 2 + 2
    if half * 2 < right - left:
        sheet.path(box_loop((x - half, y - 6, x + half, y + 3)), 1.0, None)
        sheet.text(x, y, words, points=10)
    else:
        sheet.text(left + 1, low + 5, words, points=8, align="left")


def _scale(sheet: PdfPage, x: float, y: float) -> None:
    sheet.stroke(x, y, x + SCALE_MM, y, 0.25)
    for k in range(11):
        sheet.stroke(x + 10 * k, y, x + 10 * k, y - (3 if k % 5 == 0 else 1.5), 0.2)
    sheet.text(x + SCALE_MM + 4, y, "must measure 100 mm", points=8, align="left")
