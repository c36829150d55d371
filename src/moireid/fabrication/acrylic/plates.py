"""The acrylic stack: base plate, frame and cover, cut by laser and held by M3 screws.

The page lies on the base, inside the frame.  Page and lens sheet fit between the frame's sides with so little air that
they cannot turn against each other by more than the code tolerates.  The frame is thinner than page and sheet together.
The cover lies over the sheet's left and right edge.  It is screwed down until it touches the sheet all along, so that
no air is left between sheet and page; a slit of `squeeze_mm` stays between cover and frame.  The rest of the cover and
the screws' heads (M3 button heads, ISO 7380) stay out of the camera's view.

Convention: the frame of `sight`, its origin on the base's upper face.  Contours are finished edges, without kerf, and
run anticlockwise, holes too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from moireid.badge import Badge, Point, Rect
from moireid.errors import FabricationError
from moireid.fabrication.process_figures import LEAST_LAND_MM, STOCK_MM, TWIST_DEG, AcrylicProcess
from moireid.fabrication.sight import (
    Obstacle,
    front_mm,
    front_word,
    half_board_mm,
    sheet_rects,
    sheet_spans,
    sight_fault,
)


@dataclass(frozen=True)
class Contour:
    """A closed path with rounded corners: one radius a corner, 0 for a sharp one; anticlockwise."""

    corners: tuple[Point, ...]
    radii_mm: tuple[float, ...]

    def grown(self, by_mm: float) -> Contour:
        """The same path moved outwards by `by_mm`, or inwards where that is negative; corners keep their centres.

        Raises: FabricationError where a rounded corner would turn inside out.
        """
        count, moved, radii = len(self.corners), [], []
        for k, (x, y) in enumerate(self.corners):
            before, after = _direction(self.corners[k - 1], (x, y)), _direction((x, y), self.corners[(k + 1) % count])
            turn = before[0] * after[1] - before[1] * after[0]
            along = 1.0 + before[0] * after[0] + before[1] * after[1]
            # The corner moves so that both its edges end up `by_mm` to the right of where they were.
            moved.append((x + by_mm * (before[1] + after[1]) / along, y - by_mm * (before[0] + after[0]) / along))
            radius = self.radii_mm[k] + (math.copysign(by_mm, by_mm * turn) if self.radii_mm[k] else 0.0)
            if radius < 0:
                raise FabricationError(
                    f"a corner of radius {self.radii_mm[k]:g} mm cannot be moved by {by_mm:g} mm; give "
                    "a smaller kerf_mm"
                )
            radii.append(radius)
        return Contour(tuple(moved), tuple(radii))

    def moved(self, dx: float, dy: float) -> Contour:
        """The same path elsewhere."""
        return replace(self, corners=tuple((x + dx, y + dy) for x, y in self.corners))

    def vertices(self) -> list[tuple[float, float, float]]:
        """Corners as (x, y, bulge): where an arc begins its bulge is the tangent of a quarter of its angle, else 0.

        Source: the DXF reference's LWPOLYLINE.
        """
        count = len(self.corners)
        points: list[tuple[float, float, float]] = []
        for k, (x, y) in enumerate(self.corners):
            radius = self.radii_mm[k]
            before, after = _direction(self.corners[k - 1], (x, y)), _direction((x, y), self.corners[(k + 1) % count])
            angle = math.atan2(before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1])
            if radius == 0 or angle == 0:
                points.append((x, y, 0.0))
                continue
            back = radius * math.tan(abs(angle) / 2)
            points.append((x - back * before[0], y - back * before[1], math.tan(angle / 4)))
            points.append((x + back * after[0], y + back * after[1], 0.0))
        # Where two roundings meet, as in a circle, the straight between them has no length.
        return [p for k, p in enumerate(points) if math.dist(p[:2], points[(k + 1) % len(points)][:2]) > 1e-9]

    def flat(self, steps: int = 16) -> tuple[Point, ...]:
        """The path as a polygon, mm, each arc in `steps` pieces."""
        vertices = self.vertices()
        points: list[Point] = []
        for k, (x, y, bulge) in enumerate(vertices):
            points.append((x, y))
            if bulge == 0:
                continue
            end_x, end_y, _ = vertices[(k + 1) % len(vertices)]
            # The centre lies on the chord's bisector, to its left for an arc that turns left by less than a half turn.
            offset = (1 - bulge * bulge) / (4 * bulge)
            cx, cy = (x + end_x) / 2 - (end_y - y) * offset, (y + end_y) / 2 + (end_x - x) * offset
            for step in range(1, steps):
                angle = 4 * math.atan(bulge) * step / steps
                cos, sin = math.cos(angle), math.sin(angle)
                points.append((cx + (x - cx) * cos - (y - cy) * sin, cy + (x - cx) * sin + (y - cy) * cos))
        return tuple(points)

    @property
    def bounds(self) -> Rect:
        """The corners' bounding box, which a rounded path touches too."""
        xs, ys = zip(*self.corners, strict=True)
        return (min(xs), min(ys), max(xs), max(ys))


