"""Writes assembly.pdf, the instructions for building one badge.

Page 1 says whose badge it is, what to have and how to print.  Then come the steps with a picture each, the pieces of
lens sheet in true size, and an exploded view of each way to build the badge.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.badge import Badge, Point, Rect
from moireid.fabrication.assembly import assembly_words
from moireid.fabrication.assembly.assembly_words import BuildPlan, Step
from moireid.fabrication.assembly.exploded import Part, Piece, draw_exploded, plain_parts
from moireid.fabrication.page.canvas import BOLD, POINTS_PER_MM, REGULAR, PdfPage
from moireid.fabrication.page.lettering import set_name
from moireid.fabrication.page.pdf import crop_marks
from moireid.fabrication.sight import sheet_pieces
from moireid.fabrication.text.shaping import shape_line
from moireid.files import whole_file
from moireid.profiles import PAPERS_MM

if TYPE_CHECKING:
    from moireid.fabrication.solid_parts import SolidPart

#: Solids as they are drawn, by "printed" or "acrylic", and by their names.
DrawnMounts = dict[str, dict[str, Piece]]
LEFT_MM, TOP_MM, LINE_MM, POINTS = 22.0, 28.0, 4.6, 9.0
#: A step's picture, and the room between steps.
PICTURE_MM, STEP_GAP_MM, MOST_STEP_MM = 42.0, 5.0, 29.0
#: From a step's top to the first baseline of its words.
TITLE_MM = 10.0
#: A name that is wider is set smaller, mm.
NAME_MM = 150.0
#: The section is drawn so many times life size.
STACK_SCALE = 12.0
#: On the plate: gap between pieces, distance of the lines that sketch lenses, and length of the scale bar.
GAP_MM, LENSES_MM, SCALE_MM = 14.0, 6.0, 100.0
#: Length of the ticks at a piece's corners, mm.
TICK_MM = 4.0
#: What printers leave white around a page; a piece wider than what is left lies on the paper turned, mm.
RIM_MM = 6.0


def write_assembly_pdf(build: BuildPlan, path: Path, drawn: DrawnMounts) -> None:
    """Write the sheet of parts and steps, whole or not at all.

    Parameters: drawn: the solids of "printed" and "acrylic" as they are drawn, by `draw_mounts`.
    """
    badge = build.badge
    views = _views(build, drawn)
    paper_mm = PAPERS_MM.get(str((badge.print or {}).get("paper", "a4")), PAPERS_MM["a4"])
    with whole_file(path) as temporary:
        sheet = PdfPage(temporary, paper_mm, f"Assembly of moiré badge {badge.id}")
        _draw_lists(sheet, build)
        sheet.canvas.showPage()
        _draw_steps(sheet, assembly_words.steps(build))
        if badge.lens.kind != "mask":
            draw_plates(sheet, badge, LEFT_MM, TOP_MM)
        for heading, view in views:
            sheet.turn_page(paper_mm)
            _draw_view(sheet, heading, view)
        sheet.save()


def _draw_lists(sheet: PdfPage, build: BuildPlan) -> None:
    """The first page: whose badge, what to have, what to set, and a section through the stack."""
    badge, right = build.badge, sheet.page_mm[0] - LEFT_MM
    _draw_name(sheet, badge.name)
    sheet.text(LEFT_MM, TOP_MM + 7, f"How to build this badge · moireid {badge.id}", points=POINTS, align="left")
    y = TOP_MM + 19
    lists = [("You need", assembly_words.needs(build))]
    if build.acrylic:
        heading = "The mount, in acrylic" if build.mount == "none" else "Or, instead of the printed mount, in acrylic"
        lists.append((heading, assembly_words.acrylic(build.acrylic)))
    for heading, lines in lists:
        y = _heading(sheet, heading, y)
        for line in lines:
            sheet.text(LEFT_MM + 1, y, "•", points=POINTS, align="left")
            y = paragraph(sheet, line, (LEFT_MM + 5, y), right - LEFT_MM - 5) + 1.4
        y += 5
    y = _heading(sheet, "Print settings", y)
    for name, value in assembly_words.settings(build):
        sheet.text(LEFT_MM + 1, y, name, points=POINTS, font=BOLD, align="left")
        y = paragraph(sheet, value, (LEFT_MM + 30, y), right - LEFT_MM - 30) + 1.4
    if (note := assembly_words.glue_note(build)) is not None:
        y = paragraph(sheet, note, (LEFT_MM + 1, y + 3), right - LEFT_MM) + 1.4
    if y + 16 + badge.lens.thickness_mm * STACK_SCALE < sheet.page_mm[1] - 14:
        y = _heading(sheet, "The finished badge, cut open", y + 5)
        draw_stack(sheet, badge, y - 6)


def _draw_name(sheet: PdfPage, name: str) -> None:
    """Whose badge it is, as the badge itself is lettered."""
    line = shape_line(set_name(name).words, bold=True)
    points = min(18.0, NAME_MM * POINTS_PER_MM / max(line.width_em, 1e-9))
    sheet.line(LEFT_MM, TOP_MM, line, points=points)


def _heading(sheet: PdfPage, heading: str, y: float) -> float:
    """Write a heading, and give where what follows begins."""
    sheet.text(LEFT_MM, y, heading, points=12, font=BOLD, align="left")
    return y + 7.0


def paragraph(sheet: PdfPage, text: str, corner: tuple[float, float], width_mm: float, points: float = POINTS) -> float:
    """Write words in lines of at most that width from a corner, the first baseline's; give the next baseline's y."""
    x, y = corner
    for line in _lines(text, width_mm, points):
        sheet.text(x, y, line, points=points, align="left")
        y += LINE_MM * points / POINTS
    return y


def _lines(text: str, width_mm: float, points: float) -> list[str]:
    """Words in lines of at most that width."""
    from reportlab.lib.utils import simpleSplit

    return list(simpleSplit(text, REGULAR, points, width_mm * POINTS_PER_MM))


def _draw_steps(sheet: PdfPage, found: list[Step]) -> None:
    """The page of steps, each with its picture at the left."""
    width, height = sheet.page_mm
    sheet.text(LEFT_MM, TOP_MM - 6, "Step by step", points=16, font=BOLD, align="left")
    top, x = TOP_MM, LEFT_MM + PICTURE_MM + 7
    # Each step has the room of its words, and an even share of what is left.
    needed = [TITLE_MM + LINE_MM * len(_lines(step.words, width - LEFT_MM - x, POINTS)) for step in found]
    spare = (height - TOP_MM - 12 - sum(needed)) / len(found)
    for number, (step, words_mm) in enumerate(zip(found, needed, strict=True), start=1):
        tall = max(words_mm, min(MOST_STEP_MM, words_mm + spare))
        step.draw(sheet, (LEFT_MM, top, LEFT_MM + PICTURE_MM, top + tall - STEP_GAP_MM))
        sheet.text(x, top + 4.5, f"{number}.  {step.title}", points=10.5, font=BOLD, align="left")
        paragraph(sheet, step.words, (x, top + TITLE_MM), width - LEFT_MM - x)
        top += tall


def draw_mounts(solids: Mapping[str, Sequence[SolidPart]]) -> DrawnMounts:
    """The solids of "printed" and "acrylic" as they are drawn in the exploded views."""
    from moireid.fabrication.assembly.solid_views import drawn_solids

    return {shop: drawn_solids(parts) for shop, parts in solids.items()}


def _views(build: BuildPlan, drawn: DrawnMounts) -> list[tuple[str, list[Part]]]:
    """The exploded views, one for each way to build the badge: heading and parts."""
    views, figures = [], build.figures
    if build.mount_plan is None and build.acrylic is None:
        return [("Exploded view", plain_parts(build.badge, figures.printed))]
    from moireid.fabrication.assembly.mount_views import acrylic_parts, printed_parts

    if build.mount_plan is not None:
        parts = printed_parts(build.badge, build.mount_plan, figures.printed, drawn["printed"])
        views.append(("Exploded view: the printed mount", parts))
    if build.acrylic:
        screw = f"M3 × {assembly_words.screw_length_mm(build.acrylic)}"
        parts = acrylic_parts(build.badge, build.acrylic, figures.acrylic.film_mm, screw, drawn["acrylic"])
        views.append(("Exploded view: the mount in acrylic", parts))
    return views


def _draw_view(sheet: PdfPage, heading: str, parts: list[Part]) -> None:
    width, height = sheet.page_mm
    sheet.text(LEFT_MM, TOP_MM, heading, points=16, font=BOLD, align="left")
    scale = draw_exploded(sheet, parts, (LEFT_MM, TOP_MM + 18, width - LEFT_MM, height - TOP_MM))
    caption = (
        f"Parts to one scale, {scale:.2f} of life size, pulled apart from front (top) to back; bottom edge near you."
    )
    sheet.text(LEFT_MM, TOP_MM + 8, caption, points=9, align="left")


def draw_stack(sheet: PdfPage, badge: Badge, top_mm: float) -> None:
    """A section through the stack, 12 times life size, with the true radius and pitches."""
    scale, lens = STACK_SCALE, badge.lens
    left, width = LEFT_MM + 4, 10 * lens.pitch_mm * scale
    page_y = top_mm + 8 + lens.thickness_mm * scale
    if lens.kind == "mask":
        shut = 1 - (lens.open_fraction or 0.0)
        pitch = lens.pitch_mm * scale
        sheet.fill([(left + k * pitch, top_mm + 7, left + (k + shut) * pitch, top_mm + 8) for k in range(10)])
        for y in (top_mm + 8, page_y):
            sheet.stroke(left, y, left + width, y, 0.2)
        for x in (left, left + width):
            sheet.stroke(x, top_mm + 8, x, page_y, 0.2)
    for k in range(0 if lens.kind == "mask" else 10):
        assert lens.radius_mm is not None
        axis = left + (k + 0.5) * lens.pitch_mm * scale
        points = [(step / 10 - 0.5) * lens.pitch_mm for step in range(11)]
        sags = [lens.radius_mm - (lens.radius_mm**2 - x**2) ** 0.5 for x in points]
        for i in range(10):
            sheet.stroke(
                axis + points[i] * scale,
                top_mm + 8 + sags[i] * scale,
                axis + points[i + 1] * scale,
                top_mm + 8 + sags[i + 1] * scale,
                0.2,
            )
    cell = badge.gratings[0].cells[0]
    lines = int(10 * lens.pitch_mm / cell.pitch_mm)
    sheet.fill(
        [
            (left + k * cell.pitch_mm * scale, page_y, left + (k + cell.duty) * cell.pitch_mm * scale, page_y + 1.2)
            for k in range(lines)
        ]
    )
    sheet.stroke(left, page_y, left + width, page_y, 0.2)
    front = "printed film on acrylic" if lens.kind == "mask" else "lens sheet, lenses towards the viewer"
    sheet.text(left + width + 4, top_mm + 8 + lens.thickness_mm * scale / 2, front, points=8, align="left")
    sheet.text(left + width + 4, page_y + 1.2, "printed lines", points=8, align="left")


@dataclass(frozen=True)
class SheetPiece:
    """One piece of sheet: its corners in order, mm, y up, the first side across the lenses; name: for people."""

    name: str
    corners: tuple[Point, ...]

    @property
    def upright(self) -> tuple[Point, ...]:
        """Its corners with the lenses upright, from the lower left of the rectangle that holds them."""
        (ax, ay), (bx, by) = self.corners[:2]
        turn = -math.atan2(by - ay, bx - ax)
        cos, sin = math.cos(turn), math.sin(turn)
        turned = [(x * cos - y * sin, x * sin + y * cos) for x, y in self.corners]
        low = min(x for x, _ in turned), min(y for _, y in turned)
        return tuple((x - low[0], y - low[1]) for x, y in turned)

    @property
    def size_mm(self) -> Point:
        """Width across the lenses, and length along them, of the rectangle that holds it."""
        return max(x for x, _ in self.upright), max(y for _, y in self.upright)


def pieces(badge: Badge) -> list[SheetPiece]:
    """The pieces of a badge's sheet, one of each kind, the name saying how many are cut."""
    kinds: dict[tuple[int, int], list[tuple[Point, ...]]] = {}
    for _, corners in sheet_pieces(badge):
        size = SheetPiece("", corners).size_mm
        kinds.setdefault((round(1e3 * size[0]), round(1e3 * size[1])), []).append(corners)
    several = len(kinds) > 1
    found = []
    for number, same in enumerate(kinds.values()):
        name = f"piece {'ABCDEFGH'[number % 8]}" if several else "the piece"
        found.append(SheetPiece(name if len(same) == 1 else f"{name}: cut {len(same)}", same[0]))
    return found


