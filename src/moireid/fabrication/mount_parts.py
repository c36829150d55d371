"""Which mounts can be made for a badge, their solids, and their files.

Of a mount the printed one and the acrylic stack are made, if they can be made; both are planned before anything.  If
only one of the two can be made, it is made, and the report says why the other is left out.  The wish is refused if
neither can be made, or if the user gave figures for the one that cannot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication.process_figures import MountFigures

if TYPE_CHECKING:
    from PIL import Image

    from moireid.fabrication.acrylic.plates import AcrylicPlan
    from moireid.fabrication.assembly.guide import DrawnMounts
    from moireid.fabrication.printed.mount import MountPlan, MountReport
    from moireid.fabrication.solid_parts import SolidPart
    from moireid.fabrication.solids import Body

#: Kinds of the printed mount, as `printed.mount.SLOTS`; or none.
MOUNTS = ("lanyard", "clip", "stand", "none")
GLB_FILE = "mount.glb"
#: Patterns of the files that a badge's folder has only with some mounts.
PART_FILES = ("mount.step", "mount*.stl", "mount.3mf", "acrylic*.dxf", "acrylic*.svg", "acrylic.step", GLB_FILE)


@dataclass(frozen=True)
class Parts:
    """The mounts that can be made for a badge.

    printed: the printed mount's kind, "none" without one; acrylic: the stack's plan, None without one; left_out: why
    "printed" or "acrylic" is not made, one sentence each; mount_plan: of the printed mount, None without one.
    """

    printed: str
    acrylic: AcrylicPlan | None
    figures: MountFigures
    left_out: dict[str, str] = field(default_factory=dict)
    mount_plan: MountPlan | None = None

    @property
    def files(self) -> tuple[str, ...]:
        """Names of the files that `write_parts` writes."""
        found: list[str] = []
        if self.mount_plan:
            from moireid.fabrication.printed.mount import mount_stls

            found += ["mount.step", *mount_stls(self.mount_plan), "mount.3mf"]
        if self.acrylic:
            found += [f"{name}.{kind}" for name in self.acrylic.drawings for kind in ("dxf", "svg")]
            found.append("acrylic.step")
        return (*found, GLB_FILE) if found else ()


def plan_parts(badge: Badge, mount: str, figures: MountFigures | None = None) -> Parts:
    """Plan the mounts that can be made; takes milliseconds and writes nothing.

    Parameters
    ----------
    mount : str
        One of `MOUNTS`.
    figures : MountFigures, optional
        Of printer and laser, mm; None for the defaults.

    Raises
    ------
    FabricationError
        With what, got, allowed and the next step, where no mount can be made, or not the one that the figures ask for.
    """
    figures = figures or MountFigures()
    if mount not in MOUNTS:
        raise FabricationError(f"mount {mount!r} is not known; choose one of {', '.join(MOUNTS)}")
    if mount == "none":
        return Parts("none", None, figures)
    from moireid.fabrication.acrylic.drawings import check_cuts
    from moireid.fabrication.acrylic.plates import plan_acrylic
    from moireid.fabrication.printed.mount import plan_mount

    faults: dict[str, FabricationError] = {}
    stack: AcrylicPlan | None = None
    mount_plan: MountPlan | None = None
    try:
        mount_plan = plan_mount(badge, mount, figures.printed)
    except FabricationError as error:
        faults["printed"] = error
    try:
        stack = plan_acrylic(badge, figures.acrylic)
        for plate in stack.plates:
            check_cuts(plate, figures.acrylic.kerf_mm)
    except FabricationError as error:
        stack, faults["acrylic"] = None, error
    for shop in ("printed", "acrylic"):
        if shop in faults and shop in figures.insisted:
            raise faults[shop]
    if len(faults) == 2:
        raise FabricationError(
            f"no mount can be made: printed, {faults['printed']}; in acrylic, {faults['acrylic']}; or take no mount"
        ) from faults["printed"]
    left_out = {shop: str(error) for shop, error in faults.items()}
    return Parts("none" if mount_plan is None else mount, stack, figures, left_out, mount_plan)


@dataclass(frozen=True)
class MountSolids:
    """The solids of mounts.

    bodies: of the printed mount as they lie on the bed, none without one; placed: all parts in their places in use, of
    "printed" and of "acrylic", as far as they are made; drawn: the same for the exploded views.
    """

    bodies: tuple[Body, ...]
    placed: dict[str, tuple[SolidPart, ...]]
    drawn: DrawnMounts


def shape_parts(badge: Badge, parts: Parts) -> MountSolids:
    """Make the solids of mounts and check that they have room and touch where they must; takes a second or two.

    Raises: FabricationError where they do not; MissingExtraError without the CAD packages.
    """
    if not parts.files:
        return MountSolids((), {}, {})
    from moireid.fabrication.assembly.solid_views import drawn_solids
    from moireid.fabrication.printed.mount import mount_bodies
    from moireid.fabrication.solid_parts import acrylic_parts, check_parts, printed_parts
    from moireid.fabrication.solids import CAD_PACKAGES, cad_package

    # The kernel takes seconds to load, so the small packages are imported first, in case one is missing.
    for name in CAD_PACKAGES:
        cad_package(name)
    bodies: tuple[Body, ...] = ()
    placed: dict[str, tuple[SolidPart, ...]] = {}
    if parts.mount_plan:
        process = parts.figures.printed
        bodies = mount_bodies(badge, parts.printed, process, parts.mount_plan)
        placed["printed"] = printed_parts(badge, parts.mount_plan, bodies, process)
    if parts.acrylic:
        placed["acrylic"] = acrylic_parts(parts.acrylic)
    for solids in placed.values():
        check_parts(solids)
    return MountSolids(bodies, placed, {shop: drawn_solids(solids) for shop, solids in placed.items()})


def write_parts(
    badge: Badge,
    parts: Parts,
    folder: Path,
    say: Callable[[str], None],
    solids: MountSolids | None = None,
    picture: Image.Image | None = None,
) -> float | None:
    """Write the files of a mount, and read back those from which parts are made.

    Parameters
    ----------
    say : callable
        Called with the name of the next file.
    solids : MountSolids, optional
        As `shape_parts` gives them; None to make them here.
    picture : PIL.Image.Image, optional
        The board as `write_sheets` drew it; None to draw it here.

    Returns
    -------
    float or None
        Mass of the printed mount, g, None without one.

    Raises
    ------
    FabricationError
        Where a file fails its check.
    MissingExtraError
        Without the CAD packages.
    """
    if not parts.files:
        return None
    from moireid.fabrication.assembly_files import write_assembly_step, write_glb
    from moireid.fabrication.printed.mount import write_mount

    report: MountReport | None = None
    # The drawing is made in milliseconds, the solids take seconds.
    if parts.acrylic:
        say(", ".join(name for name in parts.files if name.endswith((".dxf", ".svg"))))
        _write_drawings(parts.acrylic, parts.figures.acrylic.kerf_mm, folder)
    solids = solids or shape_parts(badge, parts)
    if parts.mount_plan:
        say(", ".join(name for name in parts.files if name.endswith((".stl", ".3mf"))))
        figures, plan = parts.figures.printed, parts.mount_plan
        report = write_mount(badge, folder, kind=parts.printed, process=figures, plan=plan, bodies=solids.bodies)
    for shop, placed in solids.placed.items():
        name = {"printed": "mount.step", "acrylic": "acrylic.step"}[shop]
        say(name)
        write_assembly_step(f"{shop} mount", placed, folder / name)
    say(GLB_FILE)
    write_glb(badge, solids.placed, folder / GLB_FILE, picture)
    return report.mass_g if report else None


def _write_drawings(stack: AcrylicPlan, kerf_mm: float, folder: Path) -> None:
    from moireid.fabrication.acrylic.drawings import check_dxf, check_svg, draw, write_dxf, write_svg

    for name, drawing in draw(stack, kerf_mm).items():
        write_dxf(drawing, folder / f"{name}.dxf")
        check_dxf(folder / f"{name}.dxf", drawing)
        write_svg(drawing, folder / f"{name}.svg")
        check_svg(folder / f"{name}.svg", drawing)
