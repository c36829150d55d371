"""The snap-in holder: a finished badge, its sheet fixed on the card, is pressed in from the front and held by catches.

A catch is a piece of the side wall, cut free from the back plate and at one end, with a nose that comes over the
badge's edge.  It bends outwards in the plane of the print, so its layers run along it and do not part.  Its nose has a
ramp above, which the badge presses aside, and rises by 45 degrees below: so it prints without supports, and a thumb
through an opening of the back pushes the badge out again.

Strain of a catch: `1.5 t y / L^2`, of a straight cantilever that is bent at its end (t its thickness, y how far, L its
length); the force there is `E b t^3 y / (4 L^3)` (b its depth, E the modulus).  A nose of 45 degrees and a friction mu
make of it `(1 + mu) / (1 - mu)` times as much along the badge's way.  Source: Bayer, Snap-Fit Joints for Plastics, part
B; BASF, Snap-Fit Design Manual, part III.  How far its root bends is left out there, so true strain is less.

Convention: the frame of `sight`, its origin on the holder's floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from moireid.badge import Badge, Point, Rect
from moireid.errors import FabricationError
from moireid.fabrication.printed.openings import lattice
from moireid.fabrication.printed.tray import ADVICE, slots_in, tab_outline
from moireid.fabrication.printed.tray_shape import block, corners, drawn_out, rounded_plate
from moireid.fabrication.process_figures import MountProcess
from moireid.fabrication.sight import Obstacle, check_sight, front_mm, half_board_mm, sheet_spans
from moireid.fabrication.solids import cad_package, overlap_mm3

#: A catch: its thickness (four lines of a 0.4 mm nozzle), from its root to its nose's middle, its nose's length, and
#: the nose's upright face.
CATCH_MM, REACH_MM, NOSE_MM, LAND_MM = 1.6, 18.0, 4.0, 0.3
#: Slits that free it are two lines wide; the wall next to it is a line farther out.
SLIT_MM, PROUD_MM = 0.8, 0.4
#: Height of the rim above the sheet.
RIM_MM = 0.3
#: One catch for so much of the sheet's edge, which leaves 3 mm of whole wall between two; at most so many on a side.
EDGE_A_CATCH_MM, MOST_CATCHES = 24.0, 4
#: Strain at yield of the weakest plastic in question, PLA printed along its lines: assumed from a seller's table, not
#: measured in this project; PETG bears more.  Of it an amorphous plastic bears 70 %, and 60 % of that where it is bent
#: again and again.  Source of both shares: Bayer, Snap-Fit Joints for Plastics, as others quote it.
YIELD_STRAIN = 0.015
MOST_STRAIN = 0.6 * 0.7 * YIELD_STRAIN
#: What a catch must hold of a badge that is pushed to the other side, mm.
LEAST_BITE_MM = 0.3
#: Modulus of printed PETG, which is the softer of both, N/mm^2, and friction on the nose: both assumed, and on the low
#: side, so that a real holder holds at least as well as reported.
MODULUS_N_MM2, FRICTION = 1500.0, 0.2
#: The back is whole this far from the slits that free the catches, and from the pocket's upper and lower edge.
SHELF_MM = 2.4
#: A badge may be thicker than its parts by this, of tape or glue, mm.
THICKER_MM = 0.05
#: Where surfaces touch, more than this is interference.
TOUCH_MM3 = 0.01


@dataclass(frozen=True)
class SnapPlan:
    """The figures of a snap-in holder in its frame, before any solid is made.

    half_mm: half the board's width and height; out_mm: outer faces of the rim, right and top; tab_top: of the tab;
    z figures: card_top, sheet_top, level (of a nose's lower face at the board's edge), rim_top, nose_top; clearance_mm:
    air on each side of the board; bite_mm: how far a nose comes over it; spans: (low, high) rows of each sheet;
    catches: the y of each nose's middle, the same on both sides; slot_mm, slots: as `TrayPlan`.
    """

    half_mm: tuple[float, float]
    out_mm: tuple[float, float]
    tab_top: float
    card_top: float
    sheet_top: float
    level: float
    rim_top: float
    nose_top: float
    clearance_mm: float
    bite_mm: float
    spans: tuple[tuple[float, float], ...]
    catches: tuple[float, ...]
    slot_mm: tuple[float, float]
    slots: tuple[float, ...]

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height from the front."""
        return 2 * self.out_mm[0], self.tab_top + self.out_mm[1]

    @property
    def bent_mm(self) -> float:
        """How far a catch is bent when the badge passes that lies wholly to its side."""
        return self.bite_mm + self.clearance_mm

    @property
    def strain(self) -> float:
        """The greatest strain of a catch.  Source: module docstring."""
        return 1.5 * CATCH_MM * self.bent_mm / REACH_MM**2

    def hold_n(self, back_mm: float) -> float:
        """The least force that pushes a badge out that lies in the middle, N; back_mm: of the plate, which is cut too.

        Source: module docstring.
        """
        depth = self.nose_top + back_mm
        bend_n = MODULUS_N_MM2 * depth * CATCH_MM**3 * self.bite_mm / (4 * REACH_MM**3)
        return 2 * len(self.catches) * bend_n * (1 + FRICTION) / (1 - FRICTION)

    @property
    def inner_x(self) -> float:
        """The catches' inner face."""
        return self.half_mm[0] + self.clearance_mm

    def openings(self) -> list[Rect]:
        """Openings of the back: a lattice, through which a thumb pushes the badge out."""
        x = self.inner_x - SLIT_MM - SHELF_MM
        y = self.half_mm[1] + self.clearance_mm - SHELF_MM
        return lattice((-x, -y, x, y))

    def nose_rects(self) -> list[Rect]:
        """Noses and the catches below them, seen from the front, right and left."""
        x0, x1 = self.half_mm[0] - self.bite_mm, self.inner_x + CATCH_MM
        rows = [(y - NOSE_MM / 2, y + NOSE_MM / 2) for y in self.catches]
        return [rect for low, high in rows for rect in ((x0, low, x1, high), (-x1, low, -x0, high))]

    def nose_profile(self, low: float) -> list[Point]:
        """A right-hand nose with the catch below it from the height `low` on, as (x, z)."""
        half, tip = self.half_mm[0], self.half_mm[0] - self.bite_mm
        return [
            (self.inner_x + CATCH_MM, low),
            (self.inner_x, low),
            (self.inner_x, self.level),
            (half, self.level),
            (tip, self.level + self.bite_mm),
            (tip, self.level + self.bite_mm + LAND_MM),
            (self.inner_x, self.nose_top),
            (self.inner_x + CATCH_MM, self.nose_top),
        ]