def _direction(start: Point, end: Point) -> Point:
    length = math.dist(start, end)
    return (end[0] - start[0]) / length, (end[1] - start[1]) / length


#: M3 button head, ISO 7380: diameter and height; the thread, and its nut's height (ISO 4032).
HEAD_MM, HEAD_HIGH_MM, THREAD_MM, NUT_MM = 5.7, 1.65, 3.0, 2.4
#: Screws are no farther apart than this along an edge that presses, or the cover would bow.
SCREW_PITCH_MM = 90.0
#: How far page and sheet must reach above the frame, so that the cover touches the sheet; and how much of the sheet's
#: edge the frame must hold at least.
LEAST_SQUEEZE_MM, LEAST_GRIP_MM = 0.1, 0.2
#: A cover that is bent more than this may crack.
MOST_SQUEEZE_MM = 1.1
#: The laser's own error of place, mm: a clearance must not be smaller.
LASER_MM, MOST_CLEARANCE_MM = 0.05, 0.15
#: Least and most thickness of a cover: a thinner one would bend, a thicker one only hides more.
COVER_MM = (1.0, 3.0)
SLOT_MM = (16.0, 4.0)
OUTER_RADIUS_MM = 4.0


@dataclass(frozen=True)
class Plate:
    """One sheet to cut: its outline and openings as finished, and where it lies in the stack, mm."""

    name: str
    thickness_mm: float
    low_mm: float
    outline: Contour
    openings: tuple[Contour, ...]

    def cuts(self, kerf_mm: float) -> tuple[Contour, ...]:
        """The laser's paths, outline first: half the kerf outside the outline and inside each opening.

        Raises: FabricationError as `Contour.grown`.
        """
        return (self.outline.grown(kerf_mm / 2), *(opening.grown(-kerf_mm / 2) for opening in self.openings))


@dataclass(frozen=True)
class AcrylicPlan:
    """The stack of a badge.

    base, frame, cover: the plates; sheets: each lens sheet's rectangle; page: the board's; card_mm and sheet_top: the
    page's thickness and the lenses' height; clearance_mm: at each register edge; twist_deg: the most that page and
    lens can turn against each other within it; squeeze_mm: slit between frame and cover; screws: places of the M3
    screws; screw_mm: their least length below the head.
    """

    base: Plate
    frame: Plate
    cover: Plate
    page: Rect
    sheets: tuple[Rect, ...]
    card_mm: float
    sheet_top: float
    clearance_mm: float
    twist_deg: float
    squeeze_mm: float
    screws: tuple[Point, ...]
    screw_mm: float

    @property
    def plates(self) -> tuple[Plate, Plate, Plate]:
        """From behind to the front."""
        return (self.base, self.frame, self.cover)


def plan_acrylic(badge: Badge, process: AcrylicProcess | None = None) -> AcrylicPlan:
    """The acrylic stack of a badge, checked: register, grip, view and the land between cuts.

    Raises: FabricationError with what, got, allowed and the next step.
    """
    process = process or AcrylicProcess()
    half_x, half_y = half_board_mm(badge)
    spans = sheet_spans(badge)
    # An adhesive lies on the card, and the sheet on it.
    card_mm = process.card_mm + process.adhesive_mm
    sheet_top = card_mm + front_mm(badge, process.film_mm)
    frame_mm = _frame_mm(card_mm, sheet_top)
    clearance = _clearance_mm(spans, 2 * half_y, process)
    reach_x, reach_y = half_x + clearance, half_y + clearance
    window = _rectangle((-reach_x, -reach_y, reach_x, reach_y))
    rim = process.rim_mm
    outline = _rectangle((-reach_x - rim, -reach_y - rim, reach_x + rim, reach_y + rim), radius=OUTER_RADIUS_MM)
    screws = _screws(reach_x + rim / 2, reach_y + rim / 2)
    holes = tuple(_circle(screw, process.hole_mm) for screw in screws)
    width = outline.bounds[2] - outline.bounds[0]
    # A badge that hangs from two points cannot turn about its cord, which would move the fringes.
    if width >= 2 * SLOT_MM[0] + 60.0:
        holes += tuple(_slot((side * width / 4, reach_y + rim / 2)) for side in (-1, 1))
    elif width >= SLOT_MM[0] + 60.0:
        holes += (_slot((0.0, reach_y + rim / 2)),)
    _check_land(process)
    cover_mm = _cover_mm(badge, process, clearance, sheet_top, screws)
    base = Plate("base", process.base_mm, -process.base_mm, outline, holes)
    frame = Plate("frame", frame_mm, 0.0, outline, (window, *holes))
    opening = _cover_opening(half_x - process.lip_reach_mm, reach_x, reach_y, spans)
    cover = Plate("cover", cover_mm, sheet_top, outline, (opening, *holes))
    return AcrylicPlan(
        base,
        frame,
        cover,
        page=(-half_x, -half_y, half_x, half_y),
        sheets=sheet_rects(badge),
        card_mm=card_mm,
        sheet_top=sheet_top,
        clearance_mm=clearance,
        twist_deg=_twist_deg(clearance, spans, 2 * half_y),
        squeeze_mm=sheet_top - frame_mm,
        screws=screws,
        screw_mm=process.base_mm + sheet_top + cover_mm + NUT_MM,
    )


