"""A mount put together as files: STEP with names and colours for CAD programs, and mount.glb for a viewer.

Both hold each part in its place in use, after `solid_parts.check_parts` found it closed and where it fits.  mount.glb
holds the printed mount and the stack in acrylic next to each other, each as a node with its parts below it, and the
badge's print on the page.

Convention: STEP has mm and the frame of `sight`.  glTF has metres, and its own axes are the frame's (x right, y up, z
towards the viewer).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication.page.preview import draw_preview
from moireid.fabrication.part_colours import kind_of, linear_colour
from moireid.fabrication.sight import half_board_mm
from moireid.fabrication.solid_parts import SolidPart
from moireid.fabrication.solids import cad_package

METRES_PER_MM = 1e-3
#: Between the printed mount and the stack in acrylic, mm.
APART_MM = 60.0
#: An occurrence of a part in a STEP assembly (ISO 10303-44), which the kernel gives a name such as "=>[0:1:1:2]".
_PLACE = re.compile(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('[^']*','[^']*'")


def write_assembly_step(name: str, parts: Sequence[SolidPart], path: Path) -> None:
    """Write the parts as one STEP assembly of that name.  Raises: FabricationError where the kernel cannot write."""
    b3d = cad_package("build123d")
    whole = b3d.Compound(label=name, children=[part.shape for part in parts])
    try:
        b3d.export_step(whole, path)
    except RuntimeError as error:
        raise FabricationError(f"{path.name} in {path.parent} could not be written; check the disk") from error
    places = iter([f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{k}','{part.name}'" for k, part in enumerate(parts, start=1)])
    step = _PLACE.sub(lambda found: next(places, found[0]), path.read_text(encoding="utf-8"))
    path.write_text(step, encoding="utf-8")


def write_glb(
    badge: Badge, mounts: Mapping[str, Sequence[SolidPart]], path: Path, picture: Image.Image | None = None
) -> None:
    """Write mounts next to each other as binary glTF, each put together.

    Parameters
    ----------
    mounts : mapping of str to sequence of SolidPart
        The parts of each mount, by the name of its node; a part's node is called "MOUNT-PART".
    picture : PIL.Image.Image, optional
        The board as `preview.draw_preview` drew it; None to draw it.
    """
    trimesh = cad_package("trimesh")
    scene = trimesh.Scene()
    printed, half_mm = (picture or draw_preview(badge)).convert("RGB"), half_board_mm(badge)
    right_mm = 0.0
    for mount, parts in mounts.items():
        meshes = {part.name: part.mesh.copy() for part in parts}
        low_x = min(float(mesh.bounds[0][0]) for mesh in meshes.values())
        place_mm = right_mm - low_x if right_mm else 0.0
        right_mm = place_mm + max(float(mesh.bounds[1][0]) for mesh in meshes.values()) + APART_MM
        move = trimesh.transformations.translation_matrix((place_mm * METRES_PER_MM, 0, 0))
        scene.graph.update(frame_from=scene.graph.base_frame, frame_to=mount, matrix=move)
        page_top = float(meshes["page"].bounds[1][2])
        for name, mesh in meshes.items():
            mesh.visual = trimesh.visual.TextureVisuals(material=_material(trimesh, kind_of(name)))
            _add(scene, mesh, f"{mount}-{name}", mount)
        _add(scene, _print_of(trimesh, printed, half_mm, page_top), f"{mount}-print", mount)
    path.write_bytes(scene.export(file_type="glb"))


def _add(scene: Any, mesh: Any, name: str, mount: str) -> None:
    mesh.apply_scale(METRES_PER_MM)
    scene.add_geometry(mesh, geom_name=name, node_name=name, parent_node_name=mount)


def _material(trimesh: Any, kind: str) -> Any:
    colour = linear_colour(kind)
    return trimesh.visual.material.PBRMaterial(
        name=kind,
        baseColorFactor=[round(255 * value) for value in colour],
        metallicFactor=0.0,
        roughnessFactor=0.4,
        alphaMode="OPAQUE" if colour[3] == 1 else "BLEND",
    )


def _print_of(trimesh: Any, picture: Image.Image, half_mm: tuple[float, float], top_mm: float) -> Any:
    """The board's print as a picture just above the page's face."""
    x, y = half_mm
    corners = np.array([(-x, -y, 0.02), (x, -y, 0.02), (x, y, 0.02), (-x, y, 0.02)]) + np.array([0.0, 0.0, top_mm])
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    material = trimesh.visual.material.PBRMaterial(
        name="print", baseColorTexture=picture, metallicFactor=0.0, roughnessFactor=0.9
    )
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(corners, [(0, 1, 2), (0, 2, 3)], visual=visual, process=False)
