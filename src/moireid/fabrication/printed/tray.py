"""The printed tray: a shallow box that holds board and lens sheet flat on each other, with no air between them.

The board (the page cut out, on card) lies on the tray's floor, and the lens sheet lies on the board.  Both slide in
together through the open top edge and stop at register edges: the board at the bottom rim, the sheet at two feet at
the lips' lower ends, and both at two stops on the left side, so that place and angle are the mount's.  Lips over the
left and right edge hold the sheet from the front.  Directly behind the lips, tongues in the back plate press the board
against the sheet.  They press nowhere else, because a force in the middle would bend the sheet.

The floor is a lattice of ribs (`openings`): the card lies on them, and on a border all round.  Beyond the tongues the
rim's sides are what keeps the tray flat.

The tray prints lying on its back, and needs no supports: a flat lip would be printed in mid-air and sag into the slot.
So lips and feet are level only over the clearance next to the board, which is less than a printed line, and from the
board's edge to their tips they rise by 45 degrees.  They touch the sheet at its very edge, and a sheet that was cut too
narrow rises by half of the width that is missing.  The springs make up for that.

With a thick sheet, the rim is high only below the lips.  Next to the markers a high rim would hide them, and there it
only has to hold the board.  The lips end as far from the markers as the camera's view needs.

Convention: the frame of `sight`, its origin on the tray's floor, so the plate behind the board has negative z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from moireid.badge import Badge, Point, Rect
from moireid.errors import FabricationError
from moireid.fabrication.printed.openings import MOST_HIGH_MM, RIB_MM, between, lattice, parted
from moireid.fabrication.process_figures import LEAST_LIP_MM, TWIST_DEG, MountProcess
from moireid.fabrication.sight import Obstacle, front_mm, half_board_mm, sheet_spans, sight_fault

#: A tongue's width, its greatest length, the slit round it (two nozzle lines), and its distance from the edge.
TONGUE_MM = (4.0, 20.0)
SLIT_MM = 0.8
#: A tongue shorter than this is too stiff for a spring.
LEAST_TONGUE_MM = 6.0
#: The floor is whole this far from the board's edge, and from its upper one; a tongue's root is in a bar so wide.
SHELF_MM, TOP_BAR_MM, ROOT_MM = 1.2, 5.0, 3.0
#: A pad's length, and how far from the board's edge it begins.
PAD_MM, PAD_REACH_MM = 3.0, 2.0
#: The shortest lip, and the step by which lips give way to the view of fringes.  It must hold a sheet that lies as far
#: to the side as the clearance lets it.
LEAST_REACH_MM, REACH_STEP_MM = 0.7, 0.1
#: A level step below a lip or a foot is at most this wide, less than a printed line.
LEVEL_MM = 0.4
#: A stop's length along the left side, and how it narrows at its upper end, as a share of the clearance that it fills.
STOP_MM, STOP_RAMP = 5.0, 3.0
#: Where the rim holds the board alone, it is this much higher than it; a step in the rim lower than the second figure
#: is left out.
SIDE_MM, LEAST_STEP_MM = 1.5, 0.5
#: The lips are shortened near the markers in steps of this.
LIP_STEP_MM = 0.5
#: A lanyard's strap is at least this wide.
LEAST_SLOT_MM = 10.0
ADVICE = "take a smaller lip_reach_mm or lip_mm (mount_mm), a thinner sheet, or a larger board (size_mm)"


@dataclass(frozen=True)
class TrayPlan:
    """The figures of a tray in its frame, before any solid is made.

    half_mm: half the board's width and height; out_x and bottom: outer faces of the rim; tab_top: of the tab, or of
    the tray where it has none; z figures: card_top, sheet_top, side_top (of rim and feet where there is no lip),
    rim_top (at the lips; the height of their lower faces at the board's edge), lip_top; reach_mm: of the lips over
    the board; chamfer: of their upper edges; spans: (low, high) rows in y of each sheet, from bottom to top; lips: rows
    that lips hold of them; slot_mm: a lanyard's slot, width and height; slots: the x of each one's middle, none without
    a tab.
    """

    half_mm: tuple[float, float]
    out_x: float
    bottom: float
    tab_top: float
    card_top: float
    sheet_top: float
    side_top: float
    rim_top: float
    lip_top: float
    reach_mm: float
    chamfer: float
    spans: tuple[tuple[float, float], ...]
    lips: tuple[tuple[float, float], ...]
    slot_mm: tuple[float, float]
    slots: tuple[float, ...]

    @property
    def stepped(self) -> bool:
        """Whether the rim is higher below the lips than elsewhere."""
        return self.side_top < self.rim_top

    def lip_rects(self, process: MountProcess) -> list[Rect]:
        """Lips and the rim below them, seen from the front, in pairs from bottom to top.

        The lowest covers the feet where these are as high as the rim.
        """
        inner = self.half_mm[0] - self.reach_mm
        lows = [low for low, _ in self.lips]
        lows[0] -= 0.0 if self.stepped else process.clearance_mm + process.wall_mm
        return _both_sides([(inner, low, self.out_x, high) for low, (_, high) in zip(lows, self.lips, strict=True)])

    def foot_rects(self, process: MountProcess) -> list[Rect]:
        """The two feet that the sheet rests on."""
        low = self.spans[0][0] - process.clearance_mm - process.wall_mm
        return _both_sides([(self.half_mm[0] - self.reach_mm, low, self.out_x, low + process.wall_mm)])

    @property
    def stop_rows(self) -> list[tuple[float, float]]:
        """Rows of the stops at the left: below the lower and the upper end of each lip."""
        long = [min(STOP_MM, (high - low) / 4) for low, high in self.lips]
        ends = [((low, low + mm), (high - mm, high)) for (low, high), mm in zip(self.lips, long, strict=True)]
        return [rows for pair in ends for rows in pair]

    def tongue_rects(self) -> list[Rect]:
        """The right-hand tongues, each with its root at the top and its free end at the bottom."""
        outer = self.half_mm[0] - SLIT_MM
        rects: list[Rect] = []
        for low, high in self.lips:
            length = min(TONGUE_MM[1], 0.6 * (high - low))
            count = 2 if high - low > 3 * TONGUE_MM[1] else 1
            for k in range(count):
                middle = low + (high - low) * (k + 0.5) / count
                rects.append((outer - TONGUE_MM[0], middle - length / 2, outer, middle + length / 2))
        return rects

    def openings(self) -> list[Rect]:
        """Openings of the floor: a lattice between the tongues, and what is free above and below each of these."""
        x, y = self.half_mm
        low, high = -y + SHELF_MM, y - TOP_BAR_MM
        inner = x - TONGUE_MM[0] - 2 * SLIT_MM
        taken = [(y0 - SLIT_MM - RIB_MM, y1 + ROOT_MM) for _, y0, _, y1 in self.tongue_rects()]
        free = [part for span in between(low, high, taken) for part in parted(*span, MOST_HIGH_MM)]
        edges = _both_sides([(inner, y0, x - SHELF_MM, y1) for y0, y1 in free])
        return lattice((-inner + RIB_MM, low, inner - RIB_MM, high)) + edges

    def pad_rects(self) -> list[Rect]:
        """Where the springs touch the board: on the tongues' free ends, below the lips, left and right."""
        inner = self.half_mm[0] - PAD_REACH_MM
        return _both_sides([(inner, y0, x1, y0 + min(PAD_MM, (y1 - y0) / 2)) for _, y0, x1, y1 in self.tongue_rects()])


def plan_tray(badge: Badge, process: MountProcess, *, slots: int = 2) -> TrayPlan:
    """The figures of a badge's tray, checked.

    Parameters
    ----------
    slots : int
        Wished number of lanyard slots, 0 for no tab; a narrow board gets one instead of two.

    Raises
    ------
    FabricationError
        Where a lip or the rim would hide fringes or markers, the board is too small for tab or springs, or the
        register edges are too short to keep page and lens parallel.
    """
    half = half_board_mm(badge)
    sheet_top = process.card_mm + process.adhesive_mm + front_mm(badge, process.film_mm)
    rim_top = sheet_top + process.depth_clearance_mm
    side_top = process.card_mm + SIDE_MM
    rim_mm = process.clearance_mm + process.wall_mm
    spans = sheet_spans(badge)
    slot_mm, places = slots_in(2 * half[0], process, slots) if slots else (process.slot_mm, ())
    plan = TrayPlan(
        half_mm=half,
        out_x=half[0] + rim_mm,
        bottom=-half[1] - rim_mm,
        tab_top=half[1] + (4 * process.wall_mm + slot_mm[1] if slots else 0.0),
        card_top=process.card_mm,
        sheet_top=sheet_top,
        side_top=side_top if rim_top - side_top >= LEAST_STEP_MM else rim_top,
        rim_top=rim_top,
        lip_top=rim_top + process.lip_reach_mm + process.lip_mm,
        reach_mm=process.lip_reach_mm,
        chamfer=process.lip_mm / 2,
        spans=spans,
        lips=spans,
        slot_mm=slot_mm,
        slots=places,
    )
    if process.lip_reach_mm < (least := max(LEAST_REACH_MM, process.clearance_mm + LEAST_LIP_MM)) - 1e-9:
        raise FabricationError(
            f"lip_reach_mm={process.lip_reach_mm:g} holds no sheet that lies {process.clearance_mm:g} mm to the side; "
            f"give {least:g} mm or more (mount_mm)",
            least_mm=least,
        )
    if (twist := seated_twist_deg(plan, process)) > TWIST_DEG:
        raise FabricationError(
            f"on register edges {2 * half[0]:g} mm apart a print off by {process.seat_mm:g} mm turns the sheet by "
            f"{twist:.2f} degrees, allowed are {TWIST_DEG:g}; give a smaller seat_mm (mount_mm) or "
            "a wider board (size_mm)",
            twist_deg=twist,
        )
    return _in_sight(badge, plan, process)


def _in_sight(badge: Badge, plan: TrayPlan, process: MountProcess) -> TrayPlan:
    """The plan with its lips drawn back from the fringes, and shortened near the markers, as far as a camera needs.

    Raises: FabricationError where something still hides a target, or the shortened lips have no room for a spring.
    """
    _check_springs(plan)
    least_mm = max(LEAST_REACH_MM, process.clearance_mm + LEAST_LIP_MM) - 1e-9
    while (
        fault := sight_fault(
            badge,
            _obstacles(plan, process),
            card_top=plan.card_top,
            sheet_top=plan.sheet_top,
            play_mm=process.clearance_mm,
            advice=ADVICE,
        )
    ) is not None:
        if plan.reach_mm - REACH_STEP_MM >= least_mm:
            reach = round(plan.reach_mm - REACH_STEP_MM, 3)
            plan = replace(plan, reach_mm=reach, lip_top=plan.rim_top + reach + process.lip_mm)
            continue
        shorter = replace(plan, lips=tuple((low + LIP_STEP_MM, high - LIP_STEP_MM) for low, high in plan.lips))
        if not plan.stepped or _shortest_spring_mm(shorter) < LEAST_TONGUE_MM:
            raise fault
        plan = shorter
    return plan


def _obstacles(plan: TrayPlan, process: MountProcess) -> list[Obstacle]:
    """The parts of the tray next to the badge."""
    obstacles = [Obstacle("rim", rect, plan.side_top) for rect in _rim_rects(plan, process)]
    obstacles += [Obstacle("foot", rect, plan.side_top) for rect in plan.foot_rects(process)]
    for x0, y0, x1, y1 in plan.lip_rects(process):
        # A lip's chamfer has two edges that can hide something: the inner lower one and the outer upper one.
        inner = (x0, y0, x1 - plan.chamfer, y1) if x0 < 0 else (x0 + plan.chamfer, y0, x1, y1)
        obstacles.append(Obstacle("lip", (x0, y0, x1, y1), plan.lip_top - plan.chamfer))
        obstacles.append(Obstacle("lip", inner, plan.lip_top))
    return obstacles


def seated_twist_deg(plan: TrayPlan, process: MountProcess) -> float:
    """Twist of page against lens when both touch their register edges, the print's errors adding up, degrees."""
    return math.degrees(math.atan2(2 * process.seat_mm, 2 * plan.half_mm[0] - plan.reach_mm))


def slots_in(width: float, process: MountProcess, slots: int) -> tuple[tuple[float, float], tuple[float, ...]]:
    """A lanyard's slot, width and height, and the x of each slot's middle, on a board so wide, mm.

    The slot has the wished width, or is narrower where the board has less room: the tab's feet and their fillets must
    fit on the tray's upper edge.  Two slots are as far apart as that edge has room for, because a badge that hangs from
    one point turns about its cord, and that moves the fringes as a camera's motion does.

    Raises
    ------
    FabricationError
        Where the board is too narrow for any strap.
    """
    margins_mm = 10 * process.wall_mm - 2 * (process.clearance_mm + process.wall_mm)
    least_mm = LEAST_SLOT_MM + margins_mm
    if width < least_mm - 1e-6:
        raise FabricationError(
            f"a board {width:g} mm wide is narrower than the lanyard's tab; give one of {least_mm:.1f} mm or more "
            "(size_mm), or a stand (mount)",
            least_mm=least_mm,
        )
    # Two slots share the room, with two walls between them, where both can be wide enough for a strap.
    half_mm = (width - margins_mm - 2 * process.wall_mm) / 2
    most_mm = half_mm if slots == 2 and half_mm >= LEAST_SLOT_MM else width - margins_mm
    slot_mm = min(process.slot_mm[0], most_mm)
    out = width / 2 - (5 * process.wall_mm - process.clearance_mm - process.wall_mm) - slot_mm / 2
    alone = slots < 2 or 2 * out - slot_mm < 2 * process.wall_mm - 1e-6
    return (slot_mm, process.slot_mm[1]), (0.0,) if alone else (-out, out)


def _shortest_spring_mm(plan: TrayPlan) -> float:
    return min(y1 - y0 for _, y0, _, y1 in plan.tongue_rects())


def _check_springs(plan: TrayPlan) -> None:
    """Check that the springs are long enough.  Raises: FabricationError."""
    if (shortest := _shortest_spring_mm(plan)) < LEAST_TONGUE_MM - 1e-6:
        raise FabricationError(
            f"the sheet's shortest rows leave springs of {shortest:.1f} mm, and {LEAST_TONGUE_MM:g} mm are needed to "
            f"press it on the page; give gratings of {LEAST_TONGUE_MM / 0.6:g} mm or more on a larger board (size_mm)",
            least_mm=LEAST_TONGUE_MM / 0.6,
        )


def _both_sides(rects: list[Rect]) -> list[Rect]:
    """Rectangles on the right, each followed by its mirror image on the left."""
    return [rect for x0, y0, x1, y1 in rects for rect in ((x0, y0, x1, y1), (-x1, y0, -x0, y1))]


def _rim_rects(plan: TrayPlan, process: MountProcess) -> list[Rect]:
    """The rim's left, right and bottom side, seen from the front."""
    in_x, top = plan.out_x - process.wall_mm, plan.half_mm[1]
    left, right = (-plan.out_x, plan.bottom, -in_x, top), (in_x, plan.bottom, plan.out_x, top)
    return [left, right, (-plan.out_x, plan.bottom, plan.out_x, plan.bottom + process.wall_mm)]


def tab_outline(slots: tuple[float, ...], slot_mm: float, low: float, high: float, wall_mm: float) -> list[Point]:
    """Corners of the tabs that hold slots of a width, from right to left along the edge that they rise from.

    Slots that are near each other share a tab.
    """
    half, foot = slot_mm / 2 + 2 * wall_mm, 2 * wall_mm
    ends = [(x - half, x + half) for x in slots]
    # Each foot is two walls wider on both sides, and rounded.
    if len(ends) == 2 and ends[1][0] - ends[0][1] < 6 * wall_mm:
        ends = [(ends[0][0], ends[1][1])]
    return [
        corner for x0, x1 in reversed(ends) for corner in ((x1 + foot, low), (x1, high), (x0, high), (x0 - foot, low))
    ]
