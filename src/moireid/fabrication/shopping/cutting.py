"""Pieces of lens sheet on whole sheets, cut from edge to edge and never turned.

The lenses of a piece must run as the badge has them, so no piece is turned by 90 degrees.  Shops and paper cutters cut
straight from one edge of what they hold to the other (guillotine cuts).  So a sheet is first cut into strips, and then
each strip into pieces of one size.

For pieces of one size this is the best that any cutting can do: without turning, a sheet of W x H holds
floor(W / w) * floor(H / h) rectangles of w x h and no more, and a grid has them all.  Pieces of several sizes (two
fields, or three) get strips of their own, the highest first into the first sheet with room; that may take a sheet more
than the best.

Convention: mm in the sheet's frame; x runs across the lenses and y along them; origin in the lower left corner.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from moireid.errors import FabricationError

#: Cut off at each edge of a sheet, as edges are not straight; a side of which so little is missing fits, mm.
TRIM_MM, SLACK_MM = 3.0, 1e-6


@dataclass(frozen=True)
class Pieces:
    """Pieces of one size, also those of a strip: their sides across and along the lenses, mm, and how many."""

    across_mm: float
    along_mm: float
    count: int


@dataclass(frozen=True)
class CuttingPlan:
    """How all pieces are cut.

    sheet_mm: sides of a sheet across and along its lenses; pieces: each size once; sheets: the strips of a sheet from
    its lower edge up, and how many sheets are cut so.
    """

    sheet_mm: tuple[float, float]
    pieces: tuple[Pieces, ...]
    sheets: tuple[tuple[tuple[Pieces, ...], int], ...]

    @property
    def sheet_count(self) -> int:
        """Number of sheets to buy."""
        return sum(count for _, count in self.sheets)


def plan_cutting(pieces: Sequence[Pieces], sheet_mm: tuple[float, float]) -> CuttingPlan:
    """Place all pieces on as few sheets as strips allow.

    Parameters
    ----------
    pieces : sequence of Pieces
        Each size once.
    sheet_mm : (float, float)
        Sides of a sheet across and along its lenses, mm.

    Raises
    ------
    FabricationError
        Where a piece does not fit the sheet.

    Notes
    -----
    Convention: no piece is turned.
    Source: module docstring; several sizes by first fit of decreasing heights.
    """
    wide, high = (side - 2 * TRIM_MM + SLACK_MM for side in sheet_mm)
    sheets: list[list[Pieces]] = []
    free_mm: list[float] = []
    for piece in sorted(pieces, key=lambda one: -one.along_mm):
        most = int(wide // piece.across_mm)
        if most < 1 or piece.along_mm > high:
            raise FabricationError(
                f"a piece of {piece.across_mm:.1f} mm across the lenses and {piece.along_mm:.1f} mm along them does "
                f"not fit a sheet of {sheet_mm[0]:g} x {sheet_mm[1]:g} mm with {TRIM_MM:g} mm cut off at each edge; "
                "give a larger sheet, or one whose lenses run along its other side"
            )
        full, rest = divmod(piece.count, most)
        for count in [most] * full + [rest] * (rest > 0):
            place = next((k for k, room in enumerate(free_mm) if room >= piece.along_mm), len(sheets))
            if place == len(sheets):
                sheets.append([])
                free_mm.append(high)
            sheets[place].append(replace(piece, count=count))
            free_mm[place] -= piece.along_mm
    return CuttingPlan(sheet_mm, tuple(pieces), tuple(Counter(map(tuple, sheets)).items()))
