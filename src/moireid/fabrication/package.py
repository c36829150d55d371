"""All files of one badge: planned before the work, made aside, and moved in place together."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from moireid.badge import Badge
from moireid.dots import on_dots
from moireid.errors import FabricationError
from moireid.fabrication.acrylic import AcrylicPlan, plan_acrylic
from moireid.fabrication.assembly import write_assembly_pdf
from moireid.fabrication.holders import plan_holder
from moireid.fabrication.page import write_badge_pdf
from moireid.fabrication.preview import write_preview
from moireid.fabrication.process import AcrylicProcess, MountProcess
from moireid.fabrication.tray import plan_tray
from moireid.files import planned, write_text

MOUNTS = ("lanyard", "clip", "stand", "none")
_SHEETS = ("badge.pdf", "preview.png", "assembly.pdf")
_PRINTED = ("mount.step", "mount.stl", "mount.3mf")
_ACRYLIC = ("acrylic.dxf", "acrylic.svg", "stack.glb")


@dataclass(frozen=True)
class Printed:
    """What was written: path by contract name, the mount's mass (None without one), and its other figures by name."""

    files: dict[str, Path]
    mount_mass_g: float | None
    mount_figures: dict[str, float] = field(default_factory=dict)


def print_badge(
    badge: Badge,
    folder: Path,
    *,
    mount: str = "lanyard",
    measured_scale: tuple[float, float] = (1.0, 1.0),
    acrylic: AcrylicProcess | None = None,
    overwrite: bool = False,
    before_moving: Callable[[], object] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Printed:
    """Write everything that a person needs for one badge into `folder`.

    Parameters: mount: one of `MOUNTS`; measured_scale: as `page.write_badge_pdf` has it; acrylic: the laser's figures;
        before_moving: called when all files are made and checked but none is in place, for what must happen together
        with them (issuing); if it raises, no file appears; progress: called with the name of the next file.
    Returns: Printed.
    Raises: SpecError where a file is in the way; FabricationError where one fails its check, or no mount fits.
    """
    acrylic = acrylic or AcrylicProcess()
    stack = check_mount(badge, mount, acrylic)
    names = file_names(mount)
    planned([folder / name for name in names], overwrite=overwrite)
    say = progress or (lambda name: None)
    mass_g: float | None = None
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory(prefix=".moireid-", dir=folder) as aside_name:
        aside = Path(aside_name)
        say("badge.pdf")
        write_badge_pdf(badge, aside / "badge.pdf", measured_scale=measured_scale)
        say("preview.png")
        write_preview(badge, aside / "preview.png")
        say("assembly.pdf")
        write_assembly_pdf(badge, aside / "assembly.pdf", mount=mount, acrylic=stack)
        if stack:
            mass_g, figures = _write_mount(badge, aside, mount, stack, acrylic.kerf_mm, say)
        write_text(aside / "badge.json", badge_file(badge))
        if before_moving:
            before_moving()
        # badge.json goes last: where it lies, the rest lies too.
        for name in names:
            (aside / name).replace(folder / name)
    return Printed({name: folder / name for name in names}, mass_g, figures)


def check_mount(badge: Badge, mount: str, acrylic: AcrylicProcess) -> AcrylicPlan | None:
    """Refuse a mount that cannot be built, in milliseconds and before anything is made.

    Returns: the acrylic stack's plan, None for no mount.
    Raises: FabricationError with what, got, allowed and the next step.
    """
    if mount not in MOUNTS:
        raise FabricationError(f"mount {mount!r} is not known; choose one of {', '.join(MOUNTS)}")
    if mount == "none":
        return None
    process = MountProcess()
    plan_holder(badge, plan_tray(badge, process, tab=mount != "stand"), process, mount)
    return plan_acrylic(badge, acrylic)


def badge_file(badge: Badge) -> str:
    """The text of badge.json: the badge, and what the printer's dots make of each of its cells.

    The second is no part of the Badge, which is the same on any printer; who reads the file may pass it over.
    """
    document = json.loads(badge.to_json())
    told = on_dots(badge)
    return json.dumps(document | ({"realised": told} if told else {}), indent=1, ensure_ascii=False) + "\n"


def file_names(mount: str) -> list[str]:
    """Names of the files that `print_badge` writes; badge.json is the last."""
    return [*_SHEETS, *((*_PRINTED, *_ACRYLIC) if mount != "none" else ()), "badge.json"]


def _write_mount(
    badge: Badge, aside: Path, mount: str, stack: AcrylicPlan, kerf_mm: float, say: Callable[[str], None]
) -> tuple[float, dict[str, float]]:
    """The printed mount and the acrylic stack; the mass of the first, and figures of both."""
    from moireid.fabrication.cutting import draw
    from moireid.fabrication.dxf import check_dxf, write_dxf
    from moireid.fabrication.mount import write_mount
    from moireid.fabrication.stack import check_stack, write_glb
    from moireid.fabrication.svg import check_svg, write_svg

    # The drawing is refused in milliseconds where kerf or rim are wrong, the solids take seconds.
    say("acrylic.dxf and acrylic.svg")
    drawing = draw(stack, kerf_mm)
    write_dxf(drawing, aside / "acrylic.dxf")
    check_dxf(aside / "acrylic.dxf", drawing, kerf_mm)
    write_svg(drawing, aside / "acrylic.svg")
    check_svg(aside / "acrylic.svg", drawing, kerf_mm)
    say("mount.step, mount.stl and mount.3mf")
    report = write_mount(badge, aside, kind=mount)
    say("stack.glb")
    check_stack(stack)
    write_glb(badge, stack, aside / "stack.glb", mount=[(body.name, body.used) for body in report.bodies])
    figures = {
        "twist_deg": report.twist_deg, "press_mm": report.press_mm,
        "acrylic_clearance_mm": stack.clearance_mm, "acrylic_twist_deg": stack.twist_deg,
        "acrylic_squeeze_mm": stack.squeeze_mm, "screw_mm": stack.screw_mm, "kerf_mm": kerf_mm,
        **{f"{plate.name}_mm": plate.thickness_mm for plate in stack.plates},
    }  # fmt: skip
    return report.mass_g, figures
