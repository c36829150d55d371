"""Which mounts are made: the printed one and the acrylic stack, if they can be made.

Both are planned before anything is made.  If only one of the two can be made, it is made, and the report says why the
other is left out.  The wish is refused if neither can be made, or if the user gave figures for the one that cannot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication.acrylic.cutting import draw
from moireid.fabrication.acrylic.plates import AcrylicPlan, plan_acrylic
from moireid.fabrication.printed.mount import KINDS, MountPlan, MountReport, plan_mount, write_mount
from moireid.fabrication.process_figures import MountFigures
from moireid.fabrication.sight import front_mm

MOUNTS = (*KINDS, "none")
PRINTED_FILES = ("mount.step", "mount.stl", "mount.3mf")
ACRYLIC_FILES = ("acrylic.dxf", "acrylic.svg")
GLB_FILE = "stack.glb"


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
        printed = PRINTED_FILES if self.printed != "none" else ()
        cut = ACRYLIC_FILES if self.acrylic else ()
        return (*printed, *cut, *((GLB_FILE,) if printed or cut else ()))


def plan_parts(badge: Badge, mount: str, figures: MountFigures | None = None) -> Parts:
    """Plan the mounts that can be made; takes milliseconds and writes nothing.

    Parameters: mount: one of `MOUNTS`.
    Raises: FabricationError with what, got, allowed and the next step, where no mount can be made, or not the one that
        the figures ask for.
    """
    figures = figures or MountFigures()
    if mount not in MOUNTS:
        raise FabricationError(f"mount {mount!r} is not known; choose one of {', '.join(MOUNTS)}")
    if mount == "none":
        return Parts("none", None, figures)
    faults: dict[str, FabricationError] = {}
    stack: AcrylicPlan | None = None
    mount_plan: MountPlan | None = None
    try:
        mount_plan = plan_mount(badge, mount, figures.printed)
    except FabricationError as error:
        faults["printed"] = error
    try:
        stack = plan_acrylic(badge, figures.acrylic)
        draw(stack, figures.acrylic.kerf_mm)
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


def write_parts(
    badge: Badge, parts: Parts, folder: Path, say: Callable[[str], None]
) -> tuple[float | None, dict[str, float]]:
    """Write the files of a mount and read each back.

    Parameters: say: called with the name of the next file.
    Returns: mass of the printed mount in g, None without one; its other figures and the stack's, by name.
    Raises: FabricationError where a file fails its check; MissingExtraError without the CAD packages.
    """
    if not parts.files:
        return None, {}
    from moireid.fabrication.acrylic.stack import check_stack, write_glb

    # The drawing is made in milliseconds, the solids take seconds.
    if parts.acrylic:
        say("acrylic.dxf and acrylic.svg")
        _write_drawing(parts.acrylic, parts.figures.acrylic.kerf_mm, folder)
    report: MountReport | None = None
    if parts.printed != "none":
        say("mount.step, mount.stl and mount.3mf")
        report = write_mount(badge, folder, kind=parts.printed, process=parts.figures.printed, plan=parts.mount_plan)
    say(GLB_FILE)
    stack = check_stack(parts.acrylic) if parts.acrylic else []
    bodies = [(body.name, body.used) for body in report.bodies] if report else []
    process = parts.figures.printed
    held_mm = (process.card_mm, front_mm(badge, process.film_mm))
    write_glb(badge, stack, folder / GLB_FILE, mount=bodies, held_mm=held_mm)
    return report.mass_g if report else None, _figures_of(parts, report)


def _write_drawing(stack: AcrylicPlan, kerf_mm: float, folder: Path) -> None:
    from moireid.fabrication.acrylic.drawings import check_dxf, check_svg, write_dxf, write_svg

    drawing = draw(stack, kerf_mm)
    write_dxf(drawing, folder / "acrylic.dxf")
    check_dxf(folder / "acrylic.dxf", drawing, kerf_mm)
    write_svg(drawing, folder / "acrylic.svg")
    check_svg(folder / "acrylic.svg", drawing, kerf_mm)


def _figures_of(parts: Parts, report: MountReport | None) -> dict[str, float]:
    """The figures of what was made, by name."""
    figures: dict[str, float] = {}
    if report:
        figures |= report.figures
    if stack := parts.acrylic:
        figures |= {
            "acrylic_clearance_mm": stack.clearance_mm,
            "acrylic_twist_deg": stack.twist_deg,
            "acrylic_squeeze_mm": stack.squeeze_mm,
            "screw_mm": stack.screw_mm,
            "kerf_mm": parts.figures.acrylic.kerf_mm,
            **{f"{plate.name}_mm": plate.thickness_mm for plate in stack.plates},
        }
    return figures
