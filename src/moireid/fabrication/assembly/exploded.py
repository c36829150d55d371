"""The exploded views of assembly.pdf: parts as prisms that are pulled apart along z, drawn from the back to the front.

Here are the drawing, and the card with its sheet; `mount_views` has the parts of mounts.

Convention: the frame of `sight`; parts from behind to the front.  The view is orthographic: the badge lies on a table,
its bottom edge towards the viewer, turned by `TURN_DEG` and seen from `RISE_DEG` above the table, so that z points up
the page.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from moireid.badge import Badge, Point, Rect
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.page.pdf import marker_squares
from moireid.fabrication.process_figures import MountProcess
from moireid.fabrication.sight import corners_in_frame, in_frame, sheet_pieces

TURN_DEG, RISE_DEG = 30.0, 32.0
#: Gap between parts as a share of the largest part's height on the page.
GAP = 0.62
LABELS_MM, LEADER_MM, INK = 48.0, 5.0, 0.25
#: A rounded corner is at most this far from the corner of the rectangle that holds it.
CORNER_MM = 6.0
#: Lines of gratings, lenses and mask are sketched this far apart, as the true ones would run together.
HINT_MM = 4.0
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

    Parameters
    ----------
    area : Rect
        Where, page mm.

    Returns
    -------
    float
        The scale, page over life.
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
                sheet.path([at((x, y, below)), at((x, y, bottom))], None, 0.6, closed=False)
        _draw_part(sheet, part, functools.partial(at, lift=lift))
        end = max((at((x, y, z + lift)) for x, y, z in part.places), key=lambda place: place[0])
        sheet.path([(end[0] + 0.8, end[1]), (text_x - 1.0, end[1])], None, 0.4, closed=False)
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
        sheet.path([at((x, y, top)) for x, y in loop], grey, None)
    for start, end in part.hints:
        sheet.path([at((*start, top)), at((*end, top))], None, 0.6, closed=False)


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
        sheet.path(flat, grey - 0.13, None)
        for edge in edges:
            sheet.path(list(edge), None, INK, closed=False)
    level = prism.low if prism.along_x else prism.high
    loops = [[at(prism.place(point, level)) for point in loop] for loop in (prism.outline, *prism.openings)]
    sheet.path(loops[0], grey, INK, holes=loops[1:])


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


def _corner(loop: Loop, k: int) -> bool:
    """Whether a loop turns sharply at a point; points of an arc do not."""
    (x0, y0), (x1, y1), (x2, y2) = loop[k - 1], loop[k], loop[(k + 1) % len(loop)]
    turn = math.atan2((x1 - x0) * (y2 - y1) - (y1 - y0) * (x2 - x1), (x1 - x0) * (x2 - x1) + (y1 - y0) * (y2 - y1))
    return abs(math.degrees(turn)) > 25.0


def signed_area(loop: Sequence[Point]) -> float:
    """Signed area, above 0 where the loop runs anticlockwise."""
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(loop, (*loop[1:], loop[0]), strict=True)) / 2


def plain_parts(badge: Badge, process: MountProcess) -> list[Part]:
    """Card and front alone, from behind to the front."""
    return [card_part(badge, process.card_mm), *front_parts(badge, process.card_mm, process.film_mm)]


def card_part(badge: Badge, card_mm: float) -> Part:
    """The printed card, its gratings and markers sketched."""
    x0, y0, x1, y1 = in_frame(badge.outline_mm, badge)
    marks: list[tuple[Loop, float]] = []
    hints: list[tuple[Point, Point]] = []
    for grating in badge.gratings:
        corners = corners_in_frame(badge, grating, grating.rect_mm)
        marks.append((corners, 0.8))
        hints += _lines(corners)
    for square, whites in marker_squares(badge):
        marks.append((box_loop(in_frame(square, badge)), 0.2))
        marks += [(box_loop(in_frame(white, badge)), 1.0) for white in whites]
    size = f"{card_mm:g} mm; {x1 - x0:g} × {y1 - y0:g} mm"
    body = Prism(box_loop((x0, y0, x1, y1)), 0.0, card_mm)
    return Part("printed card", size, (body,), 1.0, tuple(marks), tuple(hints))


def front_parts(badge: Badge, low: float, film_mm: float) -> list[Part]:
    """The lens sheets, or spacer and film of a mask."""
    loops, lens = [corners for _, corners in sheet_pieces(badge)], badge.lens
    middle = low + lens.thickness_mm
    several = f"{len(loops)} " if len(loops) > 1 else ""
    plural = "s" if several else ""
    # The lenses of an array lie in rows both ways.
    crossed = [corners[1:] + corners[:1] for corners in loops] if lens.kind == "array" else []
    hints = [line for corners in [*loops, *crossed] for line in _lines(corners)]
    bodies = [loop if signed_area(loop) > 0 else loop[::-1] for loop in loops]
    body = tuple(Prism(loop, low, middle) for loop in bodies)
    if lens.kind != "mask":
        name = f"{several}lens sheet{plural}"
        return [Part(name, f"{lens.thickness_mm:.3g} mm; lenses up", body, 0.97, hints=tuple(hints))]
    film = tuple(Prism(loop, middle, middle + film_mm) for loop in bodies)
    return [
        Part(f"{several}clear spacer{plural}", f"{lens.thickness_mm:g} mm", body, 0.95),
        Part(f"{several}mask film{plural}", f"{film_mm:g} mm; printed side down", film, 0.99, hints=tuple(hints)),
    ]


def _lines(corners: tuple[Point, ...]) -> list[tuple[Point, Point]]:
    """Sketched lines across a rectangle's axis, along which its first two corners lie."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = corners
    count = max(2, int(math.hypot(bx - ax, by - ay) / HINT_MM))
    steps = [k / count for k in range(1, count)]
    return [((ax + s * (bx - ax), ay + s * (by - ay)), (dx + s * (cx - dx), dy + s * (cy - dy))) for s in steps]


def box_loop(rect: Rect) -> Loop:
    """A rectangle's corners, anticlockwise."""
    x0, y0, x1, y1 = rect
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
