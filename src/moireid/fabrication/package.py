"""All files of one badge: planned first, made in a temporary folder, and moved in place together.

Of a mount the printed one and the acrylic stack are made, if they can be made; both are planned before anything.  If
only one of the two can be made, it is made, and the report says why the other is left out.  The wish is refused if
neither can be made, or if the user gave figures for the one that cannot.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.artwork.placing import Look
from moireid.badge import Badge
from moireid.dots import on_dots
from moireid.errors import FabricationError
from moireid.fabrication.assembly.assembly_words import Maker
from moireid.fabrication.assembly.guide import DrawnMounts, draw_mounts, write_assembly_pdf
from moireid.fabrication.page.dress import writer_of
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.fabrication.page.preview import write_preview, write_worn
from moireid.fabrication.process_figures import MountFigures
from moireid.files import AnyPath, as_path, move_together, planned, tidy_folders, write_text

if TYPE_CHECKING:
    from PIL import Image

    from moireid.fabrication.acrylic.plates import AcrylicPlan
    from moireid.fabrication.printed.mount import Body, MountPlan, MountReport
    from moireid.fabrication.solid_parts import SolidPart

#: Kinds of the printed mount, as `printed.mount.SLOTS`; or none.
MOUNTS = ("lanyard", "clip", "stand", "holder", "none")
PRINTED_FILES = ("mount.step", "mount.stl", "mount.3mf")
ACRYLIC_FILES = ("acrylic.dxf", "acrylic.svg", "acrylic.step")
GLB_FILE = "mount.glb"
#: What the file of that name was called in older versions.
OLDER_GLB_FILE = "stack.glb"


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
    from moireid.fabrication.acrylic.drawings import draw
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
    return MountSolids(bodies, placed, draw_mounts(placed))


def write_parts(
    badge: Badge,
    parts: Parts,
    folder: Path,
    say: Callable[[str], None],
    solids: MountSolids | None = None,
    picture: Image.Image | None = None,
) -> tuple[float | None, dict[str, float]]:
    """Write the files of a mount and read each back.

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
    (float or None, dict of str to float)
        Mass of the printed mount, g, None without one; its other figures and the stack's, units in their names.

    Raises
    ------
    FabricationError
        Where a file fails its check.
    MissingExtraError
        Without the CAD packages.
    """
    if not parts.files:
        return None, {}
    from moireid.fabrication.assembly_files import write_assembly_step, write_glb
    from moireid.fabrication.printed.mount import write_mount

    report: MountReport | None = None
    # The drawing is made in milliseconds, the solids take seconds.
    if parts.acrylic:
        say("acrylic.dxf and acrylic.svg")
        _write_drawing(parts.acrylic, parts.figures.acrylic.kerf_mm, folder)
    solids = solids or shape_parts(badge, parts)
    if parts.mount_plan:
        say("mount.stl and mount.3mf")
        figures, plan = parts.figures.printed, parts.mount_plan
        report = write_mount(badge, folder, kind=parts.printed, process=figures, plan=plan, bodies=solids.bodies)
    for shop, placed in solids.placed.items():
        name = {"printed": "mount.step", "acrylic": "acrylic.step"}[shop]
        say(name)
        write_assembly_step(f"{shop} mount", placed, folder / name)
    say(GLB_FILE)
    write_glb(badge, solids.placed, folder / GLB_FILE, picture)
    return report.mass_g if report else None, _figures_of(parts, report)


def _write_drawing(stack: AcrylicPlan, kerf_mm: float, folder: Path) -> None:
    from moireid.fabrication.acrylic.drawings import check_dxf, check_svg, draw, write_dxf, write_svg

    drawing = draw(stack, kerf_mm)
    write_dxf(drawing, folder / "acrylic.dxf")
    check_dxf(folder / "acrylic.dxf", drawing)
    write_svg(drawing, folder / "acrylic.svg")
    check_svg(folder / "acrylic.svg", drawing)


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
            "card_layers": float(stack.layers),
            **{f"{plate.name}_mm": plate.thickness_mm for plate in stack.plates},
        }
    return figures


#: The moving preview.
MOVING = "preview.webp"
_SHEETS = ("badge.pdf", "preview.png", MOVING, "assembly.pdf")
#: Files that a badge's folder has only with some mounts.
PART_FILES = (*PRINTED_FILES, *ACRYLIC_FILES, GLB_FILE, OLDER_GLB_FILE)


@dataclass(frozen=True)
class PrintResult:
    """What `print_badge` wrote.

    Attributes
    ----------
    files : dict of str to Path
        The files by name.
    mount_mass_g : float or None
        Mass of the printed mount, g; None without one.
    mount_figures : dict of str to float
        The mount's other figures; units are in their names.
    left_out : dict of str to str
        Why "printed" or "acrylic" was not made, though a mount was asked for.
    removed : tuple of Path
        Files of an older badge's mount that this badge does not have.
    """

    files: dict[str, Path]
    mount_mass_g: float | None
    mount_figures: dict[str, float] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    removed: tuple[Path, ...] = ()


def print_badge(
    badge: Badge,
    folder: AnyPath,
    *,
    mount: str = "lanyard",
    measured_scale: tuple[float, float] = (1.0, 1.0),
    figures: MountFigures | None = None,
    parts: Parts | None = None,
    look: Look | None = None,
    overwrite: bool = False,
    maker: Maker = "command",
    kept: Sequence[AnyPath] = (),
    before_moving: Callable[[], object] | None = None,
    progress: Callable[[str], None] | None = None,
) -> PrintResult:
    """Write everything that a person needs for one badge into a folder.

    Parameters
    ----------
    badge : Badge
        What is printed.
    folder : str or Path
        Made where it is absent.
    mount : str
        One of `MOUNTS`; "none" for paper and sheet alone.
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.
    figures : MountFigures, optional
        Of printer and laser; None for the defaults.
    parts : Parts, optional
        The mounts as they were planned already; `mount` and `figures` then count no more.
    look : Look, optional
        The badge's artwork; None for name, lines and id alone.
    overwrite : bool
        Replace older files, and remove those of a mount that this badge does not have.
    maker : str
        "command" or "studio": whose words the assembly sheet uses.
    kept : sequence of str or Path
        Input files, which are never replaced.
    before_moving : callable, optional
        Called when all files are made and checked but none is in place, for what must happen together with them
        (issuing); if it raises, no file appears.
    progress : callable, optional
        Called with the name of the next file.

    Returns
    -------
    PrintResult
        The files.

    Raises
    ------
    SpecError
        Where an output file exists or cannot be written.
    FabricationError
        Where a file fails its check, or no mount fits.
    MissingExtraError
        Where a mount is asked for and the CAD packages are not installed.

    Notes
    -----
    Convention: page mm, origin top left, x right, y down, become the files' own coordinates in each writer.
    """
    folder = as_path(folder)
    parts = parts or plan_parts(badge, mount, figures)
    names, say = file_names(parts), progress or (lambda name: None)
    stale = leftover_parts(folder, parts, "badge.json") if overwrite else ()
    # badge.json goes last, so that where it exists all other files exist too.
    with made_aside(folder, names, stale, overwrite=overwrite, kept=kept, before_moving=before_moving) as aside:
        solids = shape_parts(badge, parts)
        how: dict[str, Any] = {"measured_scale": measured_scale, "say": say, "maker": maker, "look": look}
        picture = write_sheets(badge, aside, parts, solids.drawn, **how)
        mass_g, mount_figures = write_parts(badge, parts, aside, say, solids, picture)
    return PrintResult({name: folder / name for name in names}, mass_g, mount_figures, parts.left_out, stale)


@contextmanager
def made_aside(
    folder: Path,
    names: Sequence[str],
    stale: Sequence[Path],
    *,
    overwrite: bool,
    kept: Sequence[AnyPath],
    before_moving: Callable[[], object] | None,
) -> Iterator[Path]:
    """A temporary folder, whose files are moved into a folder together when the `with` body has made them.

    Parameters
    ----------
    names : sequence of str
        The files below the folder, in the order in which they are moved.
    stale : sequence of Path
        Older files that are then removed.
    overwrite, kept, before_moving
        As for `print_badge`.

    Raises
    ------
    SpecError
        Where a file exists or cannot be written; what the body and `before_moving` raise leaves no file.
    """
    paths = [folder / name for name in names]
    with tidy_folders(list(dict.fromkeys([folder, *(path.parent for path in paths)]))):
        planned(paths, overwrite=overwrite, kept=kept)
        with tempfile.TemporaryDirectory(prefix=".moireid-", dir=folder) as aside:
            yield Path(aside)
            # Making takes seconds, in which another process may have written here.
            planned(paths, overwrite=overwrite, kept=kept)
            if before_moving:
                before_moving()
            move_together([(Path(aside) / name, folder / name) for name in names], stale)


def write_sheets(
    badge: Badge,
    folder: Path,
    parts: Parts,
    drawn: DrawnMounts,
    *,
    measured_scale: tuple[float, float],
    say: Callable[[str], None],
    maker: Maker,
    look: Look | None = None,
) -> Image.Image:
    """Write a badge's page, previews, assembly sheet and badge.json; drawn: as `shape_parts` gives it.

    Returns: the board as it was drawn.
    """
    say("badge.pdf")
    write_badge_pdf(badge, folder / "badge.pdf", measured_scale=measured_scale, write_words=writer_of(badge, look))
    say("preview.png")
    preview = write_preview(badge, folder / "preview.png", look)
    say(MOVING)
    write_worn(badge, folder / MOVING, look, preview)
    say("assembly.pdf")
    write_assembly_pdf(
        badge,
        folder / "assembly.pdf",
        mount=parts.printed,
        acrylic=parts.acrylic,
        figures=parts.figures,
        maker=maker,
        mount_plan=parts.mount_plan,
        drawn=drawn,
    )
    write_text(folder / "badge.json", badge_file(badge))
    return preview


def leftover_parts(folder: Path, parts: Parts, owner_file: str) -> tuple[Path, ...]:
    """Mount files in the folder that do not belong to these parts; none where the file `owner_file` does not exist.

    A mount.stl without a badge.json was not made by this program, and stays.
    """
    if not (folder / owner_file).is_file():
        return ()
    return tuple(folder / name for name in PART_FILES if name not in parts.files and (folder / name).is_file())


def badge_file(badge: Badge) -> str:
    """The text of badge.json: the badge, and each cell's figures after rounding to the printer's dots.

    A reader may skip the second part: it is not in the `Badge`, which is the same for any printer.
    """
    document = json.loads(badge.to_json())
    realised = on_dots(badge)
    return json.dumps(document | ({"realised": realised} if realised else {}), indent=1, ensure_ascii=False) + "\n"


def file_names(parts: Parts) -> list[str]:
    """Names of the files of a badge's folder; badge.json is the last."""
    return [*_SHEETS, *parts.files, "badge.json"]
