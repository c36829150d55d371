"""Writes solids as STL and 3MF, reads the files back, and refuses what a slicer could not use.

A CAD kernel writes a broken shape without any error.  So every file is read again, the STL by two packages that share
no code with the kernel.  Meshes are checked for interference, overhangs and thin walls.

A 3MF file is written by lib3mf, the format's reference implementation, and read back here as XML.

Convention: mm and mm³, in the part's own frame.  The CAD packages are imported where they are used, because the
kernel alone takes seconds.
"""

from __future__ import annotations

import ctypes
import importlib
import importlib.machinery
import importlib.util
import math
import os
import sys
import tempfile
import uuid
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from moireid.errors import FabricationError
from moireid.extras import missing_extra
from moireid.fabrication.part_colours import Rgba

#: The volume that flat triangles may change at rounded edges, as a share.
STL_VOLUME_SHARE = 0.005
BOUNDS_MM = 0.05
#: What mounts are made and checked by; the kernel, which takes seconds to load, is the last.
CAD_PACKAGES = ("trimesh", "manifold3d", "lib3mf", "build123d")
#: Where surfaces touch, float32 vertices leave overlaps thinner than 1e-5 mm; more than this is interference, mm3.
TOUCH_MM3 = 0.01
#: How far facets of what is printed may be off the true surface, mm.
FACET_MM = 0.05
#: The names of elements in a 3MF file begin so.
CORE_3MF = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
#: Between neighbouring facets of a bend, rad, which decides on a mount's small bends: the knee of
#: `moireid bench fabricate`, 2 um off in a sixth of a second.
FACET_ANGLE_RAD = 0.1

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class Body:
    """One printed body: its solid as it lies on the bed and in its place in use."""

    name: str
    on_bed: Any
    used: Any

    @cached_property
    def volume_mm3(self) -> float:
        """Its volume, which its files must hold."""
        return float(self.on_bed.volume)

    @property
    def lower_mm(self) -> Corner:
        """The lower corner of its bounding box, on the bed."""
        return tuple(self.on_bed.bounding_box().min)

    @property
    def upper_mm(self) -> Corner:
        """The upper one."""
        return tuple(self.on_bed.bounding_box().max)


def cad_package(name: str, purpose: str = "a mount, which you may leave out,") -> Any:
    """Import an optional CAD package.  Raises: MissingExtraError that names the extra where it is not installed."""
    try:
        with _some_home():
            if name == "build123d" and not {"sympy", name} & sys.modules.keys():
                sys.meta_path.insert(0, _LoadedOnUse)
            return importlib.import_module(name)
    except ImportError as error:
        raise missing_extra(purpose, name, "cad") from error


@contextmanager
def _some_home() -> Iterator[None]:
    """An empty home folder for a user who has none: ezdxf looks for its settings there while it is loaded."""
    if os.path.expanduser("~") != "~":
        yield
        return
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HOME"] = folder
        try:
            yield
        finally:
            del os.environ["HOME"]


class _LoadedOnUse:
    """Finds sympy, and has it loaded when a name of it is first used.

    build123d imports it for curves that no mount has, and it takes a third of what build123d takes to load.
    """

    @classmethod
    def find_spec(cls, name: str, path: object = None, target: object = None) -> importlib.machinery.ModuleSpec | None:
        """As `importlib` asks; None for all other packages."""
        if name != "sympy":
            return None
        sys.meta_path.remove(cls)
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.loader is not None:
            spec.loader = importlib.util.LazyLoader(spec.loader)
        return spec


def export_stl(part: Any, path: Path) -> None:
    """Write a build123d part as binary STL, mm.  Raises: FabricationError where the kernel cannot write."""
    b3d = cad_package("build123d")
    if not b3d.export_stl(part, path, tolerance=FACET_MM, angular_tolerance=FACET_ANGLE_RAD):
        raise FabricationError(f"{path.suffix} file in {path.parent} could not be written; check the disk")


