"""Pieces of lens sheet on whole sheets, cut from edge to edge and never turned.

The lenses of a piece must run as the badge has them, so no piece is turned by 90 degrees.  Shops and paper cutters cut
straight from one edge of what they hold to the other (guillotine cuts).  So a sheet is first cut into strips, and then
each strip into pieces of one size.

For pieces of one size this is the best that any cutting can do: without turning, a sheet of W x H holds
floor(W / w) * floor(H / h) rectangles of w x h and no more, and a grid has them all.  A library for packing would find
the same, so none is used.  Pieces of several sizes (two fields, or three) get strips of their own, the highest first
into the first sheet with room; that may take a sheet more than the best.

Convention: mm in the sheet's frame; x runs across the lenses and y along them; origin in the lower left corner.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from moireid.badge import Rect
from moireid.errors import FabricationError

#: Rounding of sizes in mm: a piece as wide as the room fits.
SLACK_MM = 1e-6
#: A sheet is no smaller than a badge's fringes and no larger than a press prints.
SHEET_RANGE_MM = (20.0, 3000.0)
MOST_TRIM_MM, MOST_CUT_MM = 50.0, 10.0
MOST_PIECES = 100_000
#: Which way the first cuts run: across the lenses, or along them.
First = Literal["across", "along"]


@dataclass(frozen=True)
class LensPiece:
    """One size of piece: its name, its sides across and along the lenses, mm, and how many are needed."""

    name: str
    across_mm: float
    along_mm: float
    count: int


@dataclass(frozen=True)
class StockSheet:
    """A sheet as it is bought: its sides across and along its lenses, mm.

    trim_mm: what is cut away at each edge, as edges of sheets are not straight; cut_mm: what a cut takes away: 0 for a
    knife or a paper cutter.
    """

    across_mm: float
    along_mm: float
    trim_mm: float = 3.0
    cut_mm: float = 0.0

    def __post_init__(self) -> None:
        """Raises: FabricationError for a sheet that no one sells, or cuts that no one makes."""
        low, high = SHEET_RANGE_MM
        if not all(low <= side <= high for side in (self.across_mm, self.along_mm)):
            raise FabricationError(
                f"a lens sheet of {self.across_mm:g} x {self.along_mm:g} mm is not sold; give sides of {low:g} to "
                f"{high:g} mm, first across the lenses and then along them, such as 210x297"
            )
        for value, most, what in ((self.trim_mm, MOST_TRIM_MM, "trim"), (self.cut_mm, MOST_CUT_MM, "cut width")):
            if not 0 <= value <= most:
                raise FabricationError(f"a {what} of {value:g} mm is not possible; give 0 to {most:g} mm")

    @property
    def turned(self) -> StockSheet:
        """The same sheet with its lenses along its other side."""
        return StockSheet(self.along_mm, self.across_mm, self.trim_mm, self.cut_mm)


@dataclass(frozen=True)
class Cut:
    """One straight cut, as its two ends; number: in which order; first: whether it crosses the whole sheet."""

    number: int
    line: Rect
    first: bool


@dataclass(frozen=True)
class CutSheet:
    """How one sheet is cut: its pieces by name and rectangle, its cuts in order, and how many sheets are cut so."""

    pieces: tuple[tuple[str, Rect], ...]
    cuts: tuple[Cut, ...]
    count: int


@dataclass(frozen=True)
class CuttingPlan:
    """All sheets of a badge's lens pieces; first: which way the first cuts run."""

    sheet: StockSheet
    wanted: tuple[LensPiece, ...]
    sheets: tuple[CutSheet, ...]
    first: First

    @property
    def sheet_count(self) -> int:
        """Number of sheets to buy."""
        return sum(one.count for one in self.sheets)

    @property
    def most_pieces(self) -> int:
        """Pieces of the fullest sheet."""
        return max(len(one.pieces) for one in self.sheets)

    @property
    def waste_share(self) -> float:
        """Share of the area of all sheets that is in no piece."""
        used = sum(piece.across_mm * piece.along_mm * piece.count for piece in self.wanted)
        return 1 - used / (self.sheet_count * self.sheet.across_mm * self.sheet.along_mm)


@dataclass(frozen=True)
class _Strip:
    """A strip of pieces of one size: their name, their sides along the strip and across it, and how many."""

    name: str
    side: float
    height: float
    count: int


def plan_cutting(pieces: Sequence[LensPiece], sheet: StockSheet) -> CuttingPlan:
    """Place all pieces on as few sheets as strips allow.

    Parameters
    ----------
    pieces : sequence of LensPiece
        Each size once.
    sheet : StockSheet
        What is bought.

    Returns
    -------
    CuttingPlan
        With strips across the lenses or along them, whichever takes fewer sheets; across where both take as many.

    Raises
    ------
    FabricationError
        Where a piece does not fit the sheet, or none is wanted.

    Notes
    -----
    Convention: no piece is turned.
    Source: module docstring; several sizes by first fit of decreasing heights.
    """
    wanted = tuple(piece for piece in pieces if piece.count > 0)
    if not wanted:
        raise FabricationError("no piece of lens sheet is needed; give at least one person")
    if (total := sum(piece.count for piece in wanted)) > MOST_PIECES:
        raise FabricationError(f"{total} pieces are too many for one plan; plan for at most {MOST_PIECES}")
    for piece in wanted:
        _check_fits(piece, sheet)
    plans = [_strips_plan(wanted, sheet, first) for first in ("across", "along")]
    return min(plans, key=lambda plan: plan.sheet_count)


