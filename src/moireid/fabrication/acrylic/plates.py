"""The acrylic stack: base plate, frame and cover, cut by laser from plates that every shop has, and held by M3 screws.

The page is inside the frame, on so many layers of card that page and sheet reach above the frame by some tenths of a
millimetre (`squeeze_mm`).  Page and lens sheet fit between the frame's sides with so little air that they cannot turn
against each other by more than the code tolerates.

A film between frame and cover has lips that come over the sheet's left and right edge.  When the screws are tight the
cover holds the film flat on the frame, and the sheet bends its lips up: they are springs all along both edges, which
press the sheet on the page.  The cover is set back from the board as far as the camera's view of fringes and markers
needs, with the screws' heads (M3 button heads, ISO 7380) on it.

Convention: the frame of `sight`, its origin below the page: the base and the frame begin where the layers of card do.
Contours are finished edges, without kerf, and
run anticlockwise, holes too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

from moireid.badge import Badge, Point, Rect
from moireid.errors import FabricationError
from moireid.fabrication.acrylic.contours import Contour
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

#: M3 button head, ISO 7380: diameter and height; the thread, and its nut's height (ISO 4032).
HEAD_MM, HEAD_HIGH_MM, THREAD_MM, NUT_MM = 5.7, 1.65, 3.0, 2.4
#: Screws are no farther apart than this along an edge that presses, or the cover would bow.
SCREW_PITCH_MM = 90.0
#: How far page and sheet must reach above the frame, so that they bend the film's lips, and at most, so that the lips
#: are not bent for good; and how much of the sheet's edge the frame must hold at least.
LEAST_SQUEEZE_MM, MOST_SQUEEZE_MM, LEAST_GRIP_MM = 0.15, 0.6, 0.2
#: At most so many plates make a frame, and so many layers of card are below the page.
MOST_FRAMES, MOST_LAYERS = 3, 20
#: The laser's own error of place, mm: a clearance must not be smaller.
LASER_MM, MOST_CLEARANCE_MM = 0.05, 0.15
#: The cover is set back from the board's edge by this, at least and at most, and in these steps.  From its edge to the
#: sheet's the film is free to bend.
SETBACK_MM, SETBACK_STEP_MM = (2.5, 15.0), 0.5
SLOT_MM = (16.0, 4.0)
#: Radii of the outline's corners, and of inner ones: a sharp inner corner is where acrylic cracks and film tears.
OUTER_RADIUS_MM, CORNER_MM = 4.0, 0.6


@dataclass(frozen=True)
class Plate:
    """One sheet to cut: its outline and openings as finished, and where it lies in the stack, mm."""

    name: str
    thickness_mm: float
    low_mm: float
    outline: Contour
    openings: tuple[Contour, ...]

    @property
    def stock(self) -> str:
        """What it is cut from: a word for files and layers."""
        return f"{'film' if self.name == 'lips' else 'acrylic'}-{self.thickness_mm:g}mm"

    def cuts(self, kerf_mm: float) -> tuple[Contour, ...]:
        """The laser's paths, outline first: half the kerf outside the outline and inside each opening.

        Raises: FabricationError as `Contour.grown`.
        """
        return (self.outline.grown(kerf_mm / 2), *(opening.grown(-kerf_mm / 2) for opening in self.openings))


@dataclass(frozen=True)
class AcrylicPlan:
    """The stack of a badge.

    base, frames, cover: the plates, of which several make a frame that one does not; lips: the film between frames and
    cover; layers, pad_mm: how many layers of card are below the page, and their thickness together; sheets: each lens
    sheet's rectangle; page: the board's; card_mm and sheet_top: the page's thickness and the lenses' height;
    clearance_mm: at each register edge; squeeze_mm: how far the sheet is above the frame; screws: places of the M3
    screws; screw_mm: their least length below the head.
    """

    base: Plate
    frames: tuple[Plate, ...]
    lips: Plate
    cover: Plate
    layers: int
    pad_mm: float
    page: Rect
    sheets: tuple[Rect, ...]
    card_mm: float
    sheet_top: float
    clearance_mm: float
    squeeze_mm: float
    screws: tuple[Point, ...]
    screw_mm: float

    @property
    def plates(self) -> tuple[Plate, ...]:
        """What is cut by laser, from behind to the front."""
        return (self.base, *self.frames, self.lips, self.cover)

    @property
    def stocks(self) -> tuple[str, ...]:
        """What is cut by laser is cut from these."""
        return tuple(dict.fromkeys(plate.stock for plate in self.plates))

    @property
    def drawings(self) -> dict[str, tuple[str, ...]]:
        """The laser's drawings by their files' names, and the stocks on each: all on one, and each on its own."""
        own = {f"acrylic-{stock.removeprefix('acrylic-')}": (stock,) for stock in self.stocks}
        return {"acrylic": self.stocks, **own}


def plan_acrylic(badge: Badge, process: AcrylicProcess | None = None) -> AcrylicPlan:
    """The acrylic stack of a badge, checked: register, grip, view and the land between cuts.

    Its cover is set back from the board's edge by the least that hides nothing.
    Raises: FabricationError with what, got, allowed and the next step.
    """
    process = process or AcrylicProcess()
    half_x, half_y = half_board_mm(badge)
    spans = sheet_spans(badge)
    # An adhesive lies on the card, and the sheet on it.
    card_mm = process.card_mm + process.adhesive_mm
    sheet_top = card_mm + front_mm(badge, process.film_mm)
    frame = _frame(card_mm, sheet_top, process.card_mm)
    clearance = _clearance_mm(spans, 2 * half_y, process)
    find_fault = partial(
        sight_fault,
        badge,
        card_top=process.card_mm,
        sheet_top=sheet_top,
        play_mm=clearance,
        advice="take a smaller lip_reach_mm (mount_mm)",
    )
    inner, outer = half_x - process.lip_reach_mm, half_x + clearance
    lips = [rect for low, high in spans for rect in ((inner, low, outer, high), (-outer, low, -inner, high))]
    if (fault := find_fault([Obstacle("film's lip", rect, sheet_top + process.lips_mm) for rect in lips])) is not None:
        raise _thinner_front(badge, fault)
    least, most = SETBACK_MM
    for k in range(math.ceil((most - least) / SETBACK_STEP_MM) + 1):
        plan = _stack(badge, process, frame, sheet_top, clearance, least + k * SETBACK_STEP_MM)
        if (fault := find_fault(_before_board(plan))) is None:
            return plan
    assert fault is not None
    raise fault


def _stack(
    badge: Badge,
    process: AcrylicProcess,
    frame: tuple[int, float, int],
    sheet_top: float,
    clearance: float,
    setback: float,
) -> AcrylicPlan:
    """The stack whose cover is set back by so much.

    Parameters: frame: as `_frame` gives it; sheet_top: the lenses' height; clearance: at each register edge, mm.
    Raises: FabricationError where the holes are too small for the screws.
    """
    half_x, half_y = half_board_mm(badge)
    count, frame_mm, layers = frame
    pad_mm = layers * process.card_mm
    reach_x, reach_y = half_x + clearance, half_y + clearance
    rim = _rim_mm(process, setback - clearance)
    outline = _rectangle(reach_x + rim, reach_y + rim, OUTER_RADIUS_MM)
    middle = (setback + clearance + rim) / 2
    screws = _screws(half_x + middle, half_y + middle)
    half_hole, (slot_x, slot_y) = process.hole_mm / 2, (side / 2 for side in SLOT_MM)
    holes = tuple(_rectangle(half_hole, half_hole, half_hole, screw) for screw in screws)
    width = 2 * (reach_x + rim)
    # A badge that hangs from two points cannot turn about its cord, which would move the fringes.
    slots = (-width / 4, width / 4) if width >= 2 * SLOT_MM[0] + 60.0 else (0.0,) if width >= SLOT_MM[0] + 60.0 else ()
    holes += tuple(_rectangle(slot_x, slot_y, slot_y, (x, half_y + middle)) for x in slots)
    base = Plate("base", process.base_mm, -pad_mm - process.base_mm, outline, holes)
    window = _rectangle(reach_x, reach_y)
    frames = tuple(
        Plate(f"frame-{k + 1}" if k else "frame", frame_mm, k * frame_mm - pad_mm, outline, (window, *holes))
        for k in range(count)
    )
    opening = _lips_opening(half_x - process.lip_reach_mm, reach_x, reach_y, sheet_spans(badge))
    lips = Plate("lips", process.lips_mm, sheet_top, outline, (opening, *holes))
    cover_window = _rectangle(half_x + setback, half_y + setback, CORNER_MM)
    cover = Plate("cover", STOCK_MM[0], sheet_top + process.lips_mm, outline, (cover_window, *holes))
    return AcrylicPlan(
        base,
        frames,
        lips,
        cover,
        layers=layers,
        pad_mm=pad_mm,
        page=(-half_x, -half_y, half_x, half_y),
        sheets=sheet_rects(badge),
        card_mm=process.card_mm + process.adhesive_mm,
        sheet_top=sheet_top,
        clearance_mm=clearance,
        squeeze_mm=sheet_top + pad_mm - count * frame_mm,
        screws=screws,
        screw_mm=process.base_mm + pad_mm + sheet_top + process.lips_mm + STOCK_MM[0] + NUT_MM,
    )


def _before_board(plan: AcrylicPlan) -> list[Obstacle]:
    """The cover round its window, and the screws' heads on it."""
    out_x, out_y = plan.cover.outline.bounds[2:]
    x, y = plan.cover.openings[0].bounds[2:]
    top, head = plan.cover.low_mm + plan.cover.thickness_mm, HEAD_MM / 2
    sides = [(-out_x, -out_y, -x, out_y), (x, -out_y, out_x, out_y), (-x, y, x, out_y), (-x, -out_y, x, -y)]
    heads = [(x - head, y - head, x + head, y + head) for x, y in plan.screws]
    return [
        *(Obstacle("cover", side, top) for side in sides),
        *(Obstacle("screw", rect, top + HEAD_HIGH_MM) for rect in heads),
    ]