def check_stl(path: Path, body: Body) -> Any:
    """Read an STL file back as a trimesh mesh: it must bound one volume, as trimesh and manifold3d each find, as large
    as the body and where that is.

    Raises: FabricationError with what was found, what is allowed and what to do.
    """
    mesh = read_mesh(path)
    if not mesh.is_watertight:
        raise refused("STL file", "holds a surface with holes", "a closed surface")
    if not mesh.is_winding_consistent:
        raise refused("STL file", "holds triangles that face both ways", "all facing outwards")
    check_volume("STL file", float(mesh.volume), body.volume_mm3, STL_VOLUME_SHARE)
    off_mm = float(np.abs(mesh.bounds - [body.lower_mm, body.upper_mm]).max())
    if not off_mm <= BOUNDS_MM:
        low, high = np.round(mesh.bounds, 3).tolist()
        wanted = f"{np.round(body.lower_mm, 3).tolist()} to {np.round(body.upper_mm, 3).tolist()} mm"
        raise refused(
            "STL file",
            f"reaches from {low} to {high} mm",
            f"{wanted} give or take {BOUNDS_MM:g} mm",
            off_mm=off_mm,
        )
    solid_of(mesh, "STL file")
    return mesh


def read_mesh(path: Path) -> Any:
    """An STL file as a trimesh mesh.  Raises: FabricationError where it cannot be read or holds no triangle."""
    trimesh = cad_package("trimesh")
    try:
        mesh = trimesh.load_mesh(path, file_type="stl")
    except (ValueError, KeyError, OSError) as error:
        raise refused("STL file", "cannot be read back", "a readable file") from error
    if not len(getattr(mesh, "faces", ())):
        raise refused("STL file", "holds no triangle", "a closed surface")
    return mesh


def check_volume(what: str, got_mm3: float, wanted_mm3: float, share: float) -> None:
    """Raise FabricationError where a volume is off by more than a share of what is wanted."""
    if not abs(got_mm3 - wanted_mm3) <= share * wanted_mm3:
        raise refused(
            what,
            f"holds {got_mm3:.1f} mm³",
            f"{wanted_mm3:.1f} mm³ give or take {100 * share:g} %",
            volume_mm3=got_mm3,
            expected_mm3=wanted_mm3,
        )


def refused(what: str, got: str, allowed: str, whose: str = "part's", **details: object) -> FabricationError:
    """The error of a file that failed its check."""
    return FabricationError(
        f"the {whose} {what} {got}, allowed is {allowed}; nothing was kept: choose other process figures, "
        "and report this if the defaults fail",
        **details,
    )


#: Facets of a solid that is checked for interference and shown, but not printed: mm and radians off the true surface.
FINE_MM, FINE_RAD = 0.02, 0.3
#: A corner's tip is always thinner than a wall; an area up to this in a slice does not count as a wall, mm².
TIP_MM2 = 0.05
#: Faces that look down and are flatter than this are printed in mid-air: at 45 degrees a layer of 0.2 mm reaches out by
#: less than half a line of 0.45 mm.  One degree less, because facets of a rounded chamfer are a little flatter.
OVERHANG_DEG = 44.0
#: A level step that is narrower than a line holds, because part of the line rests on the layer below.
STEP_MM = 0.42
#: Overhang that is accepted all the same, mm2: tips of the chamfer at the bed's corners.
MOST_OVERHANG_MM2 = 1.0


def export_3mf(bodies: Sequence[tuple[str, Any, Rgba]], path: Path) -> None:
    """Write named trimesh bodies as the objects of one 3MF file, mm, each in its colour."""
    lib3mf = cad_package("lib3mf")
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    group = model.AddBaseMaterialGroup()
    for name, mesh, colour in bodies:
        body = model.AddMeshObject()
        body.SetName(name)
        corners = [lib3mf.Position((ctypes.c_float * 3)(*vertex)) for vertex in mesh.vertices.tolist()]
        body.SetGeometry(corners, [lib3mf.Triangle((ctypes.c_uint32 * 3)(*face)) for face in mesh.faces.tolist()])
        material = group.AddMaterial(name, wrapper.RGBAToColor(*colour))
        body.SetObjectLevelProperty(group.GetResourceID(), material)
        item = model.AddBuildItem(body, wrapper.GetIdentityTransform())
        # Names of its own making would differ from run to run, and the same badge is to give the same bytes.
        body.SetUUID(str(uuid.uuid5(uuid.NAMESPACE_OID, name)))
        item.SetUUID(str(uuid.uuid5(uuid.NAMESPACE_OID, f"item {name}")))
    model.SetBuildUUID(str(uuid.uuid5(uuid.NAMESPACE_OID, "build")))
    path.write_bytes(bytes(model.QueryWriter("3mf").WriteToBuffer()))


