"""The printed mount as STL files, one a part, and a 3MF file of all, that are each read back and checked.

The mount is the tray with lanyard, clip or stand.

Convention: the frame of `sight`, its origin on the tray's floor.  The files hold the bodies as they lie on the bed:
the tray on its back, clip or stand in the 3MF file to the right of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication.part_colours import COLOURS, kind_of
from moireid.fabrication.printed.holders import HolderBody, as_printed, in_use, plan_holder, shape_holder
from moireid.fabrication.printed.tray import TrayPlan, plan_tray
from moireid.fabrication.printed.tray_shape import shape_tray
from moireid.fabrication.process_figures import BED_MM, LEAST_WALL_MM, MountProcess
from moireid.fabrication.solids import (
    Body,
    cad_package,
    check_3mf,
    check_overhangs,
    check_stl,
    check_walls,
    export_3mf,
    export_stl,
    solid_of,
)

#: Kinds, and lanyard slots of each: a badge on two cords keeps still; a clip has one hook; a stand needs none.
SLOTS = {"lanyard": 2, "clip": 1, "stand": 0}
KINDS = tuple(SLOTS)
PLA_G_PER_MM3 = 1.24e-3


@dataclass(frozen=True)
class MountReport:
    """The files that were written and checked, and what the parts will be.

    stls: one a body; mass_g: of solid PLA.
    """

    stls: tuple[Path, ...]
    mass_g: float
    bodies: tuple[Body, ...]


#: Figures of a mount, checked: of a tray, and of what carries it.
MountPlan = tuple[TrayPlan, HolderBody | None]


def plan_mount(badge: Badge, kind: str, process: MountProcess) -> MountPlan:
    """The figures of a mount, of a tray and what carries it, checked in milliseconds, before any CAD package is needed.

    Raises: FabricationError where a lip, a rim or a wall would hide fringes or markers, or a body is larger than a
        printer.
    """
    plan = plan_tray(badge, process, slots=SLOTS[kind])
    holder = plan_holder(badge, plan, process, kind)
    _check_bed("tray", 2 * plan.out_x, plan.tab_top - plan.bottom, plan.lip_top + process.back_mm)
    if holder:
        _check_bed(holder.name, *holder.size_mm, holder.width_mm)
    return plan, holder


def mount_stls(plan: MountPlan) -> list[str]:
    """Names of the STL files of a mount: mount.stl is the tray's."""
    _, holder = plan
    return ["mount.stl", *([f"mount-{holder.name}.stl"] if holder else [])]


def mount_bodies(
    badge: Badge, kind: str, process: MountProcess | None = None, plan: MountPlan | None = None
) -> tuple[Body, ...]:
    """The bodies of a mount; the tray is the first.

    Parameters: kind: one of `KINDS`; plan: as `plan_mount` gives it, None to plan it here.
    Raises: FabricationError where a lip, a rim or a wall would hide fringes or markers, a body is larger than a
        printer, or no solid can be made so; MissingExtraError without build123d.
    """
    process = process or MountProcess()
    tray, holder = plan or plan_mount(badge, kind, process)
    b3d = cad_package("build123d")
    try:
        shape = shape_tray(b3d, tray, process)
        bodies = [Body("tray", shape, shape)]
        if holder:
            shape = shape_holder(b3d, holder)
            on_bed = as_printed(b3d, holder, shape, tray, process)
            bodies.append(Body(holder.name, on_bed, shape.moved(in_use(b3d, holder, tray))))
    except (ValueError, RuntimeError) as error:
        raise FabricationError(f"no mount can be shaped of {process} ({error}); go back to the defaults") from error
    return tuple(bodies)


def write_mount(
    badge: Badge,
    folder: Path,
    *,
    kind: str = "lanyard",
    process: MountProcess | None = None,
    plan: MountPlan | None = None,
    bodies: tuple[Body, ...] = (),
) -> MountReport:
    """Write the STL files and mount.3mf into a folder that holds neither, and read all back.

    Parameters: plan: as for `mount_bodies`; bodies: as that gives them, none to shape them here.
    Raises: as `mount_bodies`; FabricationError where a file fails its check.
    """
    process = process or MountProcess()
    plan = plan or plan_mount(badge, kind, process)
    stls, three_mf = tuple(folder / name for name in mount_stls(plan)), folder / "mount.3mf"
    bodies, (tray, _), meshes = bodies or mount_bodies(badge, kind, process, plan), plan, []
    for body, path in zip(bodies, stls, strict=True):
        export_stl(body.on_bed, path)
        meshes.append(check_stl(path, body))
        check_overhangs(meshes[-1], body.name)
    named = [(body.name, mesh, COLOURS[kind_of(body.name)]) for body, mesh in zip(bodies, meshes, strict=True)]
    export_3mf(named, three_mf)
    check_3mf(three_mf, bodies)
    _check_bodies(bodies, meshes, tray, process)
    return MountReport(stls, sum(body.volume_mm3 for body in bodies) * PLA_G_PER_MM3, bodies)


def _check_bed(name: str, *sides_mm: float) -> None:
    if (longest := max(sides_mm)) > BED_MM:
        raise FabricationError(
            f"the mount's {name} is {longest:.0f} mm long, and common printers reach {BED_MM:g} mm; give a smaller "
            "board (size_mm)",
            longest_mm=longest,
        )


def _check_bodies(bodies: tuple[Body, ...], meshes: list[Any], plan: TrayPlan, process: MountProcess) -> None:
    """Check that no wall is too thin.  Raises: FabricationError."""
    levels = [-process.back_mm / 2, plan.side_top - 0.1, plan.rim_top - 0.1]
    levels.append(plan.rim_top + (process.lip_mm - plan.chamfer) / 2)
    check_walls(solid_of(meshes[0]), levels, LEAST_WALL_MM, "tray")
    for body, mesh in zip(bodies[1:], meshes[1:], strict=True):
        low, high = body.lower_mm[2], body.upper_mm[2]
        check_walls(
            solid_of(mesh), [low + share * (high - low) for share in (0.04, 0.5, 0.9)], LEAST_WALL_MM, body.name
        )
