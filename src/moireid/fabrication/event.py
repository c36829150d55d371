"""The badges of many people: sheets filled with as many boards as fit, and a folder for each person.

All boards of an event have the same layout, so every sheet has them at the same places.  All files are made in a
temporary folder and moved into place together, so an event that fails leaves nothing.
"""

from __future__ import annotations

import csv
import io
import re
import signal
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication.assembly.assembly_words import BuildPlan, Maker
from moireid.fabrication.mount_parts import Parts, shape_parts, write_parts
from moireid.fabrication.package import (
    ASSEMBLY,
    BADGE_JSON,
    LOOKS,
    PERSON_FILES,
    PrintResult,
    leftover_parts,
    made_aside,
    other_badges,
    write_guides,
    write_sheets,
)
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.page.marks import marks
from moireid.fabrication.page.pdf import draw_bands, draw_bands_alone, draw_board, draw_mask, draw_scale_bars
from moireid.fabrication.page.sheet_layout import MARK_MM, lay_out_sheets
from moireid.files import AnyPath, as_path, whole_file
from moireid.names import line_of
from moireid.profiles import drawn_dot_mm

SUMMARY, SHEETS = "summary.csv", "badges.pdf"
#: Of all people, without the mount's.
OWN_FILES = (SHEETS, ASSEMBLY, SUMMARY, LOOKS)
_MOST_LETTERS = 40
#: Latin letters that Unicode does not take apart into one of a to z and a mark.
_LATIN = str.maketrans({"þ": "th", "ð": "d", "đ": "d", "ł": "l", "ø": "o", "æ": "ae", "œ": "oe", "ß": "ss", "ħ": "h"})
#: Starting another process takes as long as some badges.
LEAST_SHARED = 12


