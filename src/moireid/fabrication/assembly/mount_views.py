"""The parts of a mount in the exploded views: all that is printed or cut, as prisms.

Sizes and thicknesses come from the plans, so no CAD kernel is needed; fillets, springs and chamfers of the printed
parts are left out.

Convention: the frame of `sight`; parts from behind to the front.
"""

from __future__ import annotations

import math

from moireid.badge import Badge, Point
from moireid.fabrication.acrylic.plates import (
    HEAD_HIGH_MM,
    HEAD_MM,
    NUT_MM,
    THREAD_MM,
    AcrylicPlan,
    Contour,
    Plate,
)
from moireid.fabrication.assembly.exploded import (
    GAP,
    Loop,
    Part,
    Prism,
    box_loop,
    card_part,
    front_parts,
    plain_parts,
    project,
    signed_area,
)
from moireid.fabrication.printed.holders import HolderBody
from moireid.fabrication.printed.mount import MountPlan
from moireid.fabrication.printed.snap import SnapPlan
from moireid.fabrication.printed.tray import TrayPlan, tab_outline
from moireid.fabrication.process_figures import MountProcess

#: Gaps other than the usual one: screws need less; a clip and a tab need more, because the parts before them would hide
#: them.
SCREW_GAP, CLIP_GAP, TAB_GAP = 0.25, 1.05, 0.8
#: Across an M3 nut's corners, ISO 4032.
NUT_WIDE_MM = 6.35
_ARC_STEPS = 6


def printed_parts(badge: Badge, mount: MountPlan, process: MountProcess) -> list[Part]:
    """The printed mount with card and front, from behind to the front."""
    plan, holder = mount
    if isinstance(plan, SnapPlan):
        return [_snap(plan, process), *plain_parts(badge, process)]
    behind = [_holder(holder, plan)] if holder else []
    return [*behind, _tray(plan, process), *plain_parts(badge, process)]


def acrylic_parts(badge: Badge, plan: AcrylicPlan, film_mm: float, screw: str) -> list[Part]:
    """The acrylic stack, nuts and screws, from behind to the front; screw: what to call the screws' size."""
    count, bottom = len(plan.screws), -plan.base.thickness_mm
    nuts = tuple(Prism(_round(at, NUT_WIDE_MM, 6), bottom - NUT_MM, bottom) for at in plan.screws)
    top = plan.sheet_top + plan.cover.thickness_mm
    # The screws farther from the viewer come first, because the nearer ones cover them.
    far_first = sorted(plan.screws, key=lambda at: project((*at, 0.0))[1], reverse=True)
    screws = tuple(
        prism
        for at in far_first
        for prism in (
            Prism(_round(at, THREAD_MM), top - plan.screw_mm, top),
            Prism(_round(at, HEAD_MM), top, top + HEAD_HIGH_MM),
        )
    )
    base, frame, cover = (_plate(plate, plan) for plate in plan.plates)
    held = [card_part(badge, plan.card_mm), *front_parts(badge, plan.card_mm, film_mm)]
    below = Part(f"{count} nuts", "M3", nuts, 0.75, gap=SCREW_GAP, screws=plan.screws)
    above = Part(f"{count} screws", screw, screws, 0.75, gap=SCREW_GAP, screws=plan.screws)
    return [below, base, frame, *held, cover, above]


def _plate(plate: Plate, plan: AcrylicPlan) -> Part:
    high = plate.low_mm + plate.thickness_mm
    body = Prism(
        plate.outline.flat(_ARC_STEPS),
        plate.low_mm,
        high,
        tuple(opening.flat(_ARC_STEPS) for opening in plate.openings),
    )
    # As in `process_figures.STOCK_MM`: thin plates are sold as film.
    name = f"acrylic {plate.name}" if plate.thickness_mm > 0.5 else f"{plate.name} of film"
    return Part(name, f"{plate.thickness_mm:g} mm", (body,), 0.93, screws=plan.screws)


