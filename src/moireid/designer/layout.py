"""The places of markers and gratings on the page.

The board is in the middle of the page, so the page's centre is also the badge's centre.  If the board is too wide for
the paper, the paper is turned.  Four markers are in its corners, and the name is between the upper ones.  The gratings
fill the field between the upper and the lower pair, from edge to edge, because a wider grating separates beat
frequencies better; a template may leave more room above and below it.  On a badge of two axes the left half of the
field senses x, and the right half y.  In place of the markers a coded frame may
be around the fields: a thin line, with notches that show its orientation.

Three fields sense 0, 60 and 120 degrees, between the markers of a board (`three_fields`).  The free room of a board is
a cross: between the upper and the lower markers from edge to edge, and in the middle column from the name down to the
id.  An annealed search over places and sizes of three rectangles at these angles ended, on boards of 146 x 160 mm, at
three alike: one level above the id, the others as the rafters of a roof above it, each against the board's edge and the
corner of an upper marker.  V-shaped, fanned and pinwheel arrangements had smaller cells.  Here this arrangement is in
closed form; its size is bounded by the way from the upper markers' corner, through a rafter and a gap, to the corner of
the level field.

Convention: page mm; of the three fields mm from the board's centre, y down; rectangles in the fields' own frames
(`moireid.frames`).
Source: plane geometry; with half widths `side` of the room and corners (`column`, `row`) of the markers' white, a
rafter of length s and height h is at x = side - s/4 - h sqrt(3)/4, and touches the corner where
y = h - row + sqrt(3) (x - column).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from moireid.badge import CodedFrame, Fiducial, Markers, Rect
from moireid.designer.formats import format_named
from moireid.designer.order import DESIGN_FOCAL_PX, Order, Pair
from moireid.errors import DesignError
from moireid.fiducials import LEAST_LINE_MM, THINNEST_LINE_SHARE
from moireid.frames import Axis, own_frame
from moireid.profiles import PAPERS_MM

#: Slots of a side, and which of them are notched, clockwise from the top left corner: top, right, bottom, left.  Of
#: the choices of six in sixteen it is one of those that differ most from themselves turned and mirrored: in four.
SLOTS = 4
NOTCHED: tuple[tuple[int, ...], ...] = ((0, 1, 2), (0, 2), (1,), ())
#: A notch's length as a share of its slot, and its depth as a share of the line.  It is open to the inside, so that the
#: frame's outer border is whole.
NOTCH_LENGTH, NOTCH_DEPTH = 0.3, 0.6
#: Width of the line at the far end, px.  Source: docs/decisions/tracking.md.
MIN_LINE_PX = 2.0
#: Squares are promised down to 9.1 px (`reach`), so a line of 1 mm is followed as far as squares of so many.
LINE_AS_MARKER = 9.1 / MIN_LINE_PX
#: A format whose markers are larger than its range asks for, as its cameras are coarse, has a wider line too.
MARKER_LINES = 7.0
#: White between a frame's line and a field, in lines and at least, mm: the sheet lies within.
GAP_LINES, LEAST_GAP_MM = 1.05, 1.5
#: White between a frame's line and the board's edge, in lines: the outline must not run into a dark jacket.
EDGE_LINES = 2.0
#: Least shares of the board's height above and below a frame; and within these, clear of the board's edge and of the
#: frame's white, what name and id need, mm.
ENDS, FRAMED_NAME_MM, FRAMED_ID_MM = 0.11, 7.0, 6.5


def frame_and_field(order: Order, board: Rect) -> tuple[Rect, float, Rect]:
    """The frame's outer border, its line, mm, and the field within, for an order and its board.

    Convention: page mm.  The line is as wide as the far end of the range, or the format, asks for.
    """
    assert order.range_m is not None
    (x0, y0, x1, y1), form, height = board, format_named(order.format), board[3] - board[1]
    far_mm = 1000.0 * order.range_m[1]
    # A line that is too thin for its frame is refused by readers; the frame is smaller than the board.
    thinnest = max(LEAST_LINE_MM, THINNEST_LINE_SHARE * max(x1 - x0, height))
    widths = (MIN_LINE_PX * far_mm / DESIGN_FOCAL_PX, (form.marker_mm or 0.0) / MARKER_LINES, thinnest)
    line_mm = math.ceil(10 * max(widths) - 1e-9) / 10
    margin, white = max(form.margin_mm, EDGE_LINES * line_mm), max(EDGE_LINES * line_mm, LEAST_GAP_MM)
    head, foot = (
        max(max(ENDS, share) * height, margin + white + words_mm)
        for share, words_mm in ((order.head, FRAMED_NAME_MM), (order.foot, FRAMED_ID_MM))
    )
    left, top, right, bottom = (round(value, 3) for value in (x0 + margin, y0 + head, x1 - margin, y1 - foot))
    inset = line_mm + max(GAP_LINES * line_mm, LEAST_GAP_MM)
    field = (left + inset, top + inset, right - inset, bottom - inset)
    a, b, c, d = (round(value, 3) for value in field)
    return (left, top, right, bottom), line_mm, (a, b, c, d)


def coded_frame(rect_mm: Rect, line_mm: float) -> CodedFrame:
    """The frame with that outer border and line.

    Convention: page mm; the notches' edges are rounded to a micrometre.
    """
    x0, y0, x1, y1 = rect_mm
    notches: list[Rect] = []
    outer, inner = (1 - NOTCH_DEPTH) * line_mm, line_mm
    for side, slots in enumerate(NOTCHED):
        for slot in slots:
            begin, end = ((slot + 0.5 + sign * NOTCH_LENGTH / 2) / SLOTS for sign in (-1, 1))
            if side in (2, 3):
                begin, end = 1 - end, 1 - begin
            low, length = (x0, x1 - x0) if side in (0, 2) else (y0, y1 - y0)
            begin, end = low + begin * length, low + end * length
            rects = (
                (begin, y0 + outer, end, y0 + inner),
                (x1 - inner, begin, x1 - outer, end),
                (begin, y1 - inner, end, y1 - outer),
                (x0 + outer, begin, x0 + inner, end),
            )
            left, top, right, bottom = (round(value, 3) for value in rects[side])
            notches.append((left, top, right, bottom))
    return CodedFrame(rect_mm, line_mm, tuple(notches))


def as_marker_mm(fiducial: Fiducial) -> float:
    """The side of the squares that are followed as far as the fiducial is, mm."""
    return fiducial.line_mm * LINE_AS_MARKER if isinstance(fiducial, CodedFrame) else fiducial.size_mm


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
            "give a larger board such as 146x160, or axes=xy"
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


#: The published prototype's marker is 26 mm on a 146 mm board; other boards keep the proportion.
MARKER_MM_PER_BOARD_MM = 26.0 / 146.0
DICTIONARY: Final = "DICT_4X4_50"
#: White around a marker, in modules: OpenCV asks for one; the sixth part of a 4x4 marker is a module.
QUIET_MODULES = 1.05
#: Paper left around the board: for crop marks and scale bars, and what printers leave white.
PAPER_MARGIN_MM = 15.0
#: Paper between the sheets of a badge of several axes.
GAP_MM = 4.0
#: Paper between a field in the middle column and the box of the name, and half the height of the id with its paper.
NAME_MM, ID_MM = 1.0, 3.5
MIN_FIELD_MM = 12.0
#: A small board of good proportion that can be read from some distance; narrower ones can be made if they are tall.
SMALL_BOARD_MM = (60.0, 66.0)


@dataclass(frozen=True)
class Layout:
    """Rectangles in page coordinates, mm; fields: one a grating, with its axis, in that axis's own frame."""

    page_mm: tuple[float, float]
    board_mm: Rect
    fields_mm: tuple[tuple[Axis, Rect], ...]
    markers: Fiducial