def plan_snap(badge: Badge, process: MountProcess) -> SnapPlan:
    """The figures of a badge's snap-in holder, checked.

    Raises: FabricationError where a nose or the rim would hide fringes or markers, a catch would be bent too far or
        holds too little, or the board has no room for catches or lanyard.
    """
    half, air, bite, wall = half_board_mm(badge), process.snap_clearance_mm, process.bite_mm, process.wall_mm
    sheet_top = process.card_mm + process.adhesive_mm + front_mm(badge, process.film_mm)
    level = sheet_top + process.depth_clearance_mm
    spans = sheet_spans(badge)
    out = half[0] + air + max(wall, CATCH_MM + PROUD_MM), half[1] + air + wall
    slot_mm, slots = slots_in(2 * half[0], process, 2)
    plan = SnapPlan(
        half_mm=half,
        out_mm=out,
        tab_top=out[1] + 4 * wall + slot_mm[1],
        card_top=process.card_mm,
        sheet_top=sheet_top,
        level=level,
        rim_top=sheet_top + RIM_MM,
        nose_top=level + 2 * bite + LAND_MM + air,
        clearance_mm=air,
        bite_mm=bite,
        spans=spans,
        catches=tuple(y for low, high in spans for y in _catches(low, high)),
        slot_mm=slot_mm,
        slots=slots,
    )
    if bite - air < LEAST_BITE_MM:
        raise FabricationError(
            f"bite_mm={bite:g} holds a badge that lies {air:g} mm to the side by {bite - air:.2f} mm, "
            f"{LEAST_BITE_MM:g} mm are needed; give {LEAST_BITE_MM + air:g} mm or more (mount_mm)",
            least_mm=LEAST_BITE_MM + air,
        )
    if plan.strain > MOST_STRAIN:
        raise FabricationError(
            f"the holder's catches would be strained by {100 * plan.strain:.2f} %, allowed are "
            f"{100 * MOST_STRAIN:.2f} %; give a smaller bite_mm (mount_mm)",
            strain=plan.strain,
        )
    lowest, highest = plan.catches[0] - REACH_MM - SLIT_MM, plan.catches[-1] + NOSE_MM / 2 + SLIT_MM
    if lowest < -half[1] or highest > half[1]:
        raise FabricationError(
            f"a board {2 * half[1]:g} mm high has no room for the holder's catches, which are {REACH_MM:g} mm long; "
            "give a larger board (size_mm), or another mount (mount)"
        )
    check_sight(badge, _obstacles(plan), card_top=plan.card_top, sheet_top=sheet_top, play_mm=air, advice=ADVICE_SNAP)
    return plan


