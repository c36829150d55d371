"""Draws two kinds of pages of assembly.pdf: the exploded view, and the plate of the lens sheet.

The exploded view is an axonometric view of prisms that are pulled apart along z, drawn from the back to the front.  The
plate shows each piece of lens sheet in true size; the sheet is put on it and cut along its lines.  All pieces have
their lenses upright there, those of turned gratings too; the exploded view shows how these are turned on the card.

Convention: the frame of `sight`.  The exploded view is orthographic: the badge lies on a table, its bottom edge towards
the viewer, turned by `TURN_DEG` and seen from `RISE_DEG` above the table, so that z points up the page.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from moireid.badge import Badge, Point, Rect
from moireid.fabrication.page.pdf import BOLD, POINTS_PER_MM, PdfPage
from moireid.fabrication.sight import sheet_pieces

TURN_DEG, RISE_DEG = 30.0, 32.0
#: Gap between parts as a share of the largest part's height on the page.
GAP = 0.62
LABELS_MM, LEADER_MM, LINE_MM, INK = 48.0, 5.0, 0.15, 0.25
#: A rounded corner is at most this far from the corner of the rectangle that holds it.
CORNER_MM = 6.0
#: On the plate: gap between pieces, distance of the lines that sketch lenses, and length of the scale bar.
GAP_MM, LENSES_MM, SCALE_MM = 14.0, 6.0, 100.0
#: What printers leave white around a page; a piece wider than what is left lies on the paper turned, mm.
RIM_MM = 6.0
_COS, _SIN = math.cos(math.radians(TURN_DEG)), math.sin(math.radians(TURN_DEG))
_UP, _FLAT = math.cos(math.radians(RISE_DEG)), math.sin(math.radians(RISE_DEG))
Place = tuple[float, float, float]
Loop = tuple[Point, ...]
#: A wall's two ends seen in its prism's plane, (across, nearness); its corners on the page; its edges there.
Wall = tuple[Point, Point, list[Point], list[tuple[Point, Point]]]


@dataclass(frozen=True)
class Prism:
    """A flat shape drawn out: anticlockwise loops in (x, y) drawn along z, or in (y, z) along x where `along_x`."""

    outline: Loop
    low: float
    high: float
    openings: tuple[Loop, ...] = ()
    along_x: bool = False

    def place(self, point: Point, level: float) -> Place:
        """A place of the frame."""
        return (level, *point) if self.along_x else (*point, level)


@dataclass(frozen=True)
class Part:
    """One thing to gather: its label in the view, its prisms, and the marks and lines on it.

    grey: of the body; marks: flat shapes on the topmost face, (loop, grey); hints: lines on it; gap: to its
    neighbours, a share as `GAP`; screws: places of those that go through it.
    """

    name: str
    detail: str
    prisms: tuple[Prism, ...]
    grey: float = 0.95
    marks: tuple[tuple[Loop, float], ...] = ()
    hints: tuple[tuple[Point, Point], ...] = ()
    gap: float = GAP
    screws: tuple[Point, ...] = ()

    @property
    def places(self) -> list[Place]:
        """All corners of the prisms."""
        return [p.place(point, level) for p in self.prisms for point in p.outline for level in (p.low, p.high)]


def project(place: Place) -> Point:
    """Right and up on the page, mm at life size, of a place of the frame."""
    x, y, z = place
    return x * _COS - y * _SIN, (x * _SIN + y * _COS) * _FLAT + z * _UP


def draw_exploded(sheet: PdfPage, parts: Sequence[Part], area: Rect) -> float:
    """Draw parts, given from behind to the front, into an area of the page, labels at its right.

    Parameters: area: page mm.
    Returns: the scale, page over life.
    """
    lifts = _lifts(parts)
    flat = [project((x, y, z + lift)) for part, lift in zip(parts, lifts, strict=True) for x, y, z in part.places]
    left, right = min(u for u, _ in flat), max(u for u, _ in flat)
    low, high = min(v for _, v in flat), max(v for _, v in flat)
    wide, tall = area[2] - area[0] - LABELS_MM, area[3] - area[1]
    scale = min(wide / (right - left), tall / (high - low))

    def at(place: Place, lift: float = 0.0) -> Point:
        u, v = project((place[0], place[1], place[2] + lift))
        return area[0] + (u - left) * scale, area[1] + (high - v) * scale

    text_x = area[0] + (right - left) * scale + LEADER_MM
    for k, (part, lift) in enumerate(zip(parts, lifts, strict=True)):
        if k:
            # A line ends where the part will lie, which may be inside the one below; for a screw, at the hole's mouth.
            top, low = max(z for _, _, z in parts[k - 1].places), min(z for _, _, z in part.places)
            below, bottom = (top if part.screws else min(top, low)) + lifts[k - 1], low + lift
            for x, y in _axes(parts[k - 1], part):
                draw_path(sheet, [at((x, y, below)), at((x, y, bottom))], None, 0.6, closed=False)
        _draw_part(sheet, part, functools.partial(at, lift=lift))
        end = max((at((x, y, z + lift)) for x, y, z in part.places), key=lambda place: place[0])
        draw_path(sheet, [(end[0] + 0.8, end[1]), (text_x - 1.0, end[1])], None, 0.4, closed=False)
        sheet.text(text_x, end[1] - 0.2, part.name, points=9, align="left")
        sheet.text(text_x, end[1] + 3.8, part.detail, points=8, align="left")
    return scale


def _lifts(parts: Sequence[Part]) -> list[float]:
    """How far each part is pulled up along z, mm."""
    heights = []
    for part in parts:
        ups = [project((x, y, 0.0))[1] for x, y, _ in part.places]
        heights.append(max(ups) - min(ups))
    lifts = [0.0]
    for before, part in itertools.pairwise(parts):
        share = part.gap if before.gap == GAP else before.gap
        gap = share * max(heights) / _UP
        top = max(z for _, _, z in before.places) + lifts[-1]
        lifts.append(top + gap - min(z for _, _, z in part.places))
    return lifts


def _axes(lower: Part, upper: Part) -> list[Point]:
    """Places of the thin lines that lead from part to part: at screws, or at the corners of what both cover.

    A clip or a stand has none, because it is not put on along z.
    """
    if lower.screws and upper.screws:
        return list(upper.screws)
    if any(prism.along_x for prism in lower.prisms):
        return []
    ends = [
        [(min(values), max(values)) for values in list(zip(*part.places, strict=True))[:2]] for part in (lower, upper)
    ]
    (x0, x1), (y0, y1) = ((max(a[0], b[0]), min(a[1], b[1])) for a, b in zip(*ends, strict=True))
    # Around turned pieces the corners of what both cover are corners of neither.
    near = [place[:2] for part in (lower, upper) for place in part.places]
    return [(x, y) for x in (x0, x1) for y in (y0, y1) if min(math.dist((x, y), place) for place in near) < CORNER_MM]


def _draw_part(sheet: PdfPage, part: Part, at: Callable[[Place], Point]) -> None:
    for prism in part.prisms:
        _draw_prism(sheet, prism, part.grey, at)
    top = max(z for _, _, z in part.places)
    for loop, grey in part.marks:
        draw_path(sheet, [at((x, y, top)) for x, y in loop], grey, None)
    for start, end in part.hints:
        draw_path(sheet, [at((*start, top)), at((*end, top))], None, 0.6, closed=False)


def _draw_prism(sheet: PdfPage, prism: Prism, grey: float, at: Callable[[Place], Point]) -> None:
    """The walls that the viewer sees, from the back, then the face: the upper one, or the left one of a body along x.

    No wall can hide that face, because the face is on the viewer's side of all walls.
    """
    walls: list[Wall] = []
    toward = (-_COS * _UP, _FLAT) if prism.along_x else (-_SIN * _UP, -_COS * _UP)
    for loop, inside in ((prism.outline, False), *((opening, True) for opening in prism.openings)):
        count = len(loop)
        quads = [
            [
                prism.place(loop[k], prism.low),
                prism.place(loop[(k + 1) % count], prism.low),
                prism.place(loop[(k + 1) % count], prism.high),
                prism.place(loop[k], prism.high),
            ]
            for k in range(count)
        ]
        seen = [(signed_area([project(p) for p in quad]) > 0) != inside for quad in quads]
        for k, quad in enumerate(quads):
            if not seen[k]:
                continue
            flat = [at(p) for p in quad]
            edges = [(flat[0], flat[1]), (flat[3], flat[2])]
            if _corner(loop, k) or not seen[k - 1]:
                edges.append((flat[0], flat[3]))
            if _corner(loop, (k + 1) % count) or not seen[(k + 1) % count]:
                edges.append((flat[1], flat[2]))
            # Across and along the way to the viewer, in the prism's own plane.
            ends = [
                (x * -toward[1] + y * toward[0], x * toward[0] + y * toward[1])
                for x, y in (loop[k], loop[(k + 1) % count])
            ]
            walls.append((min(ends), max(ends), flat, edges))
    for _, _, flat, edges in _back_first(walls):
        draw_path(sheet, flat, grey - 0.13, None)
        for edge in edges:
            draw_path(sheet, list(edge), None, INK, closed=False)
    level = prism.low if prism.along_x else prism.high
    loops = [[at(prism.place(point, level)) for point in loop] for loop in (prism.outline, *prism.openings)]
    draw_path(sheet, loops[0], grey, INK, holes=loops[1:])


def _back_first(walls: list[Wall]) -> list[Wall]:
    """The walls in drawing order: each comes after those that it hides."""
    left, ordered = sorted(walls, key=lambda wall: wall[0][1] + wall[1][1]), []
    while left:
        # Walls of one prism do not cross, so there is always one that hides none of the others.
        k = next((k for k, wall in enumerate(left) if not any(_hides(wall, other) for other in left)), 0)
        ordered.append(left.pop(k))
    return ordered


def _hides(one: Wall, other: Wall) -> bool:
    """Whether a wall is nearer than another where both are seen."""
    low, high = max(one[0][0], other[0][0]), min(one[1][0], other[1][0])
    if one is other or high - low < 1e-9:
        return False
    middle, near = (low + high) / 2, []
    for (a0, n0), (a1, n1), *_ in (one, other):
        near.append(n0 + (n1 - n0) * (middle - a0) / (a1 - a0))
    return near[0] > near[1]


def draw_path(
    sheet: PdfPage,
    points: Sequence[Point],
    fill: float | None,
    line: float | None,
    *,
    closed: bool = True,
    holes: Iterable[Sequence[Point]] = (),
    dash_mm: float | None = None,
) -> None:
    """A path in page mm: grey of its filling and of its line, None to leave it out; holes stay unfilled.

    dash_mm: length of a dash of a line that is cut.
    """
    path = sheet.canvas.beginPath()
    for loop in (points, *holes):
        for k, (x, y) in enumerate(loop):
            put = path.lineTo if k else path.moveTo
            put(x * POINTS_PER_MM, (sheet.height_mm - y) * POINTS_PER_MM)
        if closed:
            path.close()
    sheet.canvas.setLineWidth(LINE_MM * POINTS_PER_MM)
    sheet.canvas.setLineJoin(1)
    dashes = [dash_mm * POINTS_PER_MM] * 2 if dash_mm else []
    sheet.canvas.setDash(dashes)
    if fill is not None:
        sheet.canvas.setFillGray(fill)
    if line is not None:
        sheet.canvas.setStrokeGray(line)
    sheet.canvas.drawPath(path, stroke=int(line is not None), fill=int(fill is not None), fillMode=0)
    sheet.canvas.setDash([])


def _corner(loop: Loop, k: int) -> bool:
    """Whether a loop turns sharply at a point; points of an arc do not."""
    (x0, y0), (x1, y1), (x2, y2) = loop[k - 1], loop[k], loop[(k + 1) % len(loop)]
    turn = math.atan2((x1 - x0) * (y2 - y1) - (y1 - y0) * (x2 - x1), (x1 - x0) * (x2 - x1) + (y1 - y0) * (y2 - y1))
    return abs(math.degrees(turn)) > 25.0


def signed_area(loop: Sequence[Point]) -> float:
    """Signed area, above 0 where the loop runs anticlockwise."""
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(loop, (*loop[1:], loop[0]), strict=True)) / 2


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


def _draw_piece(sheet: PdfPage, piece: SheetPiece, corner: Point, *, crossed: bool) -> None:
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


def _scale(sheet: PdfPage, x: float, y: float) -> None:
    sheet.stroke(x, y, x + SCALE_MM, y, 0.25)
    for k in range(11):
        sheet.stroke(x + 10 * k, y, x + 10 * k, y - (3 if k % 5 == 0 else 1.5), 0.2)
    sheet.text(x + SCALE_MM + 4, y, "must measure 100 mm", points=8, align="left")