def placed(found: list[SheetPiece], room: Rect) -> list[list[tuple[SheetPiece, Point]]]:
    """Pages of pieces with their upper left corners: from left to right, then below, in a room of the page, mm."""
    pages: list[list[tuple[SheetPiece, Point]]] = [[]]
    x, y, low = room[0], room[1], room[1]
    for piece in found:
        wide, tall = piece.size_mm
        if x > room[0] and x + wide > room[2]:
            x, y = room[0], low + GAP_MM
        if pages[-1] and y + tall > room[3]:
            pages.append([])
            x, y, low = room[0], room[1], room[1]
        pages[-1].append((piece, (x, y)))
        x, low = x + wide + GAP_MM, max(low, y + tall)
    return pages


def draw_plates(sheet: PdfPage, badge: Badge, left_mm: float, top_mm: float) -> None:
    """Draw the pages of the plate, each begun anew."""
    found, (width, height) = pieces(badge), sheet.page_mm
    widest = max(piece.size_mm[0] for piece in found)
    if widest > width - 2 * RIM_MM:
        width, height = height, width
    # A piece as wide as the paper's printable part takes the room of the margins too.
    left = max(RIM_MM, min(left_mm, (width - widest) / 2))
    for page in placed(found, (left, top_mm + 27, width - RIM_MM, height - 24)):
        sheet.turn_page((width, height))
        sheet.text(left_mm, top_mm, "The lens sheet, in true size", points=16, font=BOLD, align="left")
        lines = (
            "Print at 100 %. Lay the sheet on this page, ribs up, so that its ribs run as the thin lines do. Mark it",
            "where the ticks beyond it point. Along the ribs score in a groove, and bend; across them cut at a steel",
            "ruler, square to the ribs. Measure across: no wider than here, and at most 0.2 mm narrower.",
        )
        for k, line in enumerate(lines):
            sheet.text(left_mm, top_mm + 7 + 5 * k, line, points=9, align="left")
        for piece, corner in page:
            _draw_piece(sheet, piece, corner)
        _scale(sheet, left_mm, height - 14)