ADVICE_SNAP = ADVICE.replace("lip_reach_mm or lip_mm", "bite_mm")


def shape_snap(b3d: Any, plan: SnapPlan, process: MountProcess) -> Any:
    """The holder as a build123d Part."""
    (x, y), wall, back = plan.out_mm, process.wall_mm, process.back_mm
    tabs = tab_outline(plan.slots, plan.slot_mm[0], y, plan.tab_top, wall)
    radii = {-y: 1.5 * wall, y: wall / 2, plan.tab_top: 2 * wall}
    outline = [(-x, -y), (x, -y), (x, y), *tabs, (-x, y)]
    openings = [b3d.Wire.make_polygon(corners(rect)) for rect in plan.openings()]
    body = rounded_plate(b3d, outline, radii, plan.rim_top, process, openings)
    pocket_x, pocket_y, high = plan.inner_x, plan.half_mm[1] + plan.clearance_mm, plan.rim_top + 1.0
    gone = [block(b3d, (-pocket_x, -pocket_y, pocket_x, pocket_y), 0.0, high)]
    gone.append(block(b3d, (-x, y, x, plan.tab_top + 1.0), 0.0, high))
    slot = b3d.extrude(b3d.SlotOverall(*plan.slot_mm), 3 * back)
    slot_y = y + 2 * wall + plan.slot_mm[1] / 2
    gone += [slot.moved(b3d.Location((at, slot_y, -2 * back))) for at in plan.slots]
    for rect in freed_rects(plan):
        gone.append(block(b3d, rect, -2 * back, high))
    # A round end of the slit at the root spreads the strain.
    for at in plan.catches:
        for side in (-1, 1):
            end = (side * (plan.inner_x - SLIT_MM / 2), at - REACH_MM, 0.0)
            gone.append(b3d.Cylinder(SLIT_MM / 2, 2 * high + 4 * back).moved(b3d.Location(end)))
    noses = [drawn_out(b3d, plan.nose_profile(-back), rect) for rect in plan.nose_rects()]
    return body - gone + noses


def freed_rects(plan: SnapPlan) -> list[Rect]:
    """What is cut away round the catches: the slit behind, the gap at the free end, and a line of the outer face."""
    found = []
    inner, outer, out = plan.inner_x, plan.inner_x + CATCH_MM, plan.out_mm[0] + 1.0
    for at in plan.catches:
        root, end = at - REACH_MM, at + NOSE_MM / 2
        for x0, y0, x1, y1 in (
            (inner - SLIT_MM, root, inner, end + SLIT_MM),
            (inner - SLIT_MM, end, out, end + SLIT_MM),
            (outer, root, out, end + SLIT_MM),
        ):
            found += [(x0, y0, x1, y1), (-x1, y0, -x0, y1)]
    return found


