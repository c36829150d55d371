"""All files of one badge: planned before the work, made aside, and moved in place together."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from moireid.badge import Badge
from moireid.dots import on_dots
from moireid.fabrication.assembly import write_assembly_pdf
from moireid.fabrication.page import write_badge_pdf
from moireid.fabrication.preview import write_preview
from moireid.files import planned, write_text

MOUNTS = ("lanyard", "none")
_SHEETS = ("badge.pdf", "preview.png", "assembly.pdf")
_MOUNT = ("mount.step", "mount.stl")


@dataclass(frozen=True)
class Printed:
    """What was written: path by contract name, and the mount's mass (None without one)."""

    files: dict[str, Path]
    mount_mass_g: float | None


def print_badge(
    badge: Badge,
    folder: Path,
    *,
    mount: str = "lanyard",
    measured_scale: tuple[float, float] = (1.0, 1.0),
    overwrite: bool = False,
    before_moving: Callable[[], object] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Printed:
    """Write everything that a person needs for one badge into `folder`.

    Parameters: measured_scale: as `page.write_badge_pdf` has it; before_moving: called when all files are made and
        checked but none is in place, for what must happen together with them (issuing); if it raises, no file appears;
        progress: called with the name of the next file.
    Returns: Printed.
    Raises: SpecError where a file is in the way; FabricationError where one fails its check.
    """
    names = file_names(mount)
    planned([folder / name for name in names], overwrite=overwrite)
    say = progress or (lambda name: None)
    mass_g = None
    with tempfile.TemporaryDirectory(prefix=".moireid-", dir=folder) as aside_name:
        aside = Path(aside_name)
        say("badge.pdf")
        write_badge_pdf(badge, aside / "badge.pdf", measured_scale=measured_scale)
        say("preview.png")
        write_preview(badge, aside / "preview.png")
        say("assembly.pdf")
        write_assembly_pdf(badge, aside / "assembly.pdf", mount=mount)
        if mount != "none":
            say("mount.step and mount.stl")
            from moireid.fabrication.mount import write_mount

            mass_g = write_mount(badge, aside).mass_g
        write_text(aside / "badge.json", badge_file(badge))
        if before_moving:
            before_moving()
        # badge.json goes last: where it lies, the rest lies too.
        for name in names:
            (aside / name).replace(folder / name)
    return Printed({name: folder / name for name in names}, mass_g)


def badge_file(badge: Badge) -> str:
    """The text of badge.json: the badge, and what the printer's dots make of each of its cells.

    The second is no part of the Badge, which is the same on any printer; who reads the file may pass it over.
    """
    document = json.loads(badge.to_json())
    told = on_dots(badge)
    return json.dumps(document | ({"realised": told} if told else {}), indent=1, ensure_ascii=False) + "\n"


def file_names(mount: str) -> list[str]:
    """Names of the files that `print_badge` writes; badge.json is the last."""
    return [*_SHEETS, *(_MOUNT if mount != "none" else ()), "badge.json"]
