"""shopping-list.csv for a spreadsheet, cutting-plan.pdf for the person at the cutter.

A page of the plan shows sheets that are cut alike: the lenses' direction, the pieces, and each cut's distance from the
lower or left edge.  A sheet that does not fit the paper at true size is drawn smaller.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import astuple
from itertools import accumulate
from pathlib import Path

from moireid.fabrication.package import made_aside
from moireid.fabrication.page.canvas import BOLD, PdfPage
from moireid.fabrication.shopping.cutting import TRIM_MM, CuttingPlan, Pieces
from moireid.fabrication.shopping.shopping_list import ShoppingList
from moireid.files import AnyPath
from moireid.profiles import PAPERS_MM

LIST_CSV, PLAN_PDF = "shopping-list.csv", "cutting-plan.pdf"
PAPER_MM = PAPERS_MM["a4"]
TITLE_POINTS, TEXT_POINTS, SMALL_POINTS = 13.0, 8.5, 7.0
PIECE_GREY, LENS_GREY = 0.93, 0.82
#: Around a sheet on the page, and on the page between the strokes that show the lenses, mm.
LEFT_MM, TOP_MM, RIGHT_MM, BOTTOM_MM, LENSES_MM = 22.0, 44.0, 12.0, 14.0, 6.0
#: Widths of the first cuts' lines and of the second ones', mm.
FIRST_MM, SECOND_MM = 0.8, 0.2


def write_shopping(
    found: ShoppingList, folder: Path, *, overwrite: bool = False, kept: Sequence[AnyPath] = ()
) -> dict[str, Path]:
    """Write the list, and the cutting plan where lens sheets are cut: all files, or none.

    Parameters
    ----------
    folder : Path
        Made where it is absent.
    overwrite : bool
        Replace older files.
    kept : sequence of str or Path
        Input files, which are never replaced.

    Returns
    -------
    dict of str to Path
        Path by name.

    Raises
    ------
    SpecError
        Where a file exists or cannot be written.
    """
    # A mask has no cutting plan.
    names = [LIST_CSV] + [PLAN_PDF] * (found.cutting is not None)
    with made_aside(folder, names, (), {}, overwrite=overwrite, kept=kept, before_moving=None) as aside:
        # A byte order mark, by which spreadsheets know UTF-8.
        with (aside / LIST_CSV).open("w", encoding="utf-8-sig", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(("key", "what", "quantity", "unit", "note", "source", "not_stated"))
            writer.writerows(astuple(line) for line in found.lines)
        if found.cutting is not None:
            _write_plan(found.cutting, aside / PLAN_PDF)
    return {name: folder / name for name in names}


def _write_plan(plan: CuttingPlan, path: Path) -> None:
    page, first = PdfPage(path, PAPER_MM, "Cutting plan"), 1
    for strips, count in plan.sheets:
        if first > 1:
            page.turn_page(PAPER_MM)
        last = first + count - 1
        title = f"Sheet {last}" if count == 1 else f"Sheets {first:,} to {last:,}, all cut alike"
        _draw_sheet(page, plan.sheet_mm, strips, title)
        first = last + 1
    page.save()


def _draw_sheet(page: PdfPage, sheet_mm: tuple[float, float], strips: tuple[Pieces, ...], title: str) -> None:
    """One sheet, its lower edge below as in the plan."""
    wide, high = sheet_mm
    scale = max(1.0, wide / (PAPER_MM[0] - LEFT_MM - RIGHT_MM), high / (PAPER_MM[1] - TOP_MM - BOTTOM_MM))
    words = (
        f"A sheet of {wide:g} x {high:g} mm, drawn at 1 : {scale:.3g}; {TRIM_MM:g} mm at left and below are waste.",
        "In mm: at each cut, its distance from the left or lower edge; in each piece, size across x along the lenses.",
        "Cut from edge to edge: first the bold cuts, then each strip.",
        "Grey lines show the lenses. Never turn a piece: they must run on the badge as they run here.",
    )
    page.text(LEFT_MM, 14.0, title, points=TITLE_POINTS, font=BOLD, align="left")
    for k, line in enumerate(words):
        page.text(LEFT_MM, 20.5 + 4.4 * k, line, points=TEXT_POINTS, align="left")

    def at(x: float, y: float) -> tuple[float, float]:
        return LEFT_MM + x / scale, TOP_MM + (high - y) / scale

    levels = list(accumulate((strip.along_mm for strip in strips), initial=TRIM_MM))
    for strip, y in zip(strips, levels, strict=False):
        page.fill([(*at(TRIM_MM, y + strip.along_mm), *at(TRIM_MM + strip.count * strip.across_mm, y))], PIECE_GREY)
    for k in range(1, int(wide / scale / LENSES_MM)):
        x = LEFT_MM + k * LENSES_MM
        page.path([(x, TOP_MM), (x, at(0, 0)[1])], None, LENS_GREY, closed=False)
    page.path([at(0, 0), at(wide, 0), at(wide, high), at(0, high)], None, 0.0)
    for strip, y in zip(strips, levels, strict=False):
        for x in (TRIM_MM + k * strip.across_mm for k in range(strip.count + 1)):
            page.stroke(*at(x, y), *at(x, y + strip.along_mm), SECOND_MM)
            page.text(at(x, y)[0] + 0.6, at(x, y)[1] - 0.8, _mm(x), points=SMALL_POINTS, align="left")
        for k in range(strip.count):
            middle = at(TRIM_MM + (k + 0.5) * strip.across_mm, y + strip.along_mm / 2)
            size, points = f"{_mm(strip.across_mm)} x {_mm(strip.along_mm)}", strip.across_mm / scale / 6
            page.text(*middle, size, points=min(TEXT_POINTS, points))
    for level in levels:
        page.stroke(*at(0, level), *at(wide, level), FIRST_MM)
        page.text(LEFT_MM - 1.6, at(0, level)[1] + 0.8, _mm(level), points=SMALL_POINTS, align="right")


def _mm(length: float) -> str:
    """A length to a hundredth, without zeros at its end."""
    return f"{length:.2f}".rstrip("0").rstrip(".")