def lay_out(order: Order) -> Layout:
    """Place everything.  Raises: DesignError where the board does not fit the paper, or holds no grating."""
    assert order.size_mm is not None
    width, height = order.size_mm
    page_mm, board = _on_paper(order.paper, width, height)
    if order.markers != "squares":
        return _framed(order, page_mm, board)
    form = format_named(order.format)
    marker_mm = form.marker_mm or round(MARKER_MM_PER_BOARD_MM * min(width, height), 2)
    least_mm = form.margin_mm + marker_mm + QUIET_MODULES * marker_mm / 6
    top, bottom = board[1] + max(least_mm, order.head * height), board[3] - max(least_mm, order.foot * height)
    if bottom - top < MIN_FIELD_MM or width < 3 * marker_mm:
        raise DesignError(
            f"a board of {width:g} x {height:g} mm leaves no room for the fringes; give at least "
            f"{SMALL_BOARD_MM[0]:g}x{SMALL_BOARD_MM[1]:g}",
            size_mm=SMALL_BOARD_MM,
        )
    left, right = board[0] + form.margin_mm, board[2] - form.margin_mm
    field: Rect = (round(left, 3), round(top, 3), round(right, 3), round(bottom, 3))
    inset = form.margin_mm + marker_mm / 2
    centers = (
        (board[0] + inset, board[1] + inset),
        (board[2] - inset, board[1] + inset),
        (board[2] - inset, board[3] - inset),
        (board[0] + inset, board[3] - inset),
    )
    markers = Markers(DICTIONARY, marker_mm, (0, 1, 2, 3), centers)
    if order.axes == "hex":
        if max(order.head, order.foot) * height > least_mm:
            raise DesignError(
                "three directions of fringes take the room that this template gives to words and pictures; take "
                "another template, such as plain on a badge that lies, or axes=x or xy"
            )
        side, middle = (right - left) / 2, (board[1] + board[3]) / 2
        # Between the markers there is room up to the name and down to the id.
        upper, lower = board[1] + form.margin_mm + marker_mm + NAME_MM, centers[3][1] - ID_MM
        cross = Room(side, width / 2 - least_mm, middle - top, middle - min(top, upper), max(bottom, lower) - middle)
        return Layout(page_mm, board, three_fields(cross, GAP_MM, page_mm), markers)
    return Layout(page_mm, board, _fields(field, order), markers)


