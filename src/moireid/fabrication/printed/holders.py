"""The part that carries the tray: a lanyard through its tab, a clip hooked into the tab, or a stand on a table.

The lanyard needs nothing but the tab.  Clip and stand are second bodies, each a profile drawn out along x, printed
next to the tray and put on by hand: the clip's hook goes through the tab's slot from behind and the tab's bar drops
into it; the stand has a groove for the tray's bottom edge and a rest behind it.

Convention: the frame of `sight`.  A profile is drawn in (along, up): for the clip that is (y, z) of the frame, for the
stand (towards the viewer, above the table) with the middle of the tray's bottom edge, on the floor's plane, as origin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from moireid.badge import Badge, Point
from moireid.errors import FabricationError
from moireid.fabrication.printed.tray import TrayPlan
from moireid.fabrication.process_figures import MountProcess
from moireid.fabrication.sight import Obstacle, sight_fault

#: Air between a holder and the tray where they need not touch; where they touch, FIT_MM keeps them from jamming.
PLAY_MM, FIT_MM = 0.3, 0.05
#: The clip: arms' thickness, room for cloth, the bump's distance from the other arm, arms' length below the slot.
CLIP_ARM_MM, CLOTH_MM, PINCH_MM, CLIP_LENGTH_MM = 2.0, 2.4, 0.4, 34.0
STAND_WALL_MM = 2.4
#: A stand is two posts so wide, joined by a strip of the foot before them and one behind them.
POST_MM, FRONT_STRIP_MM, BACK_STRIP_MM = 6.4, 3.6, 3.6
#: The wall in front of the tray's bottom edge is at most this high.
MOST_FRONT_MM = 5.0
#: The badge's middle must stay this far inside the foot's back edge, so that no draught turns it over.
STAND_SAFETY_MM = 15.0


@dataclass(frozen=True)
class HolderBody:
    """A second body: its profile, how wide it is drawn out, and radii of the profile's corners by index, mm.

    lean_deg: how far it leans the badge back; open_mm: from where to where along it, between its posts, it is cut away.
    """

    name: str
    profile: tuple[Point, ...]
    width_mm: float
    radii_mm: tuple[tuple[int, float], ...] = ()
    lean_deg: float = 0.0
    open_mm: tuple[float, float] | None = None

    @property
    def size_mm(self) -> tuple[float, float]:
        """Extent of the profile, along and up."""
        along, up = zip(*self.profile, strict=True)
        return max(along) - min(along), max(up) - min(up)


def plan_holder(badge: Badge, plan: TrayPlan, process: MountProcess, kind: str) -> HolderBody | None:
    """The second body of a mount, None for a lanyard.  Raises: FabricationError as `clip` and `stand` do."""
    if kind == "clip":
        return clip(plan, process)
    return stand(badge, plan, process) if kind == "stand" else None


def clip(plan: TrayPlan, process: MountProcess) -> HolderBody:
    """A spring clip for a pocket or a lapel, hooked into the tab.

    Raises: FabricationError where the slot is too small for a hook.
    """
    wall, (slot_width, slot_height) = process.wall_mm, plan.slot_mm
    if slot_height < 3.0 or slot_width < 8.0:
        raise FabricationError(
            f"a slot of {slot_width:g} x {slot_height:g} mm takes no clip's hook; give a slot_mm of 8x3 or "
            "more (mount_mm)"
        )
    # The bar is what lies above the slot; it rests on the hook's floor, which passes through the slot.
    bar = plan.half_mm[1] + 2 * wall + slot_height - FIT_MM
    floor, lip = bar - 0.4 * slot_height, bar + 0.45 * slot_height
    spine = -process.back_mm - PLAY_MM
    inner, outer = spine - CLIP_ARM_MM, spine - CLIP_ARM_MM - CLOTH_MM
    back, top, end = outer - CLIP_ARM_MM, plan.tab_top + 1.0, floor - CLIP_LENGTH_MM
    profile: tuple[Point, ...] = (
        (end, spine),
        (floor, spine),
        (floor, PLAY_MM + 1.4),
        (lip, PLAY_MM + 1.4),
        (lip, PLAY_MM),
        (bar, PLAY_MM),
        (bar, spine),
        (top + CLIP_ARM_MM, spine),
        (top + CLIP_ARM_MM, back),
        (end - 3.0, back),
        # The rear arm's end is bent out to let the cloth in, and its bump pinches it.
        (end - 3.0, outer - 1.0),
        (end + 5.0, inner - PINCH_MM),
        (end + 8.0, inner - PINCH_MM),
        (end + 13.0, outer),
        (top, outer),
        (top, inner),
        (end, inner),
    )
    round_end = 0.45 * CLOTH_MM
    radii = ((7, CLIP_ARM_MM), (8, CLIP_ARM_MM), (14, round_end), (15, round_end), (3, 0.6), (0, 0.8))
    return HolderBody("clip", profile, slot_width - 4.0, radii)


def stand(badge: Badge, plan: TrayPlan, process: MountProcess) -> HolderBody:
    """A table stand that leans the badge back by `stand_deg`: a camera at eye height looks down on a table.

    Raises: FabricationError where its front wall would hide the badge.
    """
    width = min(0.6 * 2 * plan.half_mm[0], 90.0)
    height = plan.half_mm[1] - plan.bottom
    # The wall is in front of the tray's bottom rim, and in front of the sheet only where that reaches down so far.
    clear = plan.spans[0][0] - process.clearance_mm > plan.bottom + MOST_FRONT_MM
    front, wall = (plan.side_top if clear else plan.rim_top) + PLAY_MM, 2.4
    lip = _front_wall_mm(badge, plan, process, width, front + wall)
    behind = -process.back_mm - FIT_MM
    rest = min(0.25 * height, 30.0)
    lean = math.radians(process.stand_deg)

    def at(y: float, z: float) -> Point:
        """A place of the tray's frame, y from its bottom edge, seen from the side of the table."""
        return z * math.cos(lean) - y * math.sin(lean), y * math.cos(lean) + z * math.sin(lean)

    groove = [at(lip, front + wall), at(lip, front), at(-FIT_MM, front), at(-FIT_MM, behind)]
    back_of_rest = behind - STAND_WALL_MM
    table = min(up for _, up in groove) - STAND_WALL_MM
    foot_top = table + STAND_WALL_MM + 0.5
    middle = at(height / 2, plan.rim_top / 2)[0]
    # Down along the rest's back to the foot: the y at which it comes to foot_top.
    y_foot = (foot_top - back_of_rest * math.sin(lean)) / math.cos(lean)
    foot_end = min(middle - STAND_SAFETY_MM, at(y_foot, back_of_rest)[0] - 15.0)
    toe = groove[0][0] + 6.0
    profile = (
        (foot_end, table),
        (toe, table),
        (toe, table + STAND_WALL_MM),
        *groove,
        at(rest, behind),
        at(rest, back_of_rest),
        at(y_foot, back_of_rest),
        (foot_end, foot_top),
    )
    open_mm = (foot_end + BACK_STRIP_MM, toe - FRONT_STRIP_MM) if width > 3 * POST_MM else None
    return HolderBody("stand", tuple(profile), width, ((9, 4.0), (8, 1.5)), process.stand_deg, open_mm)


