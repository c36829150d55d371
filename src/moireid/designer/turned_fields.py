"""Three fields that sense 0, 60 and 120 degrees, between the markers of a board.

The free room of a board is a cross: between the upper and the lower markers from edge to edge, and in the middle column
from the name down to the id.  An annealed search over places and sizes of three rectangles at these angles ended, on
boards of 146 x 160 mm, at three alike: one level above the id, the others as the rafters of a roof above it, each
against the board's edge and the corner of an upper marker.  V-shaped, fanned and pinwheel arrangements had smaller
cells.  Here this arrangement is in closed form; its size is bounded by the way from the upper markers' corner, through
a rafter and a gap, to the corner of the level field.

Convention: mm from the board's centre, y down; rectangles in the fields' own frames (`moireid.frames`).
Source: plane geometry; with half widths `side` of the room and corners (`column`, `row`) of the markers' white, a
rafter of length s and height h is at x = side - s/4 - h sqrt(3)/4, and touches the corner where
y = h - row + sqrt(3) (x - column).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from moireid.errors import DesignError
from moireid.frames import Axis, Rect, own_frame

#: The level field is an "x" one, as its lines can be set on a printer's dots.
AXES: tuple[Axis, ...] = ("x", 60.0, 120.0)
#: Length over height of a field.  Six rows, of which three hold twelve cells each, carry a third of 64 bits; with this
#: shape rows and cells are read farthest.
SHAPE = 1.8
#: Least height of a field, mm: six rows of 2 mm.
MIN_HEIGHT_MM = 12.0
_ROOT3 = math.sqrt(3.0)


@dataclass(frozen=True)
class Room:
    """The cross that fields may fill, mm from the board's centre.

    side: half its width between the pairs of markers; column: half width of the middle column; row: how far the rows
    between the markers reach up, white around them left out; top, bottom: how far the column reaches up and down.
    """

    side: float
    column: float
    row: float
    top: float
    bottom: float


def three_fields(room: Room, gap_mm: float, page_mm: tuple[float, float]) -> tuple[tuple[Axis, Rect], ...]:
    """The three fields, for a board in the middle of its page: axis and rectangle in the axis's own frame, page mm.

    Raises: DesignError where they would be too small.
    """
    way = _ROOT3 / 2 * room.column + (room.row + room.bottom) / 2 - gap_mm
    # The rafters also keep apart from each other, and below the name.
    height = min(way / (1.5 + _ROOT3 / 4 * SHAPE), (room.side - gap_mm / 2) / (SHAPE / 2 + _ROOT3 / 2))
    length = min(SHAPE * height, 2 * (room.side - room.column) + 2 / _ROOT3 * (room.top - room.row))
    if height < MIN_HEIGHT_MM:
        raise DesignError(
            f"three fields of {height:.1f} mm height are too small to be read, and {MIN_HEIGHT_MM:g} mm are needed; "
            "give a larger board such as 146x160, or --axes xy"
        )
    x = room.side - length / 4 - _ROOT3 / 4 * height
    y = height - room.row + _ROOT3 * (x - room.column)
    middles = ((0.0, room.bottom - height / 2), (x, y), (-x, y))
    fields: list[tuple[Axis, Rect]] = []
    for axis, (right, down) in zip(AXES, middles, strict=True):
        along, across = own_frame(axis, page_mm).places((page_mm[0] / 2 + right, page_mm[1] / 2 + down)).tolist()
        half = round(length / 2, 3), round(height / 2, 3)
        low, top = round(along - half[0], 3), round(across - half[1], 3)
        fields.append((axis, (low, top, round(low + 2 * half[0], 3), round(top + 2 * half[1], 3))))
    return tuple(fields)
