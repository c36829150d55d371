"""acrylic.step: the stack as exact solids with names and colours, for CAD programs and shops that mill.

The plates keep their arcs as arcs, where the laser's drawing and stack.glb have lines.  cadquery's assembly writes
them, and reads them back.

Convention: the frame of `sight`, mm.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from moireid.badge import Rect
from moireid.errors import FabricationError
from moireid.fabrication.acrylic.plates import HEAD_HIGH_MM, HEAD_MM, THREAD_MM, AcrylicPlan, Plate
from moireid.fabrication.acrylic.stack import COLOURS
from moireid.fabrication.solids import STEP_VOLUME_SHARE, cad_package


def write_stack_step(plan: AcrylicPlan, path: Path) -> None:
    """Write the stack as STEP, and read it back.

    Parameters
    ----------
    plan : AcrylicPlan
        As `plan_acrylic` gives it.
    path : Path
        The file; the kernel writes the time into it, and colours in no fixed order.

    Raises
    ------
    FabricationError
        Where the file does not hold each part with its volume.
    """
    cq = cad_package("cadquery")
    stack = cq.Assembly(name="stack")
    parts = stack_parts(cq, plan)
    for name, body in parts.items():
        colour = [value / 255 for value in COLOURS[name.split("-")[0]]]
        stack.add(body, name=name, color=cq.Color(*colour))
    if not stack.export(str(path), exportType="STEP"):
        raise FabricationError(f"{path.name} in {path.parent} could not be written; check the disk")
    check_stack_step(path, {name: body.Volume() for name, body in parts.items()})


def check_stack_step(path: Path, volumes_mm3: dict[str, float]) -> None:
    """Read the file back: every part there, by its name, with its volume.

    Raises: FabricationError with what was found and what is allowed.
    """
    cq = cad_package("cadquery")
    try:
        found = {part.name: part.obj.Volume() for part in cq.Assembly.importStep(str(path)).children if part.obj}
    except (ValueError, AttributeError) as error:
        raise FabricationError(f"{path.name} cannot be read back; nothing was kept: report this") from error
    if set(found) != set(volumes_mm3):
        raise FabricationError(
            f"{path.name} holds the parts {sorted(found)}, allowed are {sorted(volumes_mm3)}; nothing was kept: report "
            "this"
        )
    for name, volume_mm3 in volumes_mm3.items():
        if not math.isclose(found[name], volume_mm3, rel_tol=STEP_VOLUME_SHARE):
            raise FabricationError(
                f"{path.name} holds {name} with {found[name]:.1f} mm³, allowed is {volume_mm3:.1f} mm³; nothing was "
                "kept: report this"
            )


def stack_parts(cq: Any, plan: AcrylicPlan) -> dict[str, Any]:
    """Each part in its place, from behind to the front."""
    top = plan.sheet_top + plan.cover.thickness_mm
    high = top + plan.base.thickness_mm
    shank = cq.Solid.makeCylinder(THREAD_MM / 2, high, cq.Vector(0, 0, top - high))
    screw = shank.fuse(cq.Solid.makeCylinder(HEAD_MM / 2, HEAD_HIGH_MM, cq.Vector(0, 0, top)))
    return {
        "base": _plate(cq, plan.base),
        "page": _box(cq, plan.page, 0.0, plan.card_mm),
        "frame": _plate(cq, plan.frame),
        **{f"sheet-{k}": _box(cq, rect, plan.card_mm, plan.sheet_top) for k, rect in enumerate(plan.sheets)},
        "cover": _plate(cq, plan.cover),
        **{f"screw-{k}": screw.moved(cq.Location((x, y, 0))) for k, (x, y) in enumerate(plan.screws)},
    }


def _plate(cq: Any, plate: Plate) -> Any:
    outer, *inner = (_wire(cq, path.vertices()) for path in (plate.outline, *plate.openings))
    solid = cq.Solid.extrudeLinear(outer, inner, cq.Vector(0, 0, plate.thickness_mm))
    return solid.moved(cq.Location((0, 0, plate.low_mm)))


def _wire(cq: Any, vertices: list[tuple[float, float, float]]) -> Any:
    """A closed wire of lines and arcs; vertices: as `Contour.vertices`."""
    edges = []
    for k, (x, y, bulge) in enumerate(vertices):
        end_x, end_y, _ = vertices[(k + 1) % len(vertices)]
        start, end = cq.Vector(x, y, 0), cq.Vector(end_x, end_y, 0)
        if bulge == 0:
            edges.append(cq.Edge.makeLine(start, end))
            continue
        # An arc's highest point lies bulge half chords to the right of the chord, for one that turns left.
        middle = cq.Vector((x + end_x) / 2 + bulge * (end_y - y) / 2, (y + end_y) / 2 - bulge * (end_x - x) / 2, 0)
        edges.append(cq.Edge.makeThreePointArc(start, middle, end))
    return cq.Wire.assembleEdges(edges)


def _box(cq: Any, rect: Rect, low_mm: float, high_mm: float) -> Any:
    x0, y0, x1, y1 = rect
    return cq.Solid.makeBox(x1 - x0, y1 - y0, high_mm - low_mm, cq.Vector(x0, y0, low_mm))