def shape_holder(b3d: Any, holder: HolderBody) -> Any:
    """The holder as a build123d Part, its profile in the plane z = 0 and drawn out to z = width."""
    face = b3d.make_face(b3d.Polyline(*holder.profile, close=True))
    for index, radius in holder.radii_mm:
        along, up = holder.profile[index]
        corner = [v for v in face.vertices() if math.hypot(v.X - along, v.Y - up) < 1e-6]
        face = b3d.fillet(corner, radius)
    body = b3d.extrude(face, holder.width_mm)
    if holder.open_mm is None:
        return body
    low, high = holder.open_mm
    _, tall = holder.size_mm
    gone = b3d.Box(high - low, 4 * tall, holder.width_mm - 2 * POST_MM)
    return body - gone.moved(b3d.Location(((low + high) / 2, 0, holder.width_mm / 2)))


def in_use(b3d: Any, holder: HolderBody, plan: TrayPlan) -> Any:
    """The build123d Location that takes a holder, as shaped, to its place at the tray."""
    if holder.name == "clip":
        return b3d.Plane(origin=(-holder.width_mm / 2, 0, 0), x_dir=(0, 1, 0), z_dir=(1, 0, 0)).location
    lean = math.radians(holder.lean_deg)
    forward = (0, -math.sin(lean), math.cos(lean))
    return b3d.Plane(origin=(holder.width_mm / 2, plan.bottom, 0), x_dir=forward, z_dir=(-1, 0, 0)).location


def as_printed(b3d: Any, holder: HolderBody, shape: Any, plan: TrayPlan, process: MountProcess) -> Any:
    """A holder, as shaped, as it lies on the printer's bed next to the tray.

    A clip lies on its side: no overhang, and the layers run along the spring; a stand is on its foot, as on the table.
    """
    drawn_out = (0, 0, 1) if holder.name == "clip" else (1, 0, 0)
    lying = shape.moved(b3d.Plane((0, 0, 0), x_dir=(0, 1, 0), z_dir=drawn_out).location)
    corner = b3d.Vector(plan.out_x + 8.0, plan.bottom, -process.back_mm)
    return lying.moved(b3d.Location(corner - lying.bounding_box().min))


def _front_wall_mm(badge: Badge, plan: TrayPlan, process: MountProcess, width: float, top: float) -> float:
    """The highest wall in front of the tray's bottom edge that hides nothing, mm above that edge; at most 5."""
    for height in (MOST_FRONT_MM, 4.0, 3.0, 2.0):
        rect = (-width / 2, plan.bottom, width / 2, plan.bottom + height)
        fault = sight_fault(
            badge,
            [Obstacle("front wall", rect, top)],
            card_top=plan.card_top,
            sheet_top=plan.sheet_top,
            play_mm=process.clearance_mm,
            advice="take a larger wall_mm (mount_mm), a thinner sheet, or another mount (mount)",
        )
        if fault is None:
            return height
    assert fault is not None
    raise fault
