"""The badges of many people: sheets filled with as many boards as fit, and a folder for each person.

Boards of one event have one layout, so they lie on every sheet in the same places, a gutter apart that holds the crop
marks.  Everything is made aside first and moved in place together, so an event that fails leaves nothing.
"""

from __future__ import annotations

import csv
import io
import re
import tempfile
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from moireid.badge import Badge, Rect
from moireid.errors import FabricationError
from moireid.fabrication.artwork import CROP_GAP_MM
from moireid.fabrication.package import print_badge
from moireid.fabrication.page import DEFAULT_DPI, Sheet, draw_board, draw_mask, draw_scale_bars
from moireid.files import planned, whole_file, write_text
from moireid.profiles import PAPERS_MM, Printer

#: Between boards stand the crop marks of both, in line with each other, so they share the room.
MARK_MM = 3.0
GUTTER_MM = CROP_GAP_MM + MARK_MM + CROP_GAP_MM
#: Paper left around all boards, mm: for what is left of the crop marks beside the printer's rim, and at the left and
#: below for a scale bar too.
LEFT_MM, TOP_MM, RIGHT_MM, BOTTOM_MM = 12.0, 7.0, 7.0, 15.0
SUMMARY, SHEETS = "summary.csv", "badges.pdf"
_MOST_LETTERS = 40


@dataclass(frozen=True)
class Event:
    """What was written: the sheets, their number, boards to a sheet, the summary, and a folder a person."""

    sheets: Path
    sheet_count: int
    boards_to_a_sheet: int
    summary: Path
    folders: tuple[Path, ...]


def places_mm(badge: Badge) -> list[tuple[float, float]]:
    """Upper left corners of the boards that fit on the badge's paper, row by row, mm; in the middle if there is room.

    Source: as many columns and rows as leave a gutter between boards, and room for crop marks and both scale bars at
    the rim; one at least.
    """
    x0, y0, x1, y1 = badge.outline_mm
    size = (x1 - x0, y1 - y0)
    paper = PAPERS_MM[str((badge.print or {}).get("paper", "a4"))]
    before, after = (LEFT_MM, TOP_MM), (RIGHT_MM, BOTTOM_MM)
    starts, counts = [], []
    for k in (0, 1):
        # A billionth of a millimetre is what decimal fractions leave.
        room = paper[k] - before[k] - after[k] + 1e-9
        count = max(1, int((room + GUTTER_MM) / (size[k] + GUTTER_MM)))
        block = count * size[k] + (count - 1) * GUTTER_MM
        counts.append(count)
        starts.append(min(max((paper[k] - block) / 2, before[k]), paper[k] - after[k] - block))
    return [
        (starts[0] + column * (size[0] + GUTTER_MM), starts[1] + row * (size[1] + GUTTER_MM))
        for row in range(counts[1]) for column in range(counts[0])
    ]  # fmt: skip


def write_sheets_pdf(
    badges: Sequence[Badge], path: Path, *, measured_scale: tuple[float, float] = (1.0, 1.0)
) -> tuple[int, int]:
    """Write all boards on as few sheets as they need, whole or not at all.

    Parameters: badges: one or more, of one layout; measured_scale: as `page.write_badge_pdf`.
    Returns: number of sheets, and of boards to a sheet.  A mask's page follows the sheets, once for all.
    Raises: FabricationError where boards are of several sizes.
    """
    first = badges[0]
    if any(badge.outline_mm != first.outline_mm for badge in badges):
        raise FabricationError("boards of several sizes do not share sheets; print one size at a time")
    print_data = first.print or {}
    form, dot_mm = str(print_data.get("form", "dots")), Printer(int(print_data.get("dpi", DEFAULT_DPI))).dot_mm
    places = places_mm(first)
    scale = (1 / measured_scale[0], 1 / measured_scale[1])
    x0, y0, x1, y1 = first.outline_mm
    block: Rect = (*places[0], places[-1][0] + x1 - x0, places[-1][1] + y1 - y0)
    with whole_file(path) as temporary:
        sheet = Sheet(temporary, first.page_mm, "Moiré badges", scale, None if form == "vector" else dot_mm)
        for number, badge in enumerate(badges):
            place = places[number % len(places)]
            if number and number % len(places) == 0:
                sheet.canvas.showPage()
            sheet.origin_mm = (place[0] - badge.outline_mm[0], place[1] - badge.outline_mm[1])
            draw_board(sheet, badge, form, dot_mm, block, mark_mm=MARK_MM)
            if number % len(places) == 0:
                sheet.origin_mm = (0.0, 0.0)
                draw_scale_bars(sheet, block)
        sheet.origin_mm = (0.0, 0.0)
        if first.lens.kind == "mask":
            sheet.canvas.showPage()
            draw_mask(sheet, first, form, dot_mm)
        sheet.save()
    return -(-len(badges) // len(places)), len(places)


def print_event(
    badges: Sequence[Badge], folder: Path, *, measured_scale: tuple[float, float] = (1.0, 1.0),
    overwrite: bool = False, before_moving: Callable[[], object] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Event:  # fmt: skip
    """Write sheets, summary and a folder for each person into `folder`.

    Parameters: badges: in the order of the list; before_moving: as `package.print_badge`; progress: told (done, of).
    Returns: Event.
    Raises: SpecError where a file is in the way; FabricationError as `write_sheets_pdf`.
    """
    digits = max(3, len(str(len(badges))))
    names = [folder_name(number, badge, digits) for number, badge in enumerate(badges, start=1)]
    planned([folder / SHEETS, folder / SUMMARY, *(folder / name / "badge.json" for name in names)], overwrite=overwrite)
    with tempfile.TemporaryDirectory(prefix=".moireid-", dir=folder) as aside_name:
        aside = Path(aside_name)
        for done, (name, badge) in enumerate(zip(names, badges, strict=True), start=1):
            (aside / name).mkdir()
            print_badge(badge, aside / name, mount="none", measured_scale=measured_scale)
            if progress:
                progress(done, len(badges))
        sheet_count, to_a_sheet = write_sheets_pdf(badges, aside / SHEETS, measured_scale=measured_scale)
        write_text(aside / SUMMARY, _summary(names, badges))
        if before_moving:
            before_moving()
        for name in names:
            for file in sorted((aside / name).iterdir(), key=lambda one: one.name == "badge.json"):
                file.replace(folder / name / file.name)
        for name in (SHEETS, SUMMARY):
            (aside / name).replace(folder / name)
    folders = tuple(folder / name for name in names)
    return Event(folder / SHEETS, sheet_count, to_a_sheet, folder / SUMMARY, folders)


def folder_name(number: int, badge: Badge, digits: int = 3) -> str:
    """A folder's name that sorts as the list does and that every file system takes: 007-ada-lovelace."""
    plain = unicodedata.normalize("NFKD", badge.name).encode("ascii", "ignore").decode().lower()
    letters = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:_MOST_LETTERS].strip("-")
    return f"{number:0{digits}d}-{letters or badge.id}"


def _summary(names: list[str], badges: Sequence[Badge]) -> str:
    """The list of what was made, as CSV."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["number", "name", "id", "folder"])
    for number, (name, badge) in enumerate(zip(names, badges, strict=True), start=1):
        writer.writerow([number, badge.name, badge.id, name])
    return out.getvalue()
