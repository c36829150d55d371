"""The plate of the lens sheet: each piece to cut in true size, lenses upright, to be laid under the sheet.

Pieces of turned gratings are drawn as they are cut, their lenses upright as those of all others; how they are turned on
the card, the exploded view shows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from moireid.badge import Badge, Point, Rect
from moireid.fabrication.assembly.axonometry import draw_path
from moireid.fabrication.page.pdf import BOLD, Sheet
from moireid.fabrication.sight import sheet_pieces

GAP_MM, LENSES_MM, SCALE_MM = 14.0, 6.0, 100.0
#: What printers leave white around a page; a piece wider than what is left lies on the paper turned, mm.
RIM_MM = 6.0


@dataclass(frozen=True)
class Piece:
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


def pieces(badge: Badge) -> list[Piece]:
    """The pieces of a badge's sheet, one of each kind, the name saying how many are cut."""
    kinds: dict[tuple[int, int], list[tuple[Point, ...]]] = {}
    for _, corners in sheet_pieces(badge):
        size = Piece("", corners).size_mm
        kinds.setdefault((round(1e3 * size[0]), round(1e3 * size[1])), []).append(corners)
    several = len(kinds) > 1
    found = []
    for number, same in enumerate(kinds.values()):
        name = f"piece {'ABCDEFGH'[number % 8]}" if several else "the piece"
        found.append(Piece(name if len(same) == 1 else f"{name}: cut {len(same)}", same[0]))
    return found


def placed(found: list[Piece], room: Rect) -> list[list[tuple[Piece, Point]]]:
    """Pages of pieces with their upper left corners: from left to right, then below, in a room of the page, mm."""
    pages: list[list[tuple[Piece, Point]]] = [[]]
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


def draw_plates(sheet: Sheet, badge: Badge, left_mm: float, top_mm: float) -> None:
    """Draw the pages of the plate, each begun anew."""
    found, (width, height) = pieces(badge), sheet.page_mm
    widest = max(piece.size_mm[0] for piece in found)
    if widest > width - 2 * RIM_MM:
        width, height = height, width
    # A piece as wide as the paper's printable part takes the room of the margins too.
    left = max(RIM_MM, min(left_mm, (width - widest) / 2))
    for page in placed(found, (left, top_mm + 22, width - RIM_MM, height - 24)):
        sheet.turn_page((width, height))
        sheet.text(left_mm, top_mm, "The lens sheet, in true size", points=16, font=BOLD, align="left")
        array = badge.lens.kind == "array"
        along = "lenses up, so that their rows" if array else "ribs up, so that its ribs"
        lines = (
            f"Print at 100 %. Lay the sheet on this page, {along} run as the thin lines do.",
            "Cut along the dashed lines: no wider, and at most 0.2 mm narrower.",
        )
        for k, line in enumerate(lines):
            sheet.text(left_mm, top_mm + 7 + 5 * k, line, points=9, align="left")
        for piece, corner in page:
            _draw_piece(sheet, piece, corner, crossed=array)
        _scale(sheet, left_mm, height - 14)


def _draw_piece(sheet: Sheet, piece: Piece, corner: Point, *, crossed: bool) -> None:
    """A piece's outline, its lenses sketched, crossed for those of an array, and its name."""
    wide, tall = piece.size_mm
    drawn = [(corner[0] + x, corner[1] + tall - y) for x, y in piece.upright]
    for x in _between(corner[0], wide):
        draw_path(sheet, [(x, corner[1]), (x, corner[1] + tall)], None, 0.8, closed=False)
    for y in _between(corner[1], tall) if crossed else []:
        draw_path(sheet, [(corner[0], y), (corner[0] + wide, y)], None, 0.8, closed=False)
    draw_path(sheet, drawn, None, 0.0, dash_mm=2.0)
    words = f"{piece.name}, {wide:.1f} × {tall:.1f} mm"
    middle = corner[0] + wide / 2, corner[1] + tall / 2
    half = sheet.text_width_mm(words, 10) / 2 + 2
    x0, y0, x1, y1 = middle[0] - half, middle[1] - 6, middle[0] + half, middle[1] + 3
    if half * 2 < wide:
        draw_path(sheet, [(x0, y0), (x1, y0), (x1, y1), (x0, y1)], 1.0, None)
        sheet.text(*middle, words, points=10)
    else:
        sheet.text(corner[0], corner[1] + tall + 5, words, points=8, align="left")


def _between(low: float, length: float) -> list[float]:
    """Places that part a length evenly, about `LENSES_MM` apart."""
    count = max(2, int(length / LENSES_MM))
    return [low + length * k / count for k in range(1, count)]


def _scale(sheet: Sheet, x: float, y: float) -> None:
    sheet.stroke(x, y, x + SCALE_MM, y, 0.25)
    for k in range(11):
        sheet.stroke(x + 10 * k, y, x + 10 * k, y - (3 if k % 5 == 0 else 1.5), 0.2)
    sheet.text(x + SCALE_MM + 4, y, "must measure 100 mm", points=8, align="left")
