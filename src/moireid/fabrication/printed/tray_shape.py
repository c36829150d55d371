"""The printed tray as a solid, of the figures of `tray`.

Convention: the frame of `sight`, its origin on the tray's floor.
"""

from __future__ import annotations

import math
from typing import Any

from moireid.badge import Point, Rect
from moireid.fabrication.printed.tray import LEVEL_MM, SLIT_MM, STOP_RAMP, TrayPlan, tab_outline
from moireid.fabrication.process_figures import LEAST_LIP_MM, MountProcess


def shape_tray(b3d: Any, plan: TrayPlan, process: MountProcess) -> Any:
    """The tray as a build123d Part."""
    # The kernel joins many bodies at once in a fraction of the time that they take one by one.
    added, pads = [], process.depth_clearance_mm + process.preload_mm
    in_x = plan.out_x - process.wall_mm
    for rect in plan.lip_rects(process):
        if plan.stepped:
            x0, x1 = (in_x, plan.out_x) if rect[0] > 0 else (-plan.out_x, -in_x)
            added.append(block(b3d, (x0, rect[1], x1, rect[3]), plan.side_top, plan.rim_top))
        added.append(_lip(b3d, plan, process, rect))
    added += [_foot(b3d, plan, process, rect) for rect in plan.foot_rects(process)]
    added += [_stop(b3d, plan, process, *rows) for rows in plan.stop_rows]
    springs = []
    for rect in plan.pad_rects():
        pad = block(b3d, rect, -process.back_mm / 2, pads)
        # The card comes from above, so the upper edge of the pad is a ramp.
        edge = pad.faces().sort_by(b3d.Axis.Z)[-1].edges().sort_by(b3d.Axis.Y)[-1]
        springs.append(b3d.chamfer(edge, 0.9 * pads))
    added = [_rim(b3d, plan, process), *added, *springs]
    return _floor_with_tab(b3d, plan, process) + added