def _draw_piece(sheet: PdfPage, piece: SheetPiece, corner: Point) -> None:
    """A piece's outline, its lenses sketched, and its name."""
    wide, tall = piece.size_mm
    drawn = [(corner[0] + x, corner[1] + tall - y) for x, y in piece.upright]
    for x in _between(corner[0], wide):
        sheet.path([(x, corner[1]), (x, corner[1] + tall)], None, 0.8, closed=False)
    sheet.path(drawn, None, 0.0, dash_mm=2.0)
    # The sheet hides its outline, and so the marks are beyond it.
    for mark in crop_marks((corner[0], corner[1], corner[0] + wide, corner[1] + tall), TICK_MM):
        sheet.stroke(*mark)
    words = f"{piece.name}, {wide:.1f} × {tall:.1f} mm"
    middle = corner[0] + wide / 2, corner[1] + tall / 2
    half = sheet.text_width_mm(words, 10) / 2 + 2
    x0, y0, x1, y1 = middle[0] - half, middle[1] - 6, middle[0] + half, middle[1] + 3
    if half * 2 < wide:
        sheet.path([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], 1.0, None)
        sheet.text(*middle, words, points=10)
    else:
        sheet.text(corner[0] + 1, corner[1] + tall + 5, words, points=8, align="left")


def _between(low: float, length: float) -> list[float]:
    """Places that part a length evenly, about `LENSES_MM` apart."""
    count = max(2, int(length / LENSES_MM))
    return [low + length * k / count for k in range(1, count)]


def _scale(sheet: PdfPage, x: float, y: float) -> None:
    sheet.stroke(x, y, x + SCALE_MM, y, 0.25)
    for k in range(11):
        sheet.stroke(x + 10 * k, y, x + 10 * k, y - (3 if k % 5 == 0 else 1.5), 0.2)
    sheet.text(x + SCALE_MM + 4, y, "must measure 100 mm", points=8, align="left")
