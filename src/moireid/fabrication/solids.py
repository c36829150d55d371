"""Reads a solid's STEP and STL files back, and refuses what a slicer or a workshop could not use.

A CAD kernel writes a broken shape without any error.  So every file is read again: the STEP by the kernel, the STL by
two packages that share no code with it.

Convention: mm and mm³, in the part's own frame.  The CAD packages are imported where they are used, because the
kernel alone takes seconds.
"""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from moireid.errors import FabricationError
from moireid.extras import missing_extra

#: The volume that the kernel may lose by writing a STEP file and reading it again, as a share.
STEP_VOLUME_SHARE = 1e-6
#: The volume that flat triangles may change at rounded edges, as a share.
STL_VOLUME_SHARE = 0.005
#: The difference of two packages over the volume of one mesh, as a share.
MANIFOLD_VOLUME_SHARE = 0.001
BOUNDS_MM = 0.05
#: Without it, a STEP file would hold the time of writing, and the same badge would never give the same bytes.
STEP_TIMESTAMP = "2000-01-01T00:00:00"
#: Between neighbouring facets of a bend, rad: the knee of `moireid bench fabricate`, 2 um off in a sixth of a second.
FACET_ANGLE_RAD = 0.1

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class ExpectedSolid:
    """What a file must turn out to hold: the CAD volume, the designed bounding box, and the number of solids."""

    volume_mm3: float
    lower_mm: Corner
    upper_mm: Corner
    solids: int = 1


def cad_package(name: str) -> Any:
    """Import an optional CAD package.  Raises: MissingExtraError that names the extra where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise missing_extra("a mount, which you may leave out,", name, "cad") from error


def export_step(part: Any, path: Path) -> None:
    """Write a build123d part as STEP, mm.  Raises: FabricationError where the kernel cannot write."""
    b3d = cad_package("build123d")
    try:
        b3d.export_step(part, path, timestamp=STEP_TIMESTAMP)
    except RuntimeError as error:
        raise FabricationError(f"{path.suffix} file in {path.parent} could not be written; check the disk") from error


def export_stl(part: Any, path: Path, *, tolerance_mm: float, angle_rad: float = FACET_ANGLE_RAD) -> None:
    """Write a build123d part as binary STL, mm, its facets at most tolerance_mm off the true surface.

    angle_rad: between neighbouring facets of a bend; on a mount's small bends it decides, not the tolerance.
    Raises: FabricationError where the tolerance is not positive, or the kernel cannot write.
    """
    if not (math.isfinite(tolerance_mm) and tolerance_mm > 0):
        raise FabricationError(f"tolerance_mm={tolerance_mm:g} must be positive; 0.05 suits most printers")
    b3d = cad_package("build123d")
    if not b3d.export_stl(part, path, tolerance=tolerance_mm, angular_tolerance=angle_rad):
        raise FabricationError(f"{path.suffix} file in {path.parent} could not be written; check the disk")


def check_step(path: Path, expected: ExpectedSolid) -> None:
    """Read a STEP file back: it must hold valid closed solids of the expected number, volume and place.

    Raises: FabricationError with what was found, what is allowed and what to do.
    """
    b3d = cad_package("build123d")
    try:
        solids = b3d.import_step(path).solids()
    except (ValueError, RuntimeError, OSError) as error:
        raise refused("STEP file", "cannot be read back", "a readable file") from error
    if len(solids) != expected.solids:
        raise refused("STEP file", f"holds {len(solids)} solids", f"exactly {expected.solids}", solids=len(solids))
    if not all(solid.is_valid and solid.is_manifold for solid in solids):
        raise refused("STEP file", "holds a solid that is not valid and closed", "a valid closed solid")
    check_volume("STEP file", sum(solid.volume for solid in solids), expected.volume_mm3, STEP_VOLUME_SHARE)
    boxes = [solid.bounding_box() for solid in solids]
    lower = np.min([tuple(box.min) for box in boxes], axis=0)
    _check_bounds("STEP file", (tuple(lower), tuple(np.max([tuple(box.max) for box in boxes], axis=0))), expected)


def check_stl(path: Path, expected: ExpectedSolid) -> int:
    """Read an STL file back: it must bound one volume, as trimesh and manifold3d each find, of the expected size.

    Returns: the number of triangles.
    Raises: FabricationError with what was found, what is allowed and what to do.
    """
    mesh = read_mesh(path)
    if not mesh.is_watertight:
        raise refused("STL file", "holds a surface with holes", "a closed surface")
    if not mesh.is_winding_consistent:
        raise refused("STL file", "holds triangles that face both ways", "all facing outwards")
    volume_mm3 = float(mesh.volume)
    check_volume("STL file", volume_mm3, expected.volume_mm3, STL_VOLUME_SHARE)
    _check_bounds("STL file", (tuple(mesh.bounds[0]), tuple(mesh.bounds[1])), expected)
    _check_manifold(mesh, volume_mm3)
    return len(mesh.faces)


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


def _check_manifold(mesh: Any, volume_mm3: float) -> None:
    """Let manifold3d build a solid of the mesh: it refuses one whose edges do not each join two triangles."""
    manifold3d = cad_package("manifold3d")
    vertices = np.asarray(mesh.vertices, dtype=np.float32)
    solid = manifold3d.Manifold(manifold3d.Mesh(vertices, np.asarray(mesh.faces, dtype=np.uint32)))
    if solid.status() != manifold3d.Error.NoError:
        raise refused("STL file", f"is no manifold ({solid.status().name})", "NoError from manifold3d")
    check_volume("STL file as manifold3d reads it", solid.volume(), volume_mm3, MANIFOLD_VOLUME_SHARE)


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


def _check_bounds(what: str, corners: tuple[tuple[float, ...], tuple[float, ...]], expected: ExpectedSolid) -> None:
    got = np.array(corners, dtype=float)
    wanted = np.array([expected.lower_mm, expected.upper_mm])
    off_mm = float(np.abs(got - wanted).max())
    if not off_mm <= BOUNDS_MM:
        raise refused(
            what,
            f"reaches from {got[0].round(3).tolist()} to {got[1].round(3).tolist()} mm",
            f"{wanted[0].round(3).tolist()} to {wanted[1].round(3).tolist()} mm give or take {BOUNDS_MM:g} mm",
            off_mm=off_mm,
        )


def refused(what: str, got: str, allowed: str, **details: object) -> FabricationError:
    """The error of a file that failed its check."""
    return FabricationError(
        f"the part's {what} {got}, allowed is {allowed}; nothing was kept: choose other process figures, "
        "and report this if the defaults fail",
        **details,
    )