def _rectangle(rect: Rect, *, radius: float = 0.0) -> Contour:
    x0, y0, x1, y1 = rect
    return Contour(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), (radius,) * 4)


def _circle(centre: Point, diameter: float) -> Contour:
    half = diameter / 2
    return _rectangle((centre[0] - half, centre[1] - half, centre[0] + half, centre[1] + half), radius=half)


def _slot(centre: Point) -> Contour:
    """A lanyard's slot, across."""
    x, y = SLOT_MM[0] / 2, SLOT_MM[1] / 2
    return _rectangle((centre[0] - x, centre[1] - y, centre[0] + x, centre[1] + y), radius=y)


def _cover_opening(inner: float, outer: float, top: float, spans: tuple[tuple[float, float], ...]) -> Contour:
    """The cover's window: as wide as the frame's, but for lips over the sheets' left and right edges."""
    right: list[Point] = [(outer, -top)]
    for low, high in spans:
        right += [(outer, low), (inner, low), (inner, high), (outer, high)]
    right.append((outer, top))
    corners = (*right, *((-x, y) for x, y in reversed(right)))
    # A sharp inner corner is where acrylic cracks.
    return Contour(corners, (0.6,) * len(corners))


def _screws(x: float, y: float) -> tuple[Point, ...]:
    """Four corners, and between them along left and right so many that no gap is wider than `SCREW_PITCH_MM`."""
    gaps = max(1, math.ceil(2 * y / SCREW_PITCH_MM))
    rows = [-y + 2 * y * k / gaps for k in range(gaps + 1)]
    return tuple((side * x, row) for row in rows for side in (-1, 1))


def _frame_mm(card_mm: float, sheet_top: float) -> float:
    """The thickest plate on sale that lets the cover reach the sheet."""
    fitting = [stock for stock in STOCK_MM if stock <= sheet_top - LEAST_SQUEEZE_MM + 1e-9]
    frame_mm = fitting[-1] if fitting else 0.0
    if frame_mm < card_mm + LEAST_GRIP_MM - 1e-9:
        thinnest = next(stock for stock in STOCK_MM if stock >= card_mm + LEAST_GRIP_MM - 1e-9)
        least_mm = round(thinnest + LEAST_SQUEEZE_MM - card_mm, 3)
        raise FabricationError(
            f"a lens sheet {sheet_top - card_mm:g} mm thick is too thin for a frame to hold it by its edge: the frame "
            f"must be {card_mm + LEAST_GRIP_MM:g} mm or thicker, and {sheet_top - LEAST_SQUEEZE_MM:g} mm or thinner; "
            f"give a lens sheet (--lens) of {least_mm:g} mm or more",
            least_mm=least_mm,
        )
    if sheet_top - frame_mm > MOST_SQUEEZE_MM:
        raise FabricationError(
            f"page and sheet together are {sheet_top:g} mm thick, and frames are sold up to {STOCK_MM[-1]:g} mm; give "
            f"a lens sheet (--lens) of {STOCK_MM[-1] - card_mm + MOST_SQUEEZE_MM:g} mm or less"
        )
    return frame_mm


def _twist_deg(clearance: float, spans: tuple[tuple[float, float], ...], height: float) -> float:
    """The most that page and sheet can turn against each other between upright register edges, degrees.

    A piece of length L between edges 2c farther apart than it is wide turns by 2c / L; page and sheet may do so in
    opposite ways.
    """
    shortest = min(high - low for low, high in spans)
    return math.degrees(2 * clearance * (1 / shortest + 1 / height))


