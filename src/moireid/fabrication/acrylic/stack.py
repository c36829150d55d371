"""The acrylic stack put together, and stack.glb to look at it.

The parts are placed in two ways: by cadquery's solver from the faces that touch, and by the heights that `plates.py`
planned; both must agree.  And no two parts may share any volume.

Convention: the frame of `sight`, mm; the GLB has metres and the same axes (x right, y up, z towards the viewer), which
are glTF's own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from moireid.badge import Badge, Rect
from moireid.errors import FabricationError
from moireid.fabrication.acrylic.plates import HEAD_HIGH_MM, HEAD_MM, THREAD_MM, AcrylicPlan, Plate
from moireid.fabrication.sight import half_board_mm, sheet_rects
from moireid.fabrication.solids import FACET_ANGLE_RAD, FINE_MM, cad_package, overlap_mm3, solid_of

#: The solver's own error; larger differences from the planned places are faults.
SOLVER_MM = 1e-3
TOUCH_MM3 = 0.01
METRES_PER_MM = 1e-3
#: In how many steps each part is drawn away from the base.
STEPS = {"base": 0, "page": 1, "frame": 1, "sheet": 2, "cover": 3, "screw": 4}
#: Red, green, blue and opacity, 0 to 255.
COLOURS = {
    "base": (70, 80, 95, 255),
    "page": (245, 245, 240, 255),
    "sheet": (150, 200, 235, 90),
    "frame": (40, 90, 160, 255),
    "cover": (205, 225, 240, 130),
    "screw": (150, 150, 155, 255),
    "tray": (60, 65, 75, 255),
    "holder": (60, 65, 75, 255),
    "clip": (200, 90, 50, 255),
    "stand": (200, 90, 50, 255),
}


@dataclass(frozen=True)
class PlacedPart:
    """One part in its place: its name, the cadquery shape, and the height of its lower face, mm."""

    name: str
    shape: Any
    low_mm: float


@dataclass(frozen=True)
class _Part:
    """A part before it is placed, its lower face at z = 0, and on which part's upper face it lies."""

    name: str
    shape: Any
    thick_mm: float
    on: str


def assemble(plan: AcrylicPlan) -> list[PlacedPart]:
    """The stack's parts from behind to the front, placed by cadquery's solver.

    Raises: FabricationError where the solver's places are not the planned ones.
    """
    cq = cad_package("cadquery")
    parts = _parts(cq, plan)
    stack = cq.Assembly(parts[0].shape, name=parts[0].name)
    below = {part.name: part for part in parts}
    origin = cq.Vertex.makeVertex(0, 0, 0)
    across, upright = (cq.Edge.makeLine((0, 0, 0), end) for end in ((1, 0, 0), (0, 0, 1)))
    stack.constrain(parts[0].name, "Fixed")
    for part in parts[1:]:
        stack.add(part.shape, name=part.name)
        face = cq.Face.makePlane(1, 1, (0, 0, below[part.on].thick_mm))
        stack.constrain(part.name, upright, part.on, upright, "Axis", param=0)
        stack.constrain(part.name, across, part.on, across, "Axis", param=0)
        stack.constrain(part.name, origin, part.on, upright, "PointOnLine")
        stack.constrain(part.name, origin, part.on, face, "PointInPlane", param=0)
    if len(parts) > 1:
        stack.solve()
    lows = _planned_lows(plan, parts)
    placed = []
    for part, child in zip(parts[1:], stack.children, strict=True):
        (x, y, z), turn = child.loc.toTuple()
        off_mm = max(abs(x), abs(y), abs(z - lows[part.name]))
        # A turn this small moves a corner of the largest board by less than the solver's error.
        if off_mm > SOLVER_MM or max(map(abs, turn)) > 1e-3:
            raise FabricationError(
                f"the stack's {part.name} is placed {off_mm:.4f} mm from where it was planned, allowed are "
                f"{SOLVER_MM:g} mm; nothing was kept: report this",
                off_mm=off_mm,
            )
        # The solver agrees with the plan, which is exact.
        low = lows[part.name]
        placed.append(PlacedPart(part.name, part.shape.moved(cq.Location((0, 0, low))), low))
    base = PlacedPart(
        parts[0].name, parts[0].shape.moved(cq.Location((0, 0, -plan.base.thickness_mm))), plan.base.low_mm
    )
    down = cq.Location((0, 0, -plan.base.thickness_mm))
    return [base, *(PlacedPart(p.name, p.shape.moved(down), p.low_mm - plan.base.thickness_mm) for p in placed)]