def fitting_count(extent_mm: float, side_mm: float, sheet: StockSheet) -> int:
    """How many sides fit one after another into an extent of a sheet, trim and cuts taken off."""
    return int((extent_mm - 2 * sheet.trim_mm + sheet.cut_mm + SLACK_MM) // (side_mm + sheet.cut_mm))


def _check_fits(piece: LensPiece, sheet: StockSheet) -> None:
    if fitting_count(sheet.across_mm, piece.across_mm, sheet) and fitting_count(sheet.along_mm, piece.along_mm, sheet):
        return
    other = sheet.turned
    turned = fitting_count(other.across_mm, piece.across_mm, other) and fitting_count(
        other.along_mm, piece.along_mm, other
    )
    advice = (
        f"take sheets whose lenses run along the other side (--sheet-size {other.across_mm:g}x{other.along_mm:g})"
        if turned
        else "give a larger sheet (--sheet-size)"
    )
    raise FabricationError(
        f"the {piece.name} of {piece.across_mm:.1f} mm across the lenses and {piece.along_mm:.1f} mm along them does "
        f"not fit a sheet of {sheet.across_mm:g} x {sheet.along_mm:g} mm with {sheet.trim_mm:g} mm trimmed at each "
        f"edge; {advice}",
        across_mm=piece.across_mm,
        along_mm=piece.along_mm,
    )


def _strips_plan(wanted: tuple[LensPiece, ...], sheet: StockSheet, first: First) -> CuttingPlan:
    """Strips whose first cuts run that way, filled into sheets."""
    swap = first == "along"
    long, deep = (sheet.along_mm, sheet.across_mm) if swap else (sheet.across_mm, sheet.along_mm)
    strips: list[_Strip] = []
    for piece in wanted:
        side, height = (piece.along_mm, piece.across_mm) if swap else (piece.across_mm, piece.along_mm)
        most, left = fitting_count(long, side, sheet), piece.count
        while left > 0:
            strips.append(_Strip(piece.name, side, height, min(most, left)))
            left -= most
    strips.sort(key=lambda strip: -strip.height)
    room = deep - 2 * sheet.trim_mm + sheet.cut_mm + SLACK_MM
    filled: list[list[_Strip]] = []
    free: list[float] = []
    # Sheets that are full are not looked at again: an event has thousands of strips of one height.
    begin = 0
    for strip in strips:
        need = strip.height + sheet.cut_mm
        place = next((k for k in range(begin, len(filled)) if free[k] >= need), None)
        if place is None:
            filled.append([])
            free.append(room)
            place = len(filled) - 1
        filled[place].append(strip)
        free[place] -= need
        lowest = strips[-1].height + sheet.cut_mm
        while begin < len(filled) and free[begin] < lowest:
            begin += 1
    alike: dict[tuple[_Strip, ...], int] = {}
    for strips_here in filled:
        key = tuple(strips_here)
        alike[key] = alike.get(key, 0) + 1
    sheets = tuple(_cut_sheet(strips_here, sheet, swap, count) for strips_here, count in alike.items())
    return CuttingPlan(sheet, wanted, sheets, first)


def _cut_sheet(strips: tuple[_Strip, ...], sheet: StockSheet, swap: bool, count: int) -> CutSheet:
    """One sheet: the first cuts from edge to edge of the sheet, then those within each strip."""
    long, deep = (sheet.along_mm, sheet.across_mm) if swap else (sheet.across_mm, sheet.along_mm)
    half, pieces = sheet.cut_mm / 2, []
    firsts: list[Rect] = []
    seconds: list[Rect] = []
    y = sheet.trim_mm
    if y > 0:
        firsts.append((0.0, y - half, long, y - half))
    for strip in strips:
        # A strip is what lies between two cuts, or between a cut and the sheet's edge.
        low, high = max(y - half, 0.0), min(y + strip.height + half, deep)
        x = sheet.trim_mm
        if x > 0:
            seconds.append((x - half, low, x - half, high))
        for _ in range(strip.count):
            pieces.append((strip.name, (x, y, x + strip.side, y + strip.height)))
            x += strip.side
            if x + half < long - SLACK_MM:
                seconds.append((x + half, low, x + half, high))
            x += sheet.cut_mm
        y += strip.height
        if y + half < deep - SLACK_MM:
            firsts.append((0.0, y + half, long, y + half))
        y += sheet.cut_mm
    lines = [(line, True) for line in firsts] + [(line, False) for line in seconds]
    cuts = tuple(Cut(k, _swapped(line, swap), is_first) for k, (line, is_first) in enumerate(lines, start=1))
    return CutSheet(tuple((name, _swapped(rect, swap)) for name, rect in pieces), cuts, count)


def _swapped(rect: Rect, swap: bool) -> Rect:
    return (rect[1], rect[0], rect[3], rect[2]) if swap else rect


def with_spare(count: int, spare_share: float) -> int:
    """A number with the spare share on top, rounded up."""
    return count + math.ceil(count * spare_share - SLACK_MM)
