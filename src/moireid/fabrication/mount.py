"""The lanyard mount: a shallow tray that holds board and lens sheet flat on each other, to be 3D-printed.

The board (the page cut out, on card) lies on the tray's floor and the lens sheet lies on the board.  Both slide in
together through the open top edge.  Lips over the left and right edge press the sheet down, and at the lips' lower
ends two feet keep it from slipping over the lower markers.  A tab above the open edge carries the lanyard.

Convention: the part's frame has x right, y up and z towards the viewer, in mm; its origin is the board's centre on
the tray's floor, so the plate behind the board has negative z.  Page coordinates turn into it by
x = page_x - centre_x, y = centre_y - page_y.  It prints lying on its back; only lips and feet overhang, by
`lip_reach_mm + clearance_mm`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from moireid.badge import Badge, Rect
from moireid.errors import FabricationError
from moireid.fabrication.solids import Expected, cad_package, check_step, check_stl, export_step, export_stl
from moireid.files import planned, whole_file

PLA_G_PER_MM3 = 1.24e-3
#: Nothing of the mount may come before the fringes for a camera up to this far to the side ...
GRATING_SIGHT_DEG = 60.0
#: ... nor before the markers, which a camera must see sharply and so never sees as flat as this.
MARKER_SIGHT_DEG = 45.0


@dataclass(frozen=True)
class MountProcess:
    """What the printer and the card ask for, apart from the part itself; all in mm.

    clearance_mm: air left, right and below of board and sheet, each; wall_mm: the rim's width; back_mm: the plate
    behind the board; lip_reach_mm: how far a lip comes over the board, from the board's edge; lip_mm: its thickness;
    card_mm: thickness of the printed board; depth_clearance_mm: air between sheet and lip; slot_mm: lanyard slot,
    width and height.
    """

    clearance_mm: float = 0.3
    wall_mm: float = 2.0
    back_mm: float = 1.6
    lip_reach_mm: float = 2.0
    lip_mm: float = 1.2
    card_mm: float = 0.3
    depth_clearance_mm: float = 0.1
    slot_mm: tuple[float, float] = (16.0, 4.0)

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not all(math.isfinite(v) and v > 0 for v in (value if isinstance(value, tuple) else (value,))):
                raise FabricationError(f"process figure {entry.name}={value} must be positive; give it in mm")


@dataclass(frozen=True)
class MountReport:
    """The files that were written and checked, and what the part will be; mass_g is that of solid PLA."""

    step: Path
    stl: Path
    volume_mm3: float
    size_mm: tuple[float, float, float]
    mass_g: float
    triangles: int


@dataclass(frozen=True)
class _Plan:
    """The figures of a mount in its frame, before any solid is made.

    half_mm: half the board's width and height; out_x and bottom: outer faces of the rim; tab_top: of the tab;
    z figures: card_top, sheet_top, rim_top (also the lips' lower face), lip_top; chamfer: of the lips' upper edges;
    spans: (low, high) rows in y of each sheet, from bottom to top.
    """

    half_mm: tuple[float, float]
    out_x: float
    bottom: float
    tab_top: float
    card_top: float
    sheet_top: float
    rim_top: float
    lip_top: float
    chamfer: float
    spans: tuple[tuple[float, float], ...]

    def lip_rects(self, process: MountProcess) -> list[Rect]:
        """Lips and the rim below them, seen from the front, in pairs from bottom to top; the lowest covers its feet."""
        inner = self.half_mm[0] - process.lip_reach_mm
        lows = [low for low, _ in self.spans]
        lows[0] -= process.clearance_mm + process.wall_mm
        rights = [(inner, low, self.out_x, high) for low, (_, high) in zip(lows, self.spans, strict=True)]
        return [rect for x0, y0, x1, y1 in rights for rect in ((x0, y0, x1, y1), (-x1, y0, -x0, y1))]


def lanyard_mount(badge: Badge, process: MountProcess | None = None) -> Any:
    """The mount of a badge as a build123d Part.

    Convention: see the module's docstring.
    Raises: FabricationError where a lip or the rim would hide fringes or markers, or no solid can be made so;
        MissingExtraError without build123d.
    """
    process = process or MountProcess()
    plan = _plan(badge, process)
    _check_sight(badge, plan, process)
    b3d = cad_package("build123d")
    try:
        part = _tray(b3d, plan, process)
        for rect in plan.lip_rects(process):
            part += _lip(b3d, plan, rect)
        for rect in plan.lip_rects(process)[:2]:
            # A foot stops the sheet but not the card, which goes on below it to the bottom rim.
            low, high = rect[1], rect[1] + process.wall_mm
            card_room = plan.card_top + process.depth_clearance_mm
            part += _block(b3d, (rect[0], low, rect[2], high), card_room, plan.rim_top)
    except (ValueError, RuntimeError) as error:
        raise FabricationError(f"no mount can be shaped of {process} ({error}); go back to the defaults") from error
    return part


def write_mount(
    badge: Badge,
    folder: Path,
    *,
    overwrite: bool = False,
    process: MountProcess | None = None,
    tolerance_mm: float = 0.05,
) -> MountReport:
    """Write mount.step and mount.stl, read both back, and keep them only if both hold what was designed.

    Parameters: tolerance_mm: how far the STL's facets may lie off the true surface.
    Raises: as `lanyard_mount`; SpecError where a file exists and overwrite is false; FabricationError where a file
        fails its check, in which case neither is written and neither older one is touched.
    """
    process = process or MountProcess()
    step, stl = folder / "mount.step", folder / "mount.stl"
    planned((step, stl), overwrite=overwrite)
    # The kernel takes seconds to come up, so the small packages say first whether they are there.
    for name in ("trimesh", "manifold3d", "build123d"):
        cad_package(name)
    part = lanyard_mount(badge, process)
    plan = _plan(badge, process)
    lower, upper = (-plan.out_x, plan.bottom, -process.back_mm), (plan.out_x, plan.tab_top, plan.lip_top)
    expected = Expected(float(part.volume), lower, upper)
    with whole_file(step) as new_step, whole_file(stl) as new_stl:
        export_step(part, new_step)
        export_stl(part, new_stl, tolerance_mm=tolerance_mm)
        check_step(new_step, expected)
        triangles = check_stl(new_stl, expected)
    size_mm = (upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2])
    return MountReport(step, stl, expected.volume_mm3, size_mm, expected.volume_mm3 * PLA_G_PER_MM3, triangles)


def _plan(badge: Badge, process: MountProcess) -> _Plan:
    x0, y0, x1, y1 = badge.outline_mm
    half = ((x1 - x0) / 2, (y1 - y0) / 2)
    sheet_top = process.card_mm + badge.lens.thickness_mm
    rim_top = sheet_top + process.depth_clearance_mm
    rim_mm = process.clearance_mm + process.wall_mm
    # The tab's feet, and the fillets beside them, must stand on the tray's upper edge.
    least_mm = process.slot_mm[0] + 10 * process.wall_mm - 2 * rim_mm
    if x1 - x0 < least_mm - 1e-6:
        raise FabricationError(
            f"a board {x1 - x0:g} mm wide is narrower than the lanyard's tab; give one of {least_mm:.1f} mm or more, "
            "or no mount",
            least_mm=least_mm,
        )
    return _Plan(
        half_mm=half,
        out_x=half[0] + rim_mm,
        bottom=-half[1] - rim_mm,
        tab_top=half[1] + 4 * process.wall_mm + process.slot_mm[1],
        card_top=process.card_mm,
        sheet_top=sheet_top,
        rim_top=rim_top,
        lip_top=rim_top + process.lip_mm,
        chamfer=process.lip_mm / 2,
        spans=_sheet_spans(badge),
    )


def _in_frame(rect: Rect, badge: Badge) -> Rect:
    """A page rectangle in the part's frame, again with its lower corner first: y turns round."""
    x0, y0, x1, y1 = badge.outline_mm
    centre_x, centre_y = (x0 + x1) / 2, (y0 + y1) / 2
    return (rect[0] - centre_x, centre_y - rect[3], rect[2] - centre_x, centre_y - rect[1])


def _sheet_spans(badge: Badge) -> tuple[tuple[float, float], ...]:
    """Rows (low, high) that sheets cover, from bottom to top; gratings that share rows share a pair of lips."""
    spans: list[tuple[float, float]] = []
    for _, low, _, high in sorted((_in_frame(g.rect_mm, badge) for g in badge.gratings), key=lambda rect: rect[1]):
        if spans and low <= spans[-1][1]:
            spans[-1] = (spans[-1][0], max(spans[-1][1], high))
        else:
            spans.append((low, high))
    return tuple(spans)


def _check_sight(badge: Badge, plan: _Plan, process: MountProcess) -> None:
    """Neither lip nor rim may stand in the sight line to a fringe or a marker, wherever the board has slid to.

    What stands h above a layer hides h tan(angle) of it beside itself.  Fringes lie on the lenses' plane, markers on
    the card's.  A lip's chamfer has two edges that can hide something: the inner lower one and the outer upper one.
    """
    obstacles = [("rim", rect, plan.rim_top) for rect in _rim_rects(plan, process)]
    for x0, y0, x1, y1 in plan.lip_rects(process):
        inner = (x0, y0, x1 - plan.chamfer, y1) if x0 < 0 else (x0 + plan.chamfer, y0, x1, y1)
        obstacles += [("lip", (x0, y0, x1, y1), plan.lip_top - plan.chamfer), ("lip", inner, plan.lip_top)]
    for target, rect, level, angle_deg in _sight_targets(badge, plan):
        for obstacle, blocker, top in obstacles:
            have_mm = _gap_mm(rect, blocker, play_mm=process.clearance_mm)
            need_mm = (top - level) * math.tan(math.radians(angle_deg))
            if have_mm < need_mm:
                raise FabricationError(
                    f"the mount's {obstacle} leaves {have_mm:.2f} mm beside {target}, but {need_mm:.2f} mm are needed "
                    f"to see it from {angle_deg:g} degrees; take a smaller lip_reach_mm or lip_mm, or a badge with "
                    "a wider margin",
                    have_mm=have_mm,
                    need_mm=need_mm,
                )


def _sight_targets(badge: Badge, plan: _Plan) -> list[tuple[str, Rect, float, float]]:
    """What must stay in sight: name, rectangle in the frame, height, and the angle it is seen from, degrees."""
    half = badge.markers.size_mm / 2
    targets = [
        (f"grating {g}", _in_frame(grating.rect_mm, badge), plan.sheet_top, GRATING_SIGHT_DEG)
        for g, grating in enumerate(badge.gratings)
    ]
    for id_, (x, y) in zip(badge.markers.ids, badge.markers.centers_mm, strict=True):
        rect = _in_frame((x - half, y - half, x + half, y + half), badge)
        targets.append((f"marker {id_}", rect, plan.card_top, MARKER_SIGHT_DEG))
    half_x, half_y = plan.half_mm
    for name, (x0, y0, x1, y1), _, _ in targets:
        if x0 < -half_x or y0 < -half_y or x1 > half_x or y1 > half_y:
            raise FabricationError(f"{name} reaches beyond the board that the mount holds; correct board.rect_mm")
    return targets


def _rim_rects(plan: _Plan, process: MountProcess) -> list[Rect]:
    """The rim's left, right and bottom side, seen from the front."""
    in_x, top = plan.out_x - process.wall_mm, plan.half_mm[1]
    left, right = (-plan.out_x, plan.bottom, -in_x, top), (in_x, plan.bottom, plan.out_x, top)
    return [left, right, (-plan.out_x, plan.bottom, plan.out_x, plan.bottom + process.wall_mm)]


def _gap_mm(one: Rect, other: Rect, *, play_mm: float) -> float:
    """Least distance of two rectangles once one has moved up to play_mm along each axis; below 0 they may overlap."""
    gaps = [max(other[k] - one[k + 2], one[k] - other[k + 2]) - play_mm for k in (0, 1)]
    return math.hypot(*gaps) if min(gaps) > 0 else max(gaps)


def _tray(b3d: Any, plan: _Plan, process: MountProcess) -> Any:
    """Back plate with tab and slot, and the rim on three sides."""
    half_y, wall = plan.half_mm[1], process.wall_mm
    outline = _outline(b3d, plan, process)
    body = b3d.extrude(outline, plan.rim_top + process.back_mm).moved(b3d.Location((0, 0, -process.back_mm)))
    # A chamfer round the bed side keeps the first, squashed layer of a print from standing out.
    body = b3d.chamfer(body.faces().sort_by(b3d.Axis.Z)[0].edges(), min(0.4, process.back_mm / 4))
    inner = plan.out_x - wall
    body -= _block(b3d, (-inner, plan.bottom + wall, inner, half_y), 0.0, plan.rim_top)
    body -= _block(b3d, (-plan.out_x, half_y, plan.out_x, plan.tab_top), 0.0, plan.rim_top)
    slot = b3d.extrude(b3d.SlotOverall(*process.slot_mm), 2 * process.back_mm)
    return body - slot.moved(b3d.Location((0, half_y + 2 * wall + process.slot_mm[1] / 2, -1.5 * process.back_mm)))


def _outline(b3d: Any, plan: _Plan, process: MountProcess) -> Any:
    """The tray and its tab seen from the front, with rounded corners."""
    half_y, wall, tab_x = plan.half_mm[1], process.wall_mm, process.slot_mm[0] / 2 + 2 * process.wall_mm
    corners = [
        (-plan.out_x, plan.bottom), (plan.out_x, plan.bottom), (plan.out_x, half_y), (tab_x + 2 * wall, half_y),
        (tab_x, plan.tab_top), (-tab_x, plan.tab_top), (-tab_x - 2 * wall, half_y), (-plan.out_x, half_y),
    ]  # fmt: skip
    face = b3d.make_face(b3d.Polyline(*corners, close=True))
    # The rim's corners stay thick enough where the pocket's sharp ones come nearest: 1.6 of 2 mm.
    for reach_y, radius_mm in ((plan.bottom, 1.5 * wall), (half_y, wall / 2), (plan.tab_top, 2 * wall)):
        face = b3d.fillet([v for v in face.vertices() if abs(v.Y - reach_y) < 1e-6], radius_mm)
    return face


def _lip(b3d: Any, plan: _Plan, rect: Rect) -> Any:
    """One lip on top of the rim, chamfered above, and below at its upper end, where the sheet comes in."""
    lip = _block(b3d, rect, plan.rim_top, plan.lip_top)
    lip = b3d.chamfer(lip.faces().sort_by(b3d.Axis.Z)[-1].edges(), plan.chamfer)
    entry = lip.faces().sort_by(b3d.Axis.Z)[0].edges().sort_by(b3d.Axis.Y)[-1]
    return b3d.chamfer(entry, plan.chamfer / 2)


def _block(b3d: Any, rect: Rect, z0: float, z1: float) -> Any:
    """A box from its corners, mm."""
    centre = ((rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2, (z0 + z1) / 2)
    return b3d.Box(rect[2] - rect[0], rect[3] - rect[1], z1 - z0).moved(b3d.Location(centre))