def check_snap(body: Any, plan: SnapPlan, process: MountProcess) -> None:
    """Check that a badge goes into the holder, is held, and comes out when its catches are bent.

    Parameters: body: the holder as a Manifold.
    Raises: FabricationError.
    """
    cube = cad_package("manifold3d").Manifold.cube
    grown = plan.clearance_mm - 0.01
    (x, y), top = plan.half_mm, plan.sheet_top + THICKER_MM

    def stack(more: float, low: float, high: float) -> Any:
        """Card and sheet, larger by `more` on each side, from a height to another above where they lie."""
        card = cube((2 * (x + more), 2 * (y + more), plan.card_top + high - low)).translate((-x - more, -y - more, low))
        for bottom, ceiling in plan.spans:
            sheet = cube((2 * (x + more), ceiling - bottom, top + high - low)).translate((-x - more, bottom, low))
            card += sheet
        return card

    def nose_box(rect: Rect) -> Any:
        """The room of a nose, from its lower face on."""
        x0, low, x1, high = rect
        return cube((x1 - x0, high - low, plan.nose_top)).translate((x0, low, plan.level - 0.05))

    # Bent catches: their noses are where they are pushed to.
    bent = body
    for rect in plan.nose_rects():
        nose = nose_box(rect)
        moved = (body ^ nose).translate((math.copysign(plan.bent_mm, rect[0]), 0, 0))
        bent = bent - nose + moved
    lifted = stack(0.0, 0.0, 0.0).translate((0, 0, LEAST_BITE_MM + process.depth_clearance_mm + 0.1))
    faults = {
        "has no room for a badge": overlap_mm3(stack(grown, 0.0, 0.0), body) > TOUCH_MM3,
        "lets a badge fall out": any(
            # Each nose alone must hold a badge that is pushed to the other side: one held on one side only tips out.
            overlap_mm3(lifted.translate((-math.copysign(grown, rect[0]), 0, 0)), body ^ nose_box(rect)) < TOUCH_MM3
            for rect in plan.nose_rects()
        ),
        "does not let a badge out when its catches are bent": overlap_mm3(stack(0.0, 0.0, 10.0), bent) > TOUCH_MM3,
    }
    for fault, found in faults.items():
        if found:
            raise FabricationError(
                f"the mount's holder {fault}; choose other process figures, and report this if the defaults fail"
            )


def _catches(low: float, high: float) -> list[float]:
    """The y of the noses on a sheet's edge."""
    count = min(max(int((high - low) // EDGE_A_CATCH_MM), 1), MOST_CATCHES)
    return [low + (high - low) * (k + 0.5) / count for k in range(count)]


def _obstacles(plan: SnapPlan) -> list[Obstacle]:
    """The parts of the holder next to the badge: rim, noses, and their tips, which are lower."""
    (x, y), (pocket_x, pocket_y) = plan.out_mm, (plan.inner_x, plan.half_mm[1] + plan.clearance_mm)
    sides = [(pocket_x, -y, x, y), (-x, -y, -pocket_x, y), (-x, pocket_y, x, y), (-x, -y, x, -pocket_y)]
    found = [Obstacle("rim", side, plan.rim_top) for side in sides]
    for x0, y0, x1, y1 in plan.nose_rects():
        found.append(Obstacle("catch", (x0, y0, x1, y1), plan.level + plan.bite_mm + LAND_MM))
        outer = (plan.inner_x, y0, x1, y1) if x0 > 0 else (x0, y0, -plan.inner_x, y1)
        found.append(Obstacle("catch", outer, plan.nose_top))
    return found
