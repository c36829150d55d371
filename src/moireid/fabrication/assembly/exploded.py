"""The exploded views of assembly.pdf: parts that are pulled apart along z, drawn from the back to the front.

Here are the drawing, and the card with its sheet, which need no CAD package; `solid_views` draws the solids of mounts,
and `mount_views` names them.

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
from moireid.fabrication.page.marks import marker_squares
from moireid.fabrication.process_figures import MountProcess
from moireid.fabrication.sight import corners_in_frame, in_frame, sheet_pieces

TURN_DEG, RISE_DEG = 30.0, 32.0
#: Gap between parts as a share of the largest part's height on the page.
GAP = 0.62
#: Labels: room for them at the right, a leader's length, and from one label to the next; grey of lines.
LABELS_MM, LEADER_MM, LABEL_MM, INK = 37.0, 4.0, 7.0, 0.25
#: A rounded corner is at most this far from the corner of the rectangle that holds it.
CORNER_MM = 6.0
#: Lines of gratings, lenses and mask are sketched this far apart, as the true ones would run together.
HINT_MM = 4.0
_COS, _SIN = math.cos(math.radians(TURN_DEG)), math.sin(math.radians(TURN_DEG))
_UP, _FLAT = math.cos(math.radians(RISE_DEG)), math.sin(math.radians(RISE_DEG))
Place = tuple[float, float, float]
Loop = tuple[Point, ...]
#: Unit vectors of the frame that point right and up on the page, and to the viewer.
ACROSS: Place = (_COS, -_SIN, 0.0)
UPWARD: Place = (_SIN * _FLAT, _COS * _FLAT, _UP)
TOWARD: Place = (-_SIN * _UP, -_COS * _UP, _FLAT)


@dataclass(frozen=True)
class Piece:
    """One body as it is drawn.

    outlines: its silhouette on the page, mm at life size, where two loops lie on each other is an opening; lines: its
    visible edges there; low, high: its heights in the frame; corners: places of the frame that lines may lead to.
    """

    outlines: tuple[Loop, ...]
    lines: tuple[Loop, ...]
    low: float
    high: float
    corners: tuple[Point, ...]


@dataclass(frozen=True)
class Part:
    """One thing to gather: its label in the view, its pieces, and the marks and lines on it.

    grey: of the body; marks: flat shapes on the topmost face, (loop, grey); hints: lines on it; gap: to its
    neighbours, a share as `GAP`; screws: places of those that go through it; alone: no lines lead to it.
    """

    name: str
    detail: str
    pieces: tuple[Piece, ...]
    grey: float = 0.95
    marks: tuple[tuple[Loop, float], ...] = ()
    hints: tuple[tuple[Point, Point], ...] = ()
    gap: float = GAP
    screws: tuple[Point, ...] = ()
    alone: bool = False

    @property
    def low(self) -> float:
        """Its lowest place."""
        return min(piece.low for piece in self.pieces)

    @property
    def high(self) -> float:
        """Its highest place."""
        return max(piece.high for piece in self.pieces)

    @property
    def corners(self) -> list[Point]:
        """Places of the frame that lines may lead to."""
        return [corner for piece in self.pieces for corner in piece.corners]

    @property
    def drawn(self) -> list[Point]:
        """All places of its silhouette on the page."""
        return [place for piece in self.pieces for loop in piece.outlines for place in loop]


def prism(loop: Loop, low: float, high: float) -> Piece:
    """A convex loop of the frame drawn out along z."""
    loop = loop if signed_area(loop) > 0 else loop[::-1]
    count = len(loop)
    bottom, top = ([project((*place, level)) for place in loop] for level in (low, high))
    lines: list[Loop] = [(*top, top[0])]
    silhouette: list[Point] = []
    for k in range(count):
        wall = (top[k], bottom[k], bottom[(k + 1) % count], top[(k + 1) % count])
        # A wall is seen if its corners run anticlockwise on the page; the silhouette follows its lower edge then, and
        # else its upper one.
        seen = signed_area(wall) > 0
        lines += [wall] if seen else []
        silhouette += wall[1:3] if seen else [wall[0], wall[3]]
    return Piece((tuple(silhouette),), tuple(lines), low, high, loop)


def project(place: Place) -> Point:
    """Right and up on the page, mm at life size, of a place of the frame."""
    x, y, z = place
    return x * _COS - y * _SIN, (x * _SIN + y * _COS) * _FLAT + z * _UP


def draw_exploded(sheet: PdfPage, parts: Sequence[Part], area: Rect) -> None:
    """Draw parts, given from behind to the front, into an area of the page, mm, labels at its right."""
    lifts = _lifts(parts)
    flat = [(u, v + lift * _UP) for part, lift in zip(parts, lifts, strict=True) for u, v in part.drawn]
    left, right = min(u for u, _ in flat), max(u for u, _ in flat)
    low, high = min(v for _, v in flat), max(v for _, v in flat)
    wide, tall = area[2] - area[0] - LABELS_MM, area[3] - area[1]
    scale = min(wide / (right - left), tall / (high - low))

    def on_page(place: Point, lift: float) -> Point:
        return area[0] + (place[0] - left) * scale, area[1] + (high - place[1] - lift * _UP) * scale

    text_x, label_y = area[0] + (right - left) * scale + LEADER_MM, math.inf
    for k, (part, lift) in enumerate(zip(parts, lifts, strict=True)):
        at = functools.partial(on_page, lift=lift)
        if k:
            # A line ends where the part will lie, which may be inside the one below; for a screw, at the hole's mouth.
            top = parts[k - 1].high
            below = (top if part.screws else min(top, part.low)) + lifts[k - 1]
            for x, y in _axes(parts[k - 1], part):
                ends = [on_page(project((x, y, level)), 0.0) for level in (below, part.low + lift)]
                sheet.path(ends, None, 0.6, closed=False)
        _draw_part(sheet, part, at)
        end = max((at(place) for place in part.drawn), key=lambda place: place[0])
        # Labels of parts that are near each other move up.
        label_y = min(end[1], label_y - LABEL_MM)
        sheet.path([(end[0] + 0.8, end[1]), (text_x - 1.0, label_y)], None, 0.4, closed=False)
        sheet.text(text_x, label_y - 0.2, part.name, points=8, align="left")
        sheet.text(text_x, label_y + 3.2, part.detail, points=7, align="left")


def _lifts(parts: Sequence[Part]) -> list[float]:
    """How far each part is pulled up along z, mm."""
    tallest = max(max(v for _, v in part.drawn) - min(v for _, v in part.drawn) for part in parts)
    lifts = [0.0]
    for before, part in itertools.pairwise(parts):
        share = part.gap if before.gap == GAP else before.gap
        lifts.append(before.high + lifts[-1] + share * tallest / _UP - part.low)
    return lifts


def _axes(lower: Part, upper: Part) -> list[Point]:
    """Places of the thin lines that lead from part to part: at screws, or at the corners of what both cover."""
    if lower.screws and upper.screws:
        return list(upper.screws)
    if lower.alone or upper.alone:
        return []
    ends = [[(min(values), max(values)) for values in zip(*part.corners, strict=True)] for part in (lower, upper)]
    (x0, x1), (y0, y1) = ((max(a[0], b[0]), min(a[1], b[1])) for a, b in zip(*ends, strict=True))
    # Around turned pieces the corners of what both cover are corners of neither.
    near = [*lower.corners, *upper.corners]
    return [(x, y) for x in (x0, x1) for y in (y0, y1) if min(math.dist((x, y), place) for place in near) < CORNER_MM]


def _draw_part(sheet: PdfPage, part: Part, at: Callable[[Point], Point]) -> None:
    for piece in part.pieces:
        first, *others = ([at(place) for place in loop] for loop in piece.outlines)
        sheet.path(first, part.grey, None, holes=others)
        for line in piece.lines:
            sheet.path([at(place) for place in line], None, INK, closed=False)
    for loop, grey in part.marks:
        sheet.path([at(project((x, y, part.high))) for x, y in loop], grey, None)
    for ends in part.hints:
        sheet.path([at(project((x, y, part.high))) for x, y in ends], None, 0.6, closed=False)


def signed_area(loop: Sequence[Point]) -> float:
    """Signed area, above 0 where the loop runs anticlockwise."""
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(loop, (*loop[1:], loop[0]), strict=True)) / 2


def plain_parts(badge: Badge, process: MountProcess) -> list[Part]:
    """Card and front alone, from behind to the front."""
    return [card_part(badge, process.card_mm), *front_parts(badge, process.card_mm, process.film_mm)]


def card_part(badge: Badge, card_mm: float) -> Part:
    """The printed card, its gratings and markers sketched."""
    x0, y0, x1, y1 = outline = in_frame(badge.outline_mm, badge)
    marks: list[tuple[Loop, float]] = []
    hints: list[tuple[Point, Point]] = []
    for grating in badge.gratings:
        corners = corners_in_frame(badge, grating, grating.rect_mm)
        marks.append((corners, 0.8))
        hints += lines_across(corners)
    for square, whites in marker_squares(badge):
        marks.append((box_loop(in_frame(square, badge)), 0.2))
        marks += [(box_loop(in_frame(white, badge)), 1.0) for white in whites]
    size = f"{card_mm:g} mm; {x1 - x0:g} × {y1 - y0:g} mm"
    body = prism(box_loop(outline), 0.0, card_mm)
    return Part("printed card", size, (body,), 1.0, tuple(marks), tuple(hints))


def front_parts(badge: Badge, low: float, film_mm: float) -> list[Part]:
    """The lens sheets, or spacer and film of a mask."""
    loops, lens = [corners for _, corners in sheet_pieces(badge)], badge.lens
    middle = low + lens.thickness_mm
    several = f"{len(loops)} " if len(loops) > 1 else ""
    plural = "s" if several else ""
    hints = [line for corners in loops for line in lines_across(corners)]
    body = tuple(prism(loop, low, middle) for loop in loops)
    if lens.kind != "mask":
        name = f"{several}lens sheet{plural}"
        return [Part(name, f"{lens.thickness_mm:.3g} mm; lenses up", body, 0.97, hints=tuple(hints))]
    film = tuple(prism(loop, middle, middle + film_mm) for loop in loops)
    return [
        Part(f"{several}clear spacer{plural}", f"{lens.thickness_mm:g} mm", body, 0.95),
        Part(f"{several}mask film{plural}", f"{film_mm:g} mm; printed side down", film, 0.99, hints=tuple(hints)),
    ]


def lines_across(corners: Sequence[Point], step_mm: float = HINT_MM) -> list[tuple[Point, Point]]:
    """Sketched lines across a rectangle's axis, along which its first two corners lie."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = corners
    count = max(2, int(math.hypot(bx - ax, by - ay) / step_mm))
    steps = [k / count for k in range(1, count)]
    return [((ax + s * (bx - ax), ay + s * (by - ay)), (dx + s * (cx - dx), dy + s * (cy - dy))) for s in steps]


def box_loop(rect: Rect) -> Loop:
    """A rectangle's corners, anticlockwise."""
    x0, y0, x1, y1 = rect
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
