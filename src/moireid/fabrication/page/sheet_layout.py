"""Where the boards of many badges of one size lie on sheets, and how many pages these are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from moireid.badge import Badge, Point, Rect
from moireid.fabrication.page.canvas import RIM_MM
from moireid.fabrication.page.pdf import BAR_GAP_MM, BAR_HIGH_MM, CROP_GAP_MM, TICK_MM
from moireid.fabrication.page.pitch_bands import pitch_bands

#: The crop marks of two neighbouring boards are in line with each other, so they share the gutter.
MARK_MM = 2.0
GUTTER_MM = CROP_GAP_MM + MARK_MM + CROP_GAP_MM
#: Paper left around all boards, mm: for the crop marks inside the printer's rim, and at the left and below also for a
#: scale bar.
RIGHT_MM = TOP_MM = RIM_MM + MARK_MM + CROP_GAP_MM
LEFT_MM, BOTTOM_MM = RIGHT_MM + BAR_GAP_MM + TICK_MM, TOP_MM + BAR_GAP_MM + BAR_HIGH_MM


@dataclass(frozen=True)
class SheetLayout:
    """Boards on a sheet of paper: its size, upper left corners of the boards row by row, width and height of a board.

    bands_apart: whether the pitch bands take a page of their own.
    """

    page_mm: Point
    places_mm: tuple[Point, ...]
    board_mm: Point
    bands_apart: bool = False

    @property
    def first_mm(self) -> Rect:
        """The rectangle of the first board, mm."""
        (x, y), (wide, high) = self.places_mm[0], self.board_mm
        return x, y, x + wide, y + high

    @property
    def block_mm(self) -> Rect:
        """The rectangle of all boards, mm."""
        (x, y), (wide, high) = self.places_mm[-1], self.board_mm
        return *self.places_mm[0], x + wide, y + high

    def pages(self, badges: int) -> int:
        """Pages of so many badges; the mask's is not among them, as it is printed on film."""
        return math.ceil(badges / len(self.places_mm)) + self.bands_apart


def lay_out_sheets(badge: Badge) -> SheetLayout:
    """Lay out the sheets of badges like this one, on its paper or on the paper turned, whichever takes fewer pages."""
    x0, y0, x1, y1 = badge.outline_mm
    board = x1 - x0, y1 - y0
    layouts = []
    # On its own paper a board is printed also where little white is left around it.
    for page_mm, least in ((badge.page_mm, 1), (badge.page_mm[::-1], 0)):
        if places := _places_mm(page_mm, board, least):
            layout = SheetLayout(page_mm, places, board)
            layouts.append(replace(layout, bands_apart=pitch_bands(badge, layout.first_mm) is None))
    # Of two that are alike, `max` takes the first: the paper as the badge alone is printed.
    return max(layouts, key=lambda layout: (len(layout.places_mm), not layout.bands_apart))


def _places_mm(page_mm: Point, board: Point, least: int) -> tuple[Point, ...]:
    """Upper left corners of as many boards as fit; in the middle of the paper if there is room."""
    before, after = (LEFT_MM, TOP_MM), (RIGHT_MM, BOTTOM_MM)
    starts, counts = [], []
    for k in (0, 1):
        # A billionth of a millimetre to spare, because decimal fractions are rounded.
        room = page_mm[k] - before[k] - after[k] + 1e-9
        count = max(least, int((room + GUTTER_MM) / (board[k] + GUTTER_MM)))
        block = count * board[k] + (count - 1) * GUTTER_MM
        counts.append(count)
        starts.append(min(max((page_mm[k] - block) / 2, before[k]), page_mm[k] - after[k] - block))
    return tuple(
        (starts[0] + column * (board[0] + GUTTER_MM), starts[1] + row * (board[1] + GUTTER_MM))
        for row in range(counts[1])
        for column in range(counts[0])
    )