def _clearance_mm(spans: tuple[tuple[float, float], ...], height: float, process: AcrylicProcess) -> float:
    """The wished clearance, or the largest that the allowed twist permits, in hundredths."""
    most = TWIST_DEG / _twist_deg(1.0, spans, height)
    if most < LASER_MM:
        raise FabricationError(
            f"the edges that hold page and lens are too short: with the {LASER_MM:g} mm of air that a laser needs, one "
            f"may turn on the other by {_twist_deg(LASER_MM, spans, height):.2f} degrees, and {TWIST_DEG:g} are "
            f"allowed; give a board (--size) of {math.ceil(height * LASER_MM / most):g} mm or more in height, wider in "
            "proportion",
            most_mm=most,
        )
    if process.clearance_mm is None:
        return min(math.floor(most * 100 + 1e-9) / 100, MOST_CLEARANCE_MM)
    if process.clearance_mm > most:
        raise FabricationError(
            f"with {process.clearance_mm:g} mm of air at each edge, page and lens may turn on each other by "
            f"{_twist_deg(process.clearance_mm, spans, height):.2f} degrees, and {TWIST_DEG:g} are allowed; give a "
            f"clearance_mm of {math.floor(most * 1000) / 1000:g} or less (--mount-figure), or a taller board (--size)",
            most_mm=most,
        )
    return process.clearance_mm


def _check_land(process: AcrylicProcess) -> None:
    """Check that the rim leaves enough acrylic around screws, slot and heads."""
    widest = max(process.hole_mm, SLOT_MM[1], HEAD_MM - LEAST_LAND_MM)
    if (land := (process.rim_mm - widest) / 2) < LEAST_LAND_MM:
        raise FabricationError(
            f"a rim of {process.rim_mm:g} mm leaves {land:.2f} mm next to its openings, {LEAST_LAND_MM:g} mm "
            f"are needed; give a rim_mm of {widest + 2 * LEAST_LAND_MM:g} or more (--mount-figure)",
            land_mm=land,
        )
    if process.hole_mm < THREAD_MM + 0.1:
        raise FabricationError(
            f"hole_mm={process.hole_mm:g} lets no M3 screw through; give {THREAD_MM + 0.1:g} or more (--mount-figure)"
        )


def _cover_mm(
    badge: Badge, process: AcrylicProcess, clearance: float, sheet_top: float, screws: tuple[Point, ...]
) -> float:
    """The thickest cover on sale that hides nothing.  Raises: FabricationError where not even the thinnest does."""
    for cover_mm in [stock for stock in reversed(STOCK_MM) if COVER_MM[0] <= stock <= COVER_MM[1]]:
        fault = sight_fault(
            badge,
            _obstacles(badge, process, clearance, sheet_top + cover_mm, screws),
            card_top=process.card_mm,
            sheet_top=sheet_top,
            play_mm=clearance,
            advice="take a smaller lip_reach_mm (--mount-figure)",
        )
        if fault is None:
            return cover_mm
    assert fault is not None
    over_mm = float(str(fault.details.get("over_mm", math.inf)))
    most_mm = math.floor((badge.lens.thickness_mm - over_mm) * 20) / 20 if math.isfinite(over_mm) else 0.0
    if most_mm <= 0:
        raise fault
    raise FabricationError(
        f"{str(fault).partition(';')[0]}; give a {front_word(badge)} of {most_mm:g} mm or less", **fault.details
    )


def _obstacles(
    badge: Badge, process: AcrylicProcess, clearance: float, top: float, screws: tuple[Point, ...]
) -> list[Obstacle]:
    """The cover's rim and lips, and the screws' heads on it."""
    half_x, half_y = half_board_mm(badge)
    x, y, rim = half_x + clearance, half_y + clearance, process.rim_mm
    found = [
        Obstacle("cover", (-x - rim, -y - rim, -x, y + rim), top),
        Obstacle("cover", (x, -y - rim, x + rim, y + rim), top),
        Obstacle("cover", (-x, y, x, y + rim), top),
        Obstacle("cover", (-x, -y - rim, x, -y), top),
    ]
    inner = half_x - process.lip_reach_mm
    for low, high in sheet_spans(badge):
        found += [
            Obstacle("cover's lip", (inner, low, x, high), top),
            Obstacle("cover's lip", (-x, low, -inner, high), top),
        ]
    half = HEAD_MM / 2
    found += [Obstacle("screw", (u - half, v - half, u + half, v + half), top + HEAD_HIGH_MM) for u, v in screws]
    return found
