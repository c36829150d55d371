"""All files of one badge: planned first, made in a temporary folder, and moved in place together."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.badge import Badge, load_badge
from moireid.dots import on_dots
from moireid.errors import SpecError
from moireid.fabrication.assembly.assembly_words import BuildPlan, Maker
from moireid.fabrication.assembly.guide import write_assembly_pdf
from moireid.fabrication.assembly.moving_looks import write_looks
from moireid.fabrication.mount_parts import PART_FILES, MountSolids, Parts, shape_parts, write_parts
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.fabrication.page.preview import write_preview
from moireid.files import AnyPath, as_path, move_together, planned, tidy_folders, write_text

if TYPE_CHECKING:
    from PIL import Image


#: How fringes look and run, right and wrong.
LOOKS = "fringes.webp"
BADGE_JSON = "badge.json"
_SHEETS, ASSEMBLY = ("badge.pdf", "preview.png"), "assembly.pdf"


@dataclass(frozen=True)
class PrintResult:
    """What `print_badge` or `print_event` wrote.

    Attributes
    ----------
    files : dict of str to Path
        The files by name; of an event those for all people.
    mount_mass_g : float or None
        Mass of the printed mount, g; None without one.
    left_out : dict of str to str
        Why "printed" or "acrylic" was not made, though a mount was asked for.
    removed : tuple of Path
        Files of an older badge's mount that this badge does not have.
    moved_aside : dict of Path to Path
        Where a badge.json of another identity was, and where it is now.
    folders : tuple of Path
        Of an event: one for each person, in the order of the badges.
    sheets, boards_to_a_sheet : int
        Of an event: number of sheets, and of boards on a full one.
    """

    files: dict[str, Path]
    mount_mass_g: float | None
    left_out: dict[str, str]
    removed: tuple[Path, ...]
    moved_aside: dict[Path, Path]
    folders: tuple[Path, ...] = ()
    sheets: int = 0
    boards_to_a_sheet: int = 0

    def to_json(self) -> dict[str, Any]:
        """What commands say of it as JSON: files, and what became of the mount."""
        return {
            "files": {name: str(path) for name, path in self.files.items()},
            "mount_mass_g": self.mount_mass_g,
            "left_out": self.left_out,
            "removed": [str(path) for path in self.removed],
            "moved_aside": {str(old): str(new) for old, new in self.moved_aside.items()},
        }


def print_badge(
    badge: Badge,
    folder: AnyPath,
    *,
    parts: Parts,
    measured_scale: tuple[float, float] = (1.0, 1.0),
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
    parts : Parts
        The mounts, as `plan_parts` gives them.
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.
    overwrite : bool
        Replace older files, and remove those of a mount that this badge does not have; a badge.json of another
        identity becomes badge-<its id>.json.
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
    names, say = file_names(parts), progress or (lambda name: None)
    stale = leftover_parts(folder, parts, BADGE_JSON) if overwrite else ()
    spared = other_badges({folder / BADGE_JSON: badge})
    # badge.json goes last, so that where it exists all other files exist too.
    with made_aside(folder, names, stale, spared, overwrite=overwrite, kept=kept, before_moving=before_moving) as aside:
        solids = shape_parts(badge, parts)
        picture = write_sheets(badge, aside, measured_scale=measured_scale, say=say)
        write_guides(BuildPlan(badge, parts, maker), aside, solids, say)
        mass_g = write_parts(badge, parts, aside, say, solids, picture)
    return PrintResult({name: folder / name for name in names}, mass_g, parts.left_out, stale, spared)


@contextmanager
def made_aside(
    folder: Path,
    names: Sequence[str],
    stale: Sequence[Path],
    spared: Mapping[Path, Path],
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
    spared : mapping of Path to Path
        Older files whose content is kept under another name.
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
            copies = [(Path(aside) / f"spared-{number}", new) for number, new in enumerate(spared.values())]
            for old, (copy, _) in zip(spared, copies, strict=True):
                shutil.copy2(old, copy)
            move_together([*copies, *((Path(aside) / name, folder / name) for name in names)], stale)


def write_sheets(
    badge: Badge, folder: Path, *, measured_scale: tuple[float, float], say: Callable[[str], None]
) -> Image.Image:
    """Write a badge's page, previews and badge.json.  Returns: the board as it was drawn."""
    say("badge.pdf")
    write_badge_pdf(badge, folder / "badge.pdf", measured_scale=measured_scale)
    say("preview.png")
    preview = write_preview(badge, folder / "preview.png")
    write_text(folder / BADGE_JSON, badge_file(badge))
    return preview


def write_guides(build: BuildPlan, folder: Path, solids: MountSolids, say: Callable[[str], None]) -> None:
    """Write how a badge is built, and how its fringes look."""
    say(ASSEMBLY)
    write_assembly_pdf(build, folder / ASSEMBLY, solids.drawn)
    say(LOOKS)
    write_looks(build.badge, folder / LOOKS)


def leftover_parts(folder: Path, parts: Parts, owner_file: str) -> tuple[Path, ...]:
    """Mount files in the folder that do not belong to these parts; none where the file `owner_file` does not exist.

    A mount.stl without a badge.json was not made by this program, and stays.
    """
    if not (folder / owner_file).is_file():
        return ()
    found = sorted(path for pattern in PART_FILES for path in folder.glob(pattern) if path.is_file())
    return tuple(path for path in found if path.name not in parts.files)


def other_badges(badges: Mapping[Path, Badge]) -> dict[Path, Path]:
    """The badge.json of other identities at the paths of new ones, each with the name that keeps it.

    It is the only copy of a badge that may have been built, so `overwrite` does not destroy it.
    """
    found = {}
    for path, badge in badges.items():
        with suppress(SpecError):
            older = load_badge(path).id
            if older is not None and older != badge.id:
                found[path] = path.with_name(f"badge-{older}.json")
    return found


def badge_file(badge: Badge) -> str:
    """The text of badge.json: the badge, and each cell's figures after rounding to the printer's dots.

    A reader may skip the second part: it is not in the `Badge`, which is the same for any printer.
    """
    document = json.loads(badge.to_json())
    realised = on_dots(badge)
    return json.dumps(document | ({"realised": realised} if realised else {}), indent=1, ensure_ascii=False) + "\n"


def file_names(parts: Parts) -> list[str]:
    """Names of the files of a badge's folder; badge.json is the last."""
    return [*_SHEETS, ASSEMBLY, LOOKS, *parts.files, BADGE_JSON]


#: Files of each person's folder in an event.
PERSON_FILES = (*_SHEETS, BADGE_JSON)