def block(b3d: Any, rect: Rect, z0: float, z1: float) -> Any:
    """A box from its corners, mm."""
    centre = ((rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2, (z0 + z1) / 2)
    return b3d.Box(rect[2] - rect[0], rect[3] - rect[1], z1 - z0).moved(b3d.Location(centre))


def corners(rect: Rect) -> list[Point]:
    """A rectangle's corners, anticlockwise."""
    x0, y0, x1, y1 = rect
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def _slit_loops(plan: TrayPlan) -> list[list[Point]]:
    """Slits round the tongues on three sides, left and right, as loops."""
    loops = []
    for x0, y0, x1, y1 in plan.tongue_rects():
        left, low, right = x0 - SLIT_MM, y0 - SLIT_MM, x1 + SLIT_MM
        loop = [(left, y1), (left, low), (right, low), (right, y1), (x1, y1), (x1, y0), (x0, y0), (x0, y1)]
        loops += [loop, [(-x, y) for x, y in reversed(loop)]]
    return loops


def _floor_with_tab(b3d: Any, plan: TrayPlan, process: MountProcess) -> Any:
    """Back plate with its openings, and with tab and slots where planned."""
    half_y, wall = plan.half_mm[1], process.wall_mm
    tabs = tab_outline(plan.slots, plan.slot_mm[0], half_y, plan.tab_top, wall)
    outline = [
        (-plan.out_x, plan.bottom),
        (plan.out_x, plan.bottom),
        (plan.out_x, half_y),
        *tabs,
        (-plan.out_x, half_y),
    ]
    radii = _radii(plan, process) | ({plan.tab_top: 2 * wall} if plan.slots else {})
    slot, slot_y = b3d.SlotOverall(*plan.slot_mm).face().outer_wire(), half_y + 2 * wall + plan.slot_mm[1] / 2
    inner = [b3d.Wire.make_polygon(loop) for loop in (*map(corners, plan.openings()), *_slit_loops(plan))]
    inner += [slot.moved(b3d.Location((x, slot_y, 0))) for x in plan.slots]
    outer = rounded(b3d, outline, radii).face().outer_wire()
    plate = b3d.extrude(b3d.Face(outer, inner), process.back_mm).moved(b3d.Location((0, 0, -process.back_mm)))
    # A chamfer round the bed side keeps the first, squashed layer of a print from sticking out; it must be smaller than
    # the corners' radii, of which the least is half a wall.
    bed_side = plate.faces().sort_by(b3d.Axis.Z)[0].face().outer_wire().edges()
    return b3d.chamfer(bed_side, min(0.4, process.back_mm / 4, process.wall_mm / 4))


def _radii(plan: TrayPlan, process: MountProcess) -> dict[float, float]:
    """Radii of the outline's corners by their y: the rim stays thick enough where the pocket's sharp ones come nearest,
    1.6 of 2 mm.
    """
    return {plan.bottom: 1.5 * process.wall_mm, plan.half_mm[1]: process.wall_mm / 2}


def _rim(b3d: Any, plan: TrayPlan, process: MountProcess) -> Any:
    """The rim on three sides."""
    x, top, wall = plan.out_x, plan.half_mm[1], process.wall_mm
    loop = [(-x, plan.bottom), (x, plan.bottom), (x, top), (-x, top)]
    face = rounded(b3d, loop, _radii(plan, process))
    pocket = b3d.Wire.make_polygon(corners((wall - x, plan.bottom + wall, x - wall, top + 1.0)))
    return b3d.extrude(face - b3d.Face(pocket), plan.side_top)


def rounded(b3d: Any, outline: list[Point], radii_mm: dict[float, float]) -> Any:
    """A face of that outline; radii_mm: of the corners at each y."""
    face = b3d.make_face(b3d.Polyline(*outline, close=True))
    for reach_y, radius_mm in radii_mm.items():
        face = b3d.fillet([v for v in face.vertices() if abs(v.Y - reach_y) < 1e-6], radius_mm)
    return face


def _underside(plan: TrayPlan, process: MountProcess, level: float, reach: float) -> list[Point]:
    """The lower face of a lip or foot, from the rim to its tip (x to the right, z), at `level` next to the board."""
    rim, step = plan.out_x - process.wall_mm, min(process.clearance_mm, LEVEL_MM)
    low = level - (process.clearance_mm - step)
    return [(plan.out_x, low), (rim, low), (rim - step, low), (plan.half_mm[0] - reach, level + reach)]


def _lip(b3d: Any, plan: TrayPlan, process: MountProcess, rect: Rect) -> Any:
    """One lip at the rim, chamfered above, and below at its upper end, where the sheet comes in."""
    under = _underside(plan, process, plan.rim_top, plan.reach_mm)
    lip = drawn_out(b3d, [*under, (under[-1][0], plan.lip_top), (plan.out_x, plan.lip_top)], rect)
    lip = b3d.chamfer(lip.faces().sort_by(b3d.Axis.Z)[-1].edges(), plan.chamfer)
    side, (begin, end) = math.copysign(1.0, rect[0]), under[2:]
    middle = (side * (begin[0] + end[0]) / 2, rect[3], (begin[1] + end[1]) / 2)
    entry = min(lip.edges(), key=lambda edge: math.dist(tuple(edge.center()), middle))
    return b3d.chamfer(entry, plan.chamfer / 2)


def _foot(b3d: Any, plan: TrayPlan, process: MountProcess, rect: Rect) -> Any:
    """One foot: it stops the sheet but not the card, which goes on below it to the bottom rim."""
    level = plan.card_top + process.depth_clearance_mm
    # Where a lip covers it, it grows into the lip; where not, it keeps two layers below its upper face.
    room = plan.side_top - LEAST_LIP_MM - level if plan.stepped else plan.reach_mm
    reach = min(plan.reach_mm, room)
    top = plan.side_top if plan.stepped else plan.rim_top + plan.reach_mm
    under = _underside(plan, process, level, reach)
    return drawn_out(b3d, [*under, (under[-1][0], top), (plan.out_x, top)], rect)


def _stop(b3d: Any, plan: TrayPlan, process: MountProcess, low: float, high: float) -> Any:
    """One stop on the left side, out to the board's edge, with a ramp where the board comes in."""
    edge, root = -plan.half_mm[0], -plan.out_x + process.wall_mm / 2
    rim, ramp = -plan.out_x + process.wall_mm, min(STOP_RAMP * process.clearance_mm, (high - low) / 2)
    outline = [(root, low), (edge, low), (edge, high - ramp), (rim, high), (root, high)]
    face = b3d.make_face(b3d.Polyline(*outline, close=True))
    return b3d.extrude(face, plan.rim_top + process.back_mm / 2).moved(b3d.Location((0, 0, -process.back_mm / 2)))


def drawn_out(b3d: Any, profile: list[Point], rect: Rect) -> Any:
    """A body of the profile (x to the right, z), drawn out along y over a rectangle, on its side of the tray."""
    side = math.copysign(1.0, rect[0])
    face = b3d.make_face(b3d.Polyline(*[(side * x, z) for x, z in profile], close=True))
    plane = b3d.Plane(origin=(0, rect[3], 0), x_dir=(1, 0, 0), z_dir=(0, -1, 0))
    return b3d.extrude(face, rect[3] - rect[1], dir=(0, 0, 1)).moved(plane.location)
