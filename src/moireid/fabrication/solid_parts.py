"""The parts of a mount as build123d solids, each in its place in use, named and coloured; and a check of the places.

Page and lens sheet are among the parts, so that the check finds what has no room or does not touch.

Convention: the frame of `sight`, mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from moireid.arguments import checked
from moireid.badge import Badge, Point, Rect
from moireid.errors import FabricationError
from moireid.fabrication.part_colours import kind_of, linear_colour
from moireid.fabrication.process_figures import MountFigures, MountProcess
from moireid.fabrication.sight import front_mm, half_board_mm, sheet_rects
from moireid.fabrication.solids import FINE_MM, FINE_RAD, TOUCH_MM3, Body, cad_package, solid_of

if TYPE_CHECKING:
    from moireid.fabrication.acrylic.contours import Contour
    from moireid.fabrication.acrylic.plates import AcrylicPlan, Plate
    from moireid.fabrication.printed.mount import MountPlan

#: The mount to laser-cut, besides the kinds of the printed one.
ACRYLIC = "acrylic"
#: Parts that must touch may be this far apart, mm: rounding errors.
TOUCH_MM = 1e-3


@dataclass(frozen=True)
class SolidPart:
    """One part in its place.

    name: such as "sheet-0"; shape: build123d.Shape with that label and its kind's colour; touches: names of the parts
    that it must touch.
    """

    name: str
    shape: Any
    touches: tuple[str, ...] = ()

    @cached_property
    def mesh(self) -> Any:
        """A trimesh mesh of it, mm; made once, as it takes longer than all that is made of it."""
        vertices, faces = self.shape.tessellate(FINE_MM, FINE_RAD)
        # The kernel's last digits change from run to run, and the same badge is to give the same bytes.
        return cad_package("trimesh").Trimesh(np.round([tuple(vertex) for vertex in vertices], 5), faces)

    @cached_property
    def solid(self) -> Any:
        """The same as a manifold3d Manifold."""
        return solid_of(self.mesh)


@checked()
def mount_solids(badge: Badge, mount: str = "lanyard", figures: MountFigures | None = None) -> dict[str, Any]:
    """Make the parts of a mount, with page and lens sheets, as `print_badge` writes them to files.

    Parameters
    ----------
    badge : Badge
        What the mount holds.
    mount : str
        A kind of the printed mount, "lanyard", "clip" or "stand"; or "acrylic" for the stack to laser-cut,
        with its screws.
    figures : MountFigures, optional
        Of printer and laser; None for the defaults.

    Returns
    -------
    dict of str to build123d.Shape
        Each part in its place in use, by its name, which is its label too; with its colour.

    Raises
    ------
    FabricationError
        Where no such mount fits the badge, or there is none of that name.
    MissingExtraError
        Without the CAD packages.

    Notes
    -----
    Convention: the board's middle is the origin, x right, y up, z towards the viewer, mm.
    """
    from moireid.fabrication.acrylic.plates import plan_acrylic
    from moireid.fabrication.printed.mount import KINDS, mount_bodies, plan_mount

    if mount not in (*KINDS, ACRYLIC):
        raise FabricationError(f"mount {mount!r} is not known; choose one of {', '.join((*KINDS, ACRYLIC))}")
    figures = figures or MountFigures()
    if mount == ACRYLIC:
        parts = acrylic_parts(plan_acrylic(badge, figures.acrylic))
    else:
        plan = plan_mount(badge, mount, figures.printed)
        parts = printed_parts(badge, plan, mount_bodies(badge, mount, figures.printed, plan), figures.printed)
    return {part.name: part.shape for part in parts}


def printed_parts(
    badge: Badge, plan: MountPlan, bodies: Sequence[Body], process: MountProcess
) -> tuple[SolidPart, ...]:
    """The printed bodies with page and lens sheets.

    A tray's springs press page and sheet on its lips.  Their pads, which would reach into the page, are cut off at it.
    """
    half_x, half_y = half_board_mm(badge)
    low = process.depth_clearance_mm
    card_top = low + process.card_mm
    sheet_top = card_top + process.adhesive_mm + front_mm(badge, process.film_mm)
    page = box((-half_x, -half_y, half_x, half_y), low, card_top)
    tray, *others = bodies
    parts = [_part(tray.name, tray.used - page), *(_part(body.name, body.used) for body in others)]
    parts.append(_part("page", page, tray.name))
    held = ("page", tray.name) if process.adhesive_mm == 0 else (tray.name,)
    return (*parts, *_sheets(sheet_rects(badge), card_top + process.adhesive_mm, sheet_top, held))


def acrylic_parts(plan: AcrylicPlan) -> tuple[SolidPart, ...]:
    """The stack's parts from behind to the front, each where it was planned."""
    sheets = _sheets(plan.sheets, plan.card_mm, plan.sheet_top, ("page",))
    pad = [_part("pad", box(plan.page, -plan.pad_mm, 0.0), "base")] if plan.layers else []
    return (
        _part("base", _plate(plan.base)),
        *pad,
        _part("page", box(plan.page, 0.0, plan.card_mm), "pad" if pad else "base"),
        *(_part(plate.name, _plate(plate), below.name) for below, plate in pairwise([plan.base, *plan.frames])),
        *sheets,
        _part("lips", _plate(plan.lips), sheets[0].name),
        _part("cover", _plate(plan.cover), "lips"),
        *(_part(f"screw-{k}", _screw(plan, place), "cover") for k, place in enumerate(plan.screws)),
    )