def check_stack(plan: AcrylicPlan) -> list[tuple[str, Any]]:
    """Check that no two parts of the stack share any volume.

    Returns: name and trimesh mesh of each part in its place, mm.
    Raises: FabricationError, also as `assemble`.
    """
    meshes = [(part.name, _mesh(part.shape)) for part in assemble(plan)]
    solids = [(name, solid_of(mesh)) for name, mesh in meshes]
    for k, (one, first) in enumerate(solids):
        for other, second in solids[:k]:
            if (shared := overlap_mm3(first, second)) > TOUCH_MM3:
                raise FabricationError(
                    f"the stack's {one} and {other} share {shared:.2f} mm³, allowed is none; choose other process "
                    "figures, and report this if the defaults fail",
                    overlap_mm3=shared,
                )
    return meshes


def write_glb(
    badge: Badge,
    stack: list[tuple[str, Any]],
    path: Path,
    *,
    mount: list[tuple[str, Any]],
    held_mm: tuple[float, float],
    spread_mm: float = 15,
) -> None:
    """Write the exploded stack, and the printed mount's bodies next to it, as binary glTF; either may be absent.

    Parameters: stack: as `check_stack` returns it; mount: name and build123d shape of each printed body, in its place
        in use; held_mm: thickness of the page that it holds, and of what lies on that; spread_mm: how far parts that
        lie on each other are drawn apart.
    Raises: FabricationError where what is read back is not what was written.
    """
    trimesh = cad_package("trimesh")
    scene, volumes = trimesh.Scene(), {}
    half_x, half_y = half_board_mm(badge)
    page = (-half_x, -half_y, half_x, half_y)
    # The mount is next to the stack, or alone in the middle.
    aside = [2.2 * half_x + 60.0 if stack else 0.0, 0.0, 0.0]
    pieces = [(name, mesh.copy(), [0.0, 0.0, spread_mm * STEPS[name.split("-")[0]]]) for name, mesh in stack]
    bodies = [*mount, *(_held(badge, *held_mm) if mount else [])]
    pieces += [(name, _mesh(shape), aside) for name, shape in bodies]
    for name, mesh, place in pieces:
        volumes[name] = float(mesh.volume)
        mesh.apply_translation(place)
        mesh.apply_scale(METRES_PER_MM)
        mesh.visual = trimesh.visual.TextureVisuals(material=_material(trimesh, name.split("-")[0]))
        scene.add_geometry(mesh, geom_name=name, node_name=name)
    tops = [(0.0, 0.0, float(mesh.bounds[1][2]) + spread_mm * STEPS[name]) for name, mesh in stack if name == "page"]
    if mount:
        tops.append((aside[0], 0.0, held_mm[0]))
    for k, top in enumerate(tops):
        picture = _picture(trimesh, badge, page, top)
        scene.add_geometry(picture, geom_name=f"picture-{k}", node_name=f"picture-{k}")
    path.write_bytes(scene.export(file_type="glb"))
    check_glb(path, volumes)


def check_glb(path: Path, volumes_mm3: dict[str, float]) -> None:
    """Read a GLB file back: every part there, closed, and of its volume.

    Raises: FabricationError with what was found and what is allowed.
    """
    trimesh = cad_package("trimesh")
    try:
        scene = trimesh.load(path, file_type="glb", force="scene")
    except (ValueError, KeyError, OSError) as error:
        raise FabricationError("stack.glb cannot be read back; nothing was kept: report this") from error
    found = {name: mesh for name, mesh in scene.geometry.items() if not name.startswith("picture")}
    if set(found) != set(volumes_mm3):
        raise FabricationError(
            f"stack.glb holds the parts {sorted(found)}, allowed are {sorted(volumes_mm3)}; nothing was kept: report "
            "this"
        )
    for name, mesh in found.items():
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        volume_mm3 = float(mesh.volume) / METRES_PER_MM**3
        if not mesh.is_watertight or not math.isclose(volume_mm3, volumes_mm3[name], rel_tol=1e-3):
            raise FabricationError(
                f"stack.glb holds {name} with {volume_mm3:.1f} mm³, allowed is a closed body of "
                f"{volumes_mm3[name]:.1f} mm³; nothing was kept: report this"
            )