def _rectangle(half_x: float, half_y: float, radius: float = 0.0, at: Point = (0.0, 0.0)) -> Contour:
    """A rectangle about a place; with radii of half its height a slot, or a circle."""
    corners = ((-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y))
    return Contour(corners, (radius,) * 4).moved(*at)


def _lips_opening(inner: float, outer: float, top: float, spans: tuple[tuple[float, float], ...]) -> Contour:
    """The film's window: as wide as the frame's, but for lips over the sheets' left and right edges."""
    right: list[Point] = [(outer, -top)]
    for low, high in spans:
        right += [(outer, low), (inner, low), (inner, high), (outer, high)]
    right.append((outer, top))
    corners = (*right, *((-x, y) for x, y in reversed(right)))
    return Contour(corners, (CORNER_MM,) * len(corners))


def _screws(x: float, y: float) -> tuple[Point, ...]:
    """Four corners, and between them along left and right so many that no gap is wider than `SCREW_PITCH_MM`."""
    gaps = max(1, math.ceil(2 * y / SCREW_PITCH_MM))
    rows = [-y + 2 * y * k / gaps for k in range(gaps + 1)]
    return tuple((side * x, row) for row in rows for side in (-1, 1))


def _frame(card_mm: float, sheet_top: float, layer_mm: float) -> tuple[int, float, int]:
    """How many plates make the frame, their thickness, and how many layers of card are below the page.

    Of those that leave the right squeeze and hold the sheet's edge, the one of fewest plates, and then fewest layers.
    """
    fitting = []
    for count in range(1, MOST_FRAMES + 1):
        for stock in STOCK_MM:
            for layers in range(MOST_LAYERS + 1):
                # How high the frame is above the page's underside.
                high = count * stock - layers * layer_mm
                held = high >= card_mm + LEAST_GRIP_MM - 1e-9
                if held and LEAST_SQUEEZE_MM - 1e-9 <= sheet_top - high <= MOST_SQUEEZE_MM + 1e-9:
                    fitting.append((count, layers, stock))
    if fitting:
        count, layers, stock = min(fitting)
        return count, stock, layers
    least_mm, most_mm = LEAST_GRIP_MM + LEAST_SQUEEZE_MM, MOST_FRAMES * STOCK_MM[-1]
    if sheet_top > most_mm:
        raise FabricationError(
            f"page and sheet together are {sheet_top:g} mm thick, and {MOST_FRAMES} plates of {STOCK_MM[-1]:g} mm make "
            f"a frame of {most_mm:g} mm; give a lens sheet (lens) of {most_mm - card_mm + MOST_SQUEEZE_MM:g} mm or "
            "less"
        )
    raise FabricationError(
        f"a lens sheet {sheet_top - card_mm:g} mm thick is too thin for a frame to hold it by its edge: it must reach "
        f"{LEAST_GRIP_MM:g} mm into the frame and {LEAST_SQUEEZE_MM:g} mm above it; give a lens sheet (lens) of "
        f"{least_mm:g} mm or more",
        least_mm=least_mm,
    )


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
            f"allowed; give a board (size_mm) of {math.ceil(height * LASER_MM / most):g} mm or more in height, wider "
            "in proportion",
            most_mm=most,
        )
    if process.clearance_mm is None:
        return min(math.floor(most * 100 + 1e-9) / 100, MOST_CLEARANCE_MM)
    if process.clearance_mm > most:
        raise FabricationError(
            f"with {process.clearance_mm:g} mm of air at each edge, page and lens may turn on each other by "
            f"{_twist_deg(process.clearance_mm, spans, height):.2f} degrees, and {TWIST_DEG:g} are allowed; give a "
            f"clearance_mm of {math.floor(most * 1000) / 1000:g} or less (mount_mm), or a taller board (size_mm)",
            most_mm=most,
        )
    return process.clearance_mm


def _rim_mm(process: AcrylicProcess, inside_mm: float) -> float:
    """The frame's width: the wished one, or what the cover needs, which begins so much farther out than the frame.

    Raises: FabricationError where the holes are too small for the screws.
    """
    if process.hole_mm < THREAD_MM + 0.1:
        raise FabricationError(
            f"hole_mm={process.hole_mm:g} lets no M3 screw through; give {THREAD_MM + 0.1:g} or more (mount_mm)"
        )
    widest = max(process.hole_mm, SLOT_MM[1], HEAD_MM - LEAST_LAND_MM)
    return max(process.rim_mm, inside_mm + widest + 2 * LEAST_LAND_MM)


def _thinner_front(badge: Badge, fault: FabricationError) -> FabricationError:
    """The fault of a film's lip that hides something, with the sheet under which it would not, if there is any."""
    over_mm = float(str(fault.details.get("over_mm", math.inf)))
    most_mm = math.floor((badge.lens.thickness_mm - over_mm) * 20) / 20 if math.isfinite(over_mm) else 0.0
    if most_mm <= 0:
        return fault
    return FabricationError(
        f"{str(fault).partition(';')[0]}; give a {front_word(badge)} of {most_mm:g} mm or less", **fault.details
    )
