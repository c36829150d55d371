"""The acrylic stack put together, and stack.glb to look at it.

Each part is put at the height that `plates.py` planned.  Then no two parts may share any volume, and each must touch
the part that it lies on.

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
from moireid.fabrication.solids import FACET_ANGLE_RAD, FINE_MM, cad_package, cuboid, overlap_mm3

#: Parts that lie on each other may be this far apart, and share this much volume: rounding errors.
TOUCH_MM, TOUCH_MM3 = 1e-3, 0.01
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
class StackPart:
    """One part in its place: its name, its manifold3d Manifold, and the part on whose upper face it lies."""

    name: str
    body: Any
    on: str


def assemble(plan: AcrylicPlan) -> list[StackPart]:
    """The stack's parts from behind to the front, each where it was planned."""
    top = plan.sheet_top + plan.cover.thickness_mm
    sheets = [cuboid(rect, plan.card_mm, plan.sheet_top) for rect in plan.sheets]
    names = ["sheet"] if len(sheets) == 1 else [f"sheet-{k}" for k in range(len(sheets))]
    shank = _cylinder(THREAD_MM, top + plan.base.thickness_mm).translate((0, 0, -plan.base.thickness_mm))
    screw = shank + _cylinder(HEAD_MM, HEAD_HIGH_MM).translate((0, 0, top))
    return [
        StackPart("base", _plate(plan.base), ""),
        StackPart("page", cuboid(plan.page, 0.0, plan.card_mm), "base"),
        StackPart("frame", _plate(plan.frame), "base"),
        *(StackPart(name, sheet, "page") for name, sheet in zip(names, sheets, strict=True)),
        StackPart("cover", _plate(plan.cover), names[0]),
        *(StackPart(f"screw-{k}", screw.translate((x, y, 0)), "cover") for k, (x, y) in enumerate(plan.screws)),
    ]


def check_stack(plan: AcrylicPlan) -> list[tuple[str, Any]]:
    """Check that no two parts of the stack share any volume, and that each touches the one that it lies on.

    Returns
    -------
    list of (str, trimesh.Trimesh)
        Name and mesh of each part in its place, mm.

    Raises
    ------
    FabricationError
        With the volume that two parts share, or the gap between two that must touch.
    """
    parts = assemble(plan)
    bodies = {part.name: part.body for part in parts}
    for k, part in enumerate(parts):
        for other in parts[:k]:
            if (shared := overlap_mm3(part.body, other.body)) > TOUCH_MM3:
                raise FabricationError(
                    f"the stack's {part.name} and {other.name} share {shared:.2f} mm³, allowed is none; choose other "
                    "process figures, and report this if the defaults fail",
                    overlap_mm3=shared,
                )
        if part.on and (gap_mm := bodies[part.on].min_gap(part.body, 10.0)) > TOUCH_MM:
            raise FabricationError(
                f"the stack's {part.name} is {gap_mm:.4f} mm from the {part.on} that it lies on, allowed are "
                f"{TOUCH_MM:g} mm; nothing was kept: report this",
                off_mm=gap_mm,
            )
    return [(part.name, _mesh(part.body)) for part in parts]


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

    Parameters
    ----------
    stack : list of (str, trimesh.Trimesh)
        As `check_stack` returns it.
    mount : list of (str, build123d.Shape)
        Each printed body in its place in use.
    held_mm : (float, float)
        Thickness of the page that the mount holds, and of what lies on that, mm.
    spread_mm : float
        How far parts that lie on each other are drawn apart, mm.

    Raises
    ------
    FabricationError
        Where what is read back is not what was written.
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


def _held(badge: Badge, card_mm: float, sheet_mm: float) -> list[tuple[str, Any]]:
    """Page and lens sheets as they lie in the printed tray."""
    half_x, half_y = half_board_mm(badge)
    sheets = [cuboid(rect, card_mm, card_mm + sheet_mm) for rect in sheet_rects(badge)]
    page = ("page-held", cuboid((-half_x, -half_y, half_x, half_y), 0.0, card_mm))
    return [page, *((f"sheet-held-{k}", sheet) for k, sheet in enumerate(sheets))]


def _plate(plate: Plate) -> Any:
    section = cad_package("manifold3d").CrossSection
    body = section([plate.outline.flat()])
    for opening in plate.openings:
        body -= section([opening.flat()])
    return body.extrude(plate.thickness_mm).translate((0, 0, plate.low_mm))


def _cylinder(diameter_mm: float, high_mm: float) -> Any:
    sides = math.ceil(2 * math.pi / FACET_ANGLE_RAD)
    return cad_package("manifold3d").Manifold.cylinder(high_mm, diameter_mm / 2, circular_segments=sides)


def _mesh(shape: Any) -> Any:
    """A trimesh body of a Manifold or a build123d shape."""
    if hasattr(shape, "tessellate"):
        vertices, faces = shape.tessellate(FINE_MM, FACET_ANGLE_RAD)
        vertices = [tuple(vertex) for vertex in vertices]
    else:
        mesh = shape.to_mesh()
        vertices, faces = mesh.vert_properties[:, :3], mesh.tri_verts
    # The kernel's last digits change from run to run, and the same badge is to give the same bytes.
    return cad_package("trimesh").Trimesh(np.round(vertices, 5), faces)


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