def _parts(cq: Any, plan: AcrylicPlan) -> list[_Part]:
    """The stack's parts, the base first; each lies on one that comes before it."""
    page_x, page_y = plan.page[2], plan.page[3]
    parts = [
        _Part("base", _plate(cq, plan.base), plan.base.thickness_mm, ""),
        _Part("page", _box(cq, (-page_x, -page_y, page_x, page_y), plan.card_mm), plan.card_mm, "base"),
        _Part("frame", _plate(cq, plan.frame), plan.frame.thickness_mm, "base"),
    ]
    lens_mm = plan.sheet_top - plan.card_mm
    names = ["sheet"] if len(plan.sheets) == 1 else [f"sheet-{k}" for k in range(len(plan.sheets))]
    parts += [
        _Part(name, _box(cq, rect, lens_mm), lens_mm, "page") for name, rect in zip(names, plan.sheets, strict=True)
    ]
    parts.append(_Part("cover", _plate(cq, plan.cover), plan.cover.thickness_mm, names[0]))
    shank = plan.base.thickness_mm + plan.sheet_top + plan.cover.thickness_mm
    head = cq.Solid.makeCylinder(HEAD_MM / 2, HEAD_HIGH_MM)
    screw = head.fuse(cq.Solid.makeCylinder(THREAD_MM / 2, shank + HEAD_HIGH_MM, (0, 0, -shank)))
    # Moved copies share one shape, which the kernel divides into triangles once.
    places = [cq.Location((x, y, 0)) for x, y in plan.screws]
    parts += [_Part(f"screw-{k}", screw.moved(place), HEAD_HIGH_MM, "cover") for k, place in enumerate(places)]
    return parts


def _held(badge: Badge, card_mm: float, sheet_mm: float) -> list[tuple[str, Any]]:
    """Page and lens sheets as they lie in the printed tray."""
    cq = cad_package("cadquery")
    half_x, half_y = half_board_mm(badge)
    held = [("page-held", _box(cq, (-half_x, -half_y, half_x, half_y), card_mm))]
    for k, rect in enumerate(sheet_rects(badge)):
        sheet = _box(cq, rect, sheet_mm)
        held.append((f"sheet-held-{k}", sheet.moved(cq.Location((0, 0, card_mm)))))
    return held


def _planned_lows(plan: AcrylicPlan, parts: list[_Part]) -> dict[str, float]:
    """Heights of the lower faces above the base's lower face, from the plan alone."""
    on_cover = plan.sheet_top + plan.cover.thickness_mm
    lows = {"page": 0.0, "frame": 0.0, "sheet": plan.card_mm, "cover": plan.sheet_top, "screw": on_cover}
    above = {part.name: plan.base.thickness_mm + lows[part.name.split("-")[0]] for part in parts[1:]}
    return {"base": 0.0, **above}


def _plate(cq: Any, plate: Plate) -> Any:
    outer, *inner = (_wire(cq, path.vertices()) for path in (plate.outline, *plate.openings))
    return cq.Solid.extrudeLinear(outer, inner, cq.Vector(0, 0, plate.thickness_mm))


def _wire(cq: Any, vertices: list[tuple[float, float, float]]) -> Any:
    """A closed wire of lines and arcs from vertices with bulges."""
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


def _box(cq: Any, rect: Rect, thick_mm: float) -> Any:
    return cq.Solid.makeBox(rect[2] - rect[0], rect[3] - rect[1], thick_mm, cq.Vector(rect[0], rect[1], 0))


def _mesh(shape: Any) -> Any:
    vertices, faces = shape.tessellate(FINE_MM, FACET_ANGLE_RAD)
    # The kernel's last digits change from run to run, and the same badge is to give the same bytes.
    places = np.round([tuple(vertex) for vertex in vertices], 5)
    return cad_package("trimesh").Trimesh(places, faces)


def _material(trimesh: Any, kind: str) -> Any:
    colour = COLOURS[kind]
    return trimesh.visual.material.PBRMaterial(
        name=kind,
        baseColorFactor=colour,
        metallicFactor=0.0,
        roughnessFactor=0.4,
        alphaMode="OPAQUE" if colour[3] == 255 else "BLEND",
    )


def _picture(trimesh: Any, badge: Badge, page: Rect, place: tuple[float, float, float]) -> Any:
    """The board's print as a picture just above the page's face."""
    from moireid.fabrication.page.preview import draw_preview

    x0, y0, x1, y1 = page
    corners = np.array([(x0, y0, 0.02), (x1, y0, 0.02), (x1, y1, 0.02), (x0, y1, 0.02)]) + np.array(place)
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    material = trimesh.visual.material.PBRMaterial(
        name="print", baseColorTexture=draw_preview(badge).convert("RGB"), metallicFactor=0.0, roughnessFactor=0.9
    )
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(corners * METRES_PER_MM, [(0, 1, 2), (0, 2, 3)], visual=visual, process=False)