def write_sheets_pdf(
    badges: Sequence[Badge],
    path: Path,
    *,
    measured_scale: tuple[float, float] = (1.0, 1.0),
) -> tuple[int, int]:
    """Write all boards on as few sheets as they need, whole or not at all.

    Parameters
    ----------
    badges : sequence of Badge
        One or more, of one layout.
    measured_scale : (float, float)
        As for `pdf.write_badge_pdf`.

    Returns
    -------
    (int, int)
        Number of sheets, and of boards to a sheet.  A mask's page follows the sheets, once for all.

    Raises
    ------
    FabricationError
        Where boards are of several sizes.
    """
    first = badges[0]
    if any(badge.outline_mm != first.outline_mm for badge in badges):
        raise FabricationError("boards of several sizes do not share sheets; print one size at a time")
    layout = lay_out_sheets(first)
    scale, count = (1 / measured_scale[0], 1 / measured_scale[1]), len(layout.places_mm)
    with whole_file(path) as temporary:
        sheet = PdfPage(temporary, layout.page_mm, "Moiré badges", scale, drawn_dot_mm(first))
        for number, badge in enumerate(badges):
            place = layout.places_mm[number % count]
            if number and number % count == 0:
                sheet.canvas.showPage()
            sheet.origin_mm = (place[0] - badge.outline_mm[0], place[1] - badge.outline_mm[1])
            draw_board(sheet, badge, layout.block_mm, marks(badge), MARK_MM)
            sheet.origin_mm = (0.0, 0.0)
            if number % count == 0:
                draw_scale_bars(sheet, layout.block_mm, first.range_m)
                draw_bands(sheet, first, layout.first_mm)
        if first.lens.kind == "mask":
            draw_mask(sheet, first, len(badges))
        if layout.bands_apart:
            draw_bands_alone(sheet, first)
        sheet.save()
    return -(-len(badges) // count), count


def print_event(
    badges: Sequence[Badge],
    folder: AnyPath,
    *,
    parts: Parts,
    measured_scale: tuple[float, float] = (1.0, 1.0),
    overwrite: bool = False,
    maker: Maker = "command",
    kept: Sequence[AnyPath] = (),
    before_moving: Callable[[], object] | None = None,
    progress: Callable[[int, int], None] | None = None,
    processes: int = 1,
) -> PrintResult:
    """Write sheets, summary, a folder for each person, and one set of a mount's files for all into a folder.

    Parameters
    ----------
    badges : sequence of Badge
        One or more, in the order of the list, all of one layout.
    folder : str or Path
        Made where it is absent.
    parts : Parts
        The mounts, as `plan_parts` gives them; the same for all, as boards of one event have one layout.
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.
    overwrite : bool
        Replace older files, and remove those of a mount that this event does not have; a badge.json of another
        identity becomes badge-<its id>.json.
    maker : str
        "command" or "studio": whose words the assembly sheets use.
    kept : sequence of str or Path
        Input files, which are never replaced.
    before_moving : callable, optional
        Called when all files are made and checked but none is in place; if it raises, no file appears.
    progress : callable, optional
        Called with the number of finished badges and the number of all badges.
    processes : int
        Number of processes that share the work, if there are `LEAST_SHARED` badges or more.  The files are the same.

    Returns
    -------
    PrintResult
        The files.

    Raises
    ------
    SpecError
        Where an output file exists or cannot be written.
    FabricationError
        Where boards are of several sizes, a file fails its check, or no mount fits.
    MissingExtraError
        Where a mount is asked for and the CAD packages are not installed.
    """
    folder = as_path(folder)
    names = _folders(badges)
    files = event_files(badges, parts)
    stale = leftover_parts(folder, parts, SUMMARY) if overwrite else ()
    spared = other_badges({folder / name / BADGE_JSON: badge for name, badge in zip(names, badges, strict=True)})
    with made_aside(folder, files, stale, spared, overwrite=overwrite, kept=kept, before_moving=before_moving) as aside:
        # The mount is the same for all, and so is how it is built.
        solids = shape_parts(badges[0], parts)
        work = partial(_write_person, measured_scale=measured_scale)
        with _shared(work, badges, [aside / name for name in names], processes) as people_made:
            mass_g = write_parts(badges[0], parts, aside, lambda file: None, solids)
            write_guides(BuildPlan(badges[0], parts, maker, for_all=True), aside, solids, lambda file: None)
            sheet_count, to_a_sheet = write_sheets_pdf(badges, aside / SHEETS, measured_scale=measured_scale)
            for done, _ in enumerate(people_made, start=1):
                if progress:
                    progress(done, len(badges))
        # A byte order mark, by which spreadsheets know UTF-8.
        (aside / SUMMARY).write_text(_summary(names, badges, parts), encoding="utf-8-sig", newline="")
    files_made = {name: folder / name for name in (*OWN_FILES, *parts.files)}
    folders = tuple(folder / name for name in names)
    return PrintResult(files_made, mass_g, parts.left_out, stale, spared, folders, sheet_count, to_a_sheet)


def event_files(badges: Sequence[Badge], parts: Parts) -> list[str]:
    """The files that an event of these badges and parts of a mount has, below its folder."""
    own = [f"{name}/{file}" for name in _folders(badges) for file in PERSON_FILES]
    return [*own, *parts.files, *OWN_FILES]


def _folders(badges: Sequence[Badge]) -> list[str]:
    digits = max(3, len(str(len(badges))))
    return [folder_name(number, badge, digits) for number, badge in enumerate(badges, start=1)]


def _write_person(badge: Badge, folder: Path, measured_scale: tuple[float, float]) -> None:
    folder.mkdir()
    write_sheets(badge, folder, measured_scale=measured_scale, say=lambda file: None)


@contextmanager
def _shared(
    work: Callable[[Badge, Path], None],
    badges: Sequence[Badge],
    folders: Sequence[Path],
    processes: int,
) -> Iterator[Iterator[None]]:
    """Run the work for each badge in several processes while the `with` body runs; they end with the body.

    Raises: FabricationError where a process was killed.
    """
    if processes < 2 or len(badges) < LEAST_SHARED:
        yield map(work, badges, folders)
        return
    from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
    from multiprocessing import get_context

    # Spawned, because a fork would copy the locks of other threads.  Only the parent handles an interrupt.
    begin: dict[str, Any] = {"initializer": signal.signal, "initargs": (signal.SIGINT, signal.SIG_IGN)}
    pool = ProcessPoolExecutor(processes, mp_context=get_context("spawn"), **begin)
    try:
        yield pool.map(work, badges, folders, chunksize=4)
    except BrokenProcessPool as error:
        raise FabricationError(
            "a process that made badges was ended from outside; nothing was kept: run the command again, with more "
            "memory free"
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


def folder_name(number: int, badge: Badge, digits: int = 3) -> str:
    """A folder's name that sorts as the list does and that every file system takes: 007-ada-lovelace."""
    plain = unicodedata.normalize("NFKD", badge.name.lower().translate(_LATIN)).encode("ascii", "ignore").decode()
    letters = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:_MOST_LETTERS].strip("-")
    return f"{number:0{digits}d}-{letters or badge.id}"


def _plain(name: str) -> str:
    """A name for a spreadsheet: quoted where it begins like a formula, which the spreadsheet would compute."""
    return f"'{name}" if name.startswith(("=", "+", "-", "@", "\t", "\r")) else name


def _summary(names: list[str], badges: Sequence[Badge], parts: Parts) -> str:
    """The list of what was made, as CSV."""
    made = [parts.printed if parts.printed != "none" else "", "acrylic" if parts.acrylic else ""]
    mount = " or ".join(filter(None, made)) or "none"
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["number", "name", "id", "folder", "mount", "line"])
    for number, (name, badge) in enumerate(zip(names, badges, strict=True), start=1):
        writer.writerow([number, _plain(badge.name), badge.id, name, mount, _plain(line_of(badge.print) or "")])
    return out.getvalue()