def check_parts(parts: Sequence[SolidPart]) -> None:
    """Check that no two parts share any volume, and that each touches those that it must touch.

    Raises
    ------
    FabricationError
        With the volume that two parts share, or the gap between two that must touch.
    """
    bodies = {part.name: part.solid for part in parts}
    for k, part in enumerate(parts):
        for other in parts[:k]:
            if (shared := float((bodies[part.name] ^ bodies[other.name]).volume())) > TOUCH_MM3:
                raise FabricationError(
                    f"the mount's {part.name} and {other.name} share {shared:.2f} mm³, allowed is none; choose other "
                    "process figures, and report this if the defaults fail",
                    overlap_mm3=shared,
                )
        for name in part.touches:
            if (gap_mm := bodies[name].min_gap(bodies[part.name], 10.0)) > TOUCH_MM:
                raise FabricationError(
                    f"the mount's {part.name} is {gap_mm:.4f} mm from the {name} that it must touch, allowed are "
                    f"{TOUCH_MM:g} mm; nothing was kept: report this",
                    off_mm=gap_mm,
                )


def _part(name: str, shape: Any, *touches: str) -> SolidPart:
    """A part with its label and colour; a copy, because a shape's label is its own."""
    b3d = cad_package("build123d")
    shape = b3d.Solid(shape.solid().wrapped)
    shape.label, shape.color = name, b3d.Color(*linear_colour(kind_of(name)))
    return SolidPart(name, shape, touches)


def _sheets(rects: Sequence[Rect], low: float, high: float, touches: tuple[str, ...]) -> tuple[SolidPart, ...]:
    return tuple(_part(f"sheet-{k}", box(rect, low, high), *touches) for k, rect in enumerate(rects))


def box(rect: Rect, low: float, high: float) -> Any:
    """A build123d box over a rectangle, from one height to another, mm."""
    b3d = cad_package("build123d")
    return b3d.Solid.make_box(rect[2] - rect[0], rect[3] - rect[1], high - low, b3d.Plane((rect[0], rect[1], low)))


def _plate(plate: Plate) -> Any:
    """A plate whose arcs are arcs."""
    b3d = cad_package("build123d")
    outer, *inner = (_wire(b3d, path) for path in (plate.outline, *plate.openings))
    solid = b3d.Solid.extrude(b3d.Face(outer, inner), b3d.Vector(0, 0, plate.thickness_mm))
    return solid.moved(b3d.Location((0, 0, plate.low_mm)))


def _screw(plan: AcrylicPlan, place: Point) -> Any:
    """A screw with a button head, as long as the stack is thick."""
    from moireid.fabrication.acrylic.plates import HEAD_HIGH_MM, HEAD_MM, THREAD_MM

    b3d = cad_package("build123d")
    low, top = plan.base.low_mm, plan.cover.low_mm + plan.cover.thickness_mm
    shank = b3d.Solid.make_cylinder(THREAD_MM / 2, top - low, b3d.Plane((*place, low)))
    return shank.fuse(b3d.Solid.make_cylinder(HEAD_MM / 2, HEAD_HIGH_MM, b3d.Plane((*place, top))))


def _wire(b3d: Any, path: Contour) -> Any:
    """A closed wire of lines and arcs."""
    edges, vertices = [], path.vertices()
    for k, (x, y, bulge) in enumerate(vertices):
        end_x, end_y, _ = vertices[(k + 1) % len(vertices)]
        if bulge == 0:
            edges.append(b3d.Edge.make_line((x, y, 0), (end_x, end_y, 0)))
            continue
        # The arc's middle is half a chord times the bulge from the chord's middle, to the right where it turns left.
        middle = (x + end_x + bulge * (end_y - y)) / 2, (y + end_y - bulge * (end_x - x)) / 2
        edges.append(b3d.Edge.make_three_point_arc((x, y), middle, (end_x, end_y)))
    return b3d.Wire(edges)