def check_3mf(path: Path, bodies: Sequence[Body]) -> None:
    """Read a 3MF file back as the XML that it is: one closed body for each that is expected, of its volume.

    Raises: FabricationError with what was found, what is allowed and what to do.
    Source: 3MF core specification 1.3, sections 3 and 4.
    """
    trimesh = cad_package("trimesh")
    try:
        with zipfile.ZipFile(path) as archive:
            model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
        meshes = [
            trimesh.Trimesh(
                [[float(corner.attrib[key]) for key in ("x", "y", "z")] for corner in body.iter(f"{CORE_3MF}vertex")],
                [[int(face.attrib[key]) for key in ("v1", "v2", "v3")] for face in body.iter(f"{CORE_3MF}triangle")],
            )
            for body in model.iter(f"{CORE_3MF}object")
        ]
    except (zipfile.BadZipFile, ElementTree.ParseError, LookupError, ValueError) as error:
        raise refused("3MF file", "cannot be read back", "a readable file") from error
    if len(meshes) != len(bodies):
        raise refused("3MF file", f"holds {len(meshes)} bodies", f"exactly {len(bodies)}")
    for mesh, wanted in zip(meshes, bodies, strict=True):
        solid_of(mesh, "3MF file")
        check_volume("3MF file", float(mesh.volume), wanted.volume_mm3, STL_VOLUME_SHARE)


def solid_of(mesh: Any, what: str = "mesh") -> Any:
    """A manifold3d Manifold of a trimesh mesh.  Raises: FabricationError where it is not closed."""
    manifold3d = cad_package("manifold3d")
    solid = manifold3d.Manifold(
        manifold3d.Mesh(np.asarray(mesh.vertices, dtype=np.float32), np.asarray(mesh.faces, dtype=np.uint32))
    )
    if solid.status() != manifold3d.Error.NoError:
        raise refused(what, f"is no manifold ({solid.status().name})", "NoError from manifold3d")
    return solid


def check_walls(solid: Any, levels_mm: list[float], least_mm: float, name: str) -> None:
    """Check that no wall is thinner than `least_mm` in level slices through a Manifold.

    A slice is shrunk by half the least wall and grown again: thinner walls are lost by that.
    Raises: FabricationError with the area that is too thin.
    """
    miter = cad_package("manifold3d").JoinType.Miter
    for level in levels_mm:
        section = solid.slice(level)
        # Half a hundredth less, so that a wall of exactly the least thickness passes.
        kept = section.offset(0.005 - least_mm / 2, miter, 4.0).offset(least_mm / 2 + 0.05, miter, 4.0)
        if (lost := (section - kept).area()) > TIP_MM2:
            raise FabricationError(
                f"the mount's {name} has walls thinner than {least_mm:g} mm at z = {level:.2f} mm ({lost:.2f} mm² of "
                "them), which no printer fills; give a larger wall_mm or a smaller lip_reach_mm (mount_mm)",
                lost_mm2=lost,
            )


def overhang_mm2(mesh: Any) -> float:
    """Area of a trimesh body that a printer would print in mid-air, mm2, in the body's position on the bed.

    It is the area of faces that look down and are flatter than `OVERHANG_DEG`, without those on the bed.  Of level
    faces only the area farther than `STEP_MM` from the layer below counts.
    """
    down, bed = -mesh.face_normals[:, 2], mesh.bounds[0][2]
    above = mesh.triangles[:, :, 2].max(axis=1) > bed + 0.05
    level = above & (down > math.cos(math.radians(1.0)))
    steep = above & ~level & (down > math.cos(math.radians(OVERHANG_DEG)))
    solid, round_ = solid_of(mesh), cad_package("manifold3d").JoinType.Round
    total = float(mesh.area_faces[steep].sum())
    for height in np.unique(mesh.triangles[level][:, 0, 2].round(3)):
        below = solid.slice(float(height) - 0.01).offset(STEP_MM, round_)
        total += float((solid.slice(float(height) + 0.01) - below).area())
    return total


def check_overhangs(mesh: Any, name: str) -> None:
    """Check that a body prints without supports.  Raises: FabricationError with the area that hangs in the air."""
    if (area := overhang_mm2(mesh)) > MOST_OVERHANG_MM2:
        raise FabricationError(
            f"the mount's {name} has {area:.1f} mm² of faces that would be printed in mid-air, allowed are "
            f"{MOST_OVERHANG_MM2:g}; choose other process figures, and report this if the defaults fail",
            overhang_mm2=area,
        )