def _framed(order: Order, page_mm: tuple[float, float], board: Rect) -> Layout:
    """A layout without squares: the name, a frame around the fields, and the id."""
    rect, line_mm, field = frame_and_field(order, board)
    if order.axes == "hex":
        raise DesignError("three turned fields need markers in the corners; choose markers squares, or axes x or xy")
    if min(field[2] - field[0], field[3] - field[1]) < MIN_FIELD_MM:
        raise DesignError(
            f"a frame with a line of {line_mm:g} mm leaves no room for the fringes; choose markers squares, a larger "
            "board or a shorter range"
        )
    return Layout(page_mm, board, _fields(field, order), coded_frame(rect, line_mm))


def page_for(paper: str, width: float, height: float) -> Pair | None:
    """The page on which a board of that size has its marks around it, portrait or else landscape; None for neither."""
    room = PAPERS_MM[paper][0] - 2 * PAPER_MARGIN_MM + 1e-9, PAPERS_MM[paper][1] - 2 * PAPER_MARGIN_MM + 1e-9
    if width <= room[0] and height <= room[1]:
        return PAPERS_MM[paper]
    return PAPERS_MM[paper][::-1] if width <= room[1] and height <= room[0] else None


def _on_paper(paper: str, width: float, height: float) -> tuple[tuple[float, float], Rect]:
    """The page, and the board in its middle.  Raises: DesignError where it does not fit."""
    page_mm = page_for(paper, width, height)
    if page_mm is not None:
        x0, y0 = (page_mm[0] - width) / 2, (page_mm[1] - height) / 2
        return page_mm, (x0, y0, x0 + width, y0 + height)
    room = tuple(round(side - 2 * PAPER_MARGIN_MM, 3) for side in PAPERS_MM[paper])
    raise DesignError(
        f"a board of {width:g} x {height:g} mm does not fit {paper}; at most {room[0]:g} x {room[1]:g} mm, or "
        f"{room[1]:g} x {room[0]:g} on the paper turned, leave room for crop marks",
        size_mm=(min(width, room[0]), min(height, room[1])),
    )


def _fields(field: Rect, order: Order) -> tuple[tuple[Axis, Rect], ...]:
    """The field as one grating, or as two halves of either axis."""
    if order.axes == "x":
        return (("x", field),)
    middle = (field[0] + field[2]) / 2
    left: Rect = (field[0], field[1], round(middle - GAP_MM / 2, 3), field[3])
    right: Rect = (round(middle + GAP_MM / 2, 3), field[1], field[2], field[3])
    return (("x", left), ("y", right))