def _tray(plan: TrayPlan, process: MountProcess) -> Part:
    """Back plate with its tab, the rim on three sides, and the lips."""
    half_y, wall, x = plan.half_mm[1], process.wall_mm, plan.out_x
    tabs = tab_outline(plan.slots, plan.slot_mm[0], half_y, plan.tab_top, wall)
    outline = ((-x, plan.bottom), (x, plan.bottom), (x, half_y), *tabs, (-x, half_y))
    slots = _slots(plan.slot_mm, half_y + 2 * wall, plan.slots)
    inner = x - wall
    rim = (
        (-x, half_y),
        (-x, plan.bottom),
        (x, plan.bottom),
        (x, half_y),
        (inner, half_y),
        (inner, plan.bottom + wall),
        (-inner, plan.bottom + wall),
        (-inner, half_y),
    )
    prisms = [
        Prism(outline, -process.back_mm, 0.0, (*slots, *map(box_loop, plan.openings()))),
        Prism(rim, 0.0, plan.side_top),
    ]
    lips = plan.lip_rects(process)
    if plan.stepped:
        sides = [((inner, r[1], x, r[3]) if r[0] > 0 else (-x, r[1], -inner, r[3])) for r in lips]
        prisms += [Prism(box_loop(side), plan.side_top, plan.rim_top) for side in sides]
    prisms += [Prism(box_loop(lip), plan.rim_top, plan.lip_top) for lip in lips]
    size = f"{plan.lip_top + process.back_mm:.1f} mm deep, back {process.back_mm:g} mm"
    return Part("tray, 3D-printed", size, tuple(prisms), 0.88, gap=TAB_GAP if plan.slots else GAP)


def _slots(size: Point, low: float, middles: tuple[float, ...]) -> tuple[Loop, ...]:
    """Lanyard slots that begin at a height."""
    across, up = size[0] / 2, size[1] / 2
    box = ((-across, low), (across, low), (across, low + size[1]), (-across, low + size[1]))
    return tuple(Contour(box, (up,) * 4).moved(middle, 0.0).flat(_ARC_STEPS) for middle in middles)


def _snap(plan: SnapPlan, process: MountProcess) -> Part:
    """The snap-in holder: back plate with tab and hole, rim, and the catches' noses."""
    (x, y), wall = plan.out_mm, process.wall_mm
    tabs = tab_outline(plan.slots, plan.slot_mm[0], y, plan.tab_top, wall)
    outline = ((-x, -y), (x, -y), (x, y), *tabs, (-x, y))
    openings = (*_slots(plan.slot_mm, y + 2 * wall, plan.slots), *map(box_loop, plan.openings()))
    pocket_x, pocket_y = plan.inner_x, plan.half_mm[1] + plan.clearance_mm
    pocket = box_loop((-pocket_x, -pocket_y, pocket_x, pocket_y))
    prisms = [Prism(outline, -process.back_mm, 0.0, openings)]
    prisms.append(Prism(box_loop((-x, -y, x, y)), 0.0, plan.rim_top, (pocket,)))
    prisms += [Prism(box_loop(nose), plan.rim_top, plan.nose_top) for nose in plan.nose_rects()]
    size = f"{plan.nose_top + process.back_mm:.1f} mm deep, back {process.back_mm:g} mm"
    return Part("snap-in holder, 3D-printed", size, tuple(prisms), 0.88, gap=TAB_GAP)


def _holder(holder: HolderBody, plan: TrayPlan) -> Part:
    """Clip or stand as it is used, its profile drawn out across the badge."""
    points = holder.profile
    if holder.name == "stand":
        lean = math.radians(holder.lean_deg)
        sin, cos = math.sin(lean), math.cos(lean)
        points = tuple((plan.bottom - along * sin + up * cos, along * cos + up * sin) for along, up in points)
    loop = points if signed_area(points) > 0 else points[::-1]
    half = holder.width_mm / 2
    body = Prism(loop, -half, half, along_x=True)
    return Part(
        f"{holder.name}, 3D-printed",
        f"{holder.width_mm:g} mm wide",
        (body,),
        0.88,
        gap=CLIP_GAP if holder.name == "clip" else GAP,
    )


def _round(centre: Point, diameter: float, sides: int = 20) -> Loop:
    angles = [2 * math.pi * k / sides for k in range(sides)]
    return tuple((centre[0] + diameter / 2 * math.cos(a), centre[1] + diameter / 2 * math.sin(a)) for a in angles)
