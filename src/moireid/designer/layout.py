"""The places of markers and gratings on the page.

The board is in the middle of the page, so the page's centre is also the badge's centre.  If the board is too wide for
the paper, the paper is turned.  Four markers are in its corners, and the name is between the upper ones.  The gratings
fill the field between the upper and the lower pair, from edge to edge, because a wider grating separates beat
frequencies better; a template may leave more room above and below it.  On a badge of two axes the left half of the
field senses x, and the right half y.  Three gratings are placed by `turned_fields`, and those of a lens array share one
field.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from moireid.badge import Fiducial, Markers, Rect
from moireid.designer.fiducial import coded_frame, frame_and_field
from moireid.designer.request import Request
from moireid.designer.turned_fields import Room, three_fields
from moireid.errors import DesignError
from moireid.frames import Axis
from moireid.profiles import PAPERS_MM

#: The published prototype's marker is 26 mm on a 146 mm board; other boards keep the proportion.
MARKER_MM_PER_BOARD_MM = 26.0 / 146.0
DICTIONARY: Final = "DICT_4X4_50"
#: White around a marker, in modules: OpenCV asks for one; the sixth part of a 4x4 marker is a module.
QUIET_MODULES = 1.05
#: Paper left around the board for crop marks and scale bars.
PAPER_MARGIN_MM = 12.0


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


def lay_out(request: Request) -> Layout:
    """Place everything.  Raises: DesignError where the board does not fit the paper, or holds no grating."""
    if request.paper not in PAPERS_MM:
        raise DesignError(f"paper {request.paper!r} is not known; choose one of {', '.join(PAPERS_MM)}")
    width, height = request.size_mm
    page_mm, board = _on_paper(request.paper, width, height)
    if request.markers != "squares":
        return _framed(request, page_mm, board)
    frame = request.frame
    marker_mm = frame.marker_mm or round(MARKER_MM_PER_BOARD_MM * min(width, height), 2)
    least_mm = frame.margin_mm + marker_mm + QUIET_MODULES * marker_mm / 6
    top, bottom = board[1] + max(least_mm, frame.head * height), board[3] - max(least_mm, frame.foot * height)
    if bottom - top < MIN_FIELD_MM or width < 3 * marker_mm:
        raise DesignError(
            f"a board of {width:g} x {height:g} mm leaves no room for the fringes; give at least "
            f"{SMALL_BOARD_MM[0]:g}x{SMALL_BOARD_MM[1]:g}",
            size_mm=SMALL_BOARD_MM,
        )
    left, right = board[0] + frame.margin_mm, board[2] - frame.margin_mm
    field: Rect = (round(left, 3), round(top, 3), round(right, 3), round(bottom, 3))
    inset = frame.margin_mm + marker_mm / 2
    centers = (
        (board[0] + inset, board[1] + inset),
        (board[2] - inset, board[1] + inset),
        (board[2] - inset, board[3] - inset),
        (board[0] + inset, board[3] - inset),
    )
    markers = Markers(DICTIONARY, marker_mm, (0, 1, 2, 3), centers)
    if request.axes == "hex":
        if max(frame.head, frame.foot) * height > least_mm:
            raise DesignError(
                "three directions of fringes take the room that this template gives to words and pictures; take "
                "another template, such as plain on a badge that lies, or --axes x or xy"
            )
        side, middle = (right - left) / 2, (board[1] + board[3]) / 2
        # Between the markers there is room up to the name and down to the id.
        upper, lower = board[1] + frame.margin_mm + marker_mm + NAME_MM, centers[3][1] - ID_MM
        cross = Room(side, width / 2 - least_mm, middle - top, middle - min(top, upper), max(bottom, lower) - middle)
        return Layout(page_mm, board, three_fields(cross, GAP_MM, page_mm), markers)
    return Layout(page_mm, board, _fields(field, request), markers)


def _framed(request: Request, page_mm: tuple[float, float], board: Rect) -> Layout:
    """A layout without squares: the name, a frame around the fields, and the id."""
    rect, line_mm, field = frame_and_field(request, board)
    if request.axes == "hex":
        raise DesignError("three turned fields need markers in the corners; choose markers squares, or axes x or xy")
    if min(field[2] - field[0], field[3] - field[1]) < MIN_FIELD_MM:
        raise DesignError(
            f"a frame with a line of {line_mm:g} mm leaves no room for the fringes; choose markers squares, a larger "
            "board or a shorter range"
        )
    return Layout(page_mm, board, _fields(field, request), coded_frame(rect, line_mm))


def _on_paper(paper: str, width: float, height: float) -> tuple[tuple[float, float], Rect]:
    """The page, portrait or else landscape, and the board in its middle.  Raises: DesignError where it fits neither."""
    portrait = PAPERS_MM[paper]
    for page_mm in (portrait, portrait[::-1]):
        if width <= page_mm[0] - 2 * PAPER_MARGIN_MM + 1e-9 and height <= page_mm[1] - 2 * PAPER_MARGIN_MM + 1e-9:
            x0, y0 = (page_mm[0] - width) / 2, (page_mm[1] - height) / 2
            return page_mm, (x0, y0, x0 + width, y0 + height)
    room = tuple(round(side - 2 * PAPER_MARGIN_MM, 3) for side in portrait)
    raise DesignError(
        f"a board of {width:g} x {height:g} mm does not fit {paper}; at most {room[0]:g} x {room[1]:g} mm, or "
        f"{room[1]:g} x {room[0]:g} on the paper turned, leave room for crop marks",
        size_mm=(min(width, room[0]), min(height, room[1])),
    )


def _fields(field: Rect, request: Request) -> tuple[tuple[Axis, Rect], ...]:
    """The field as one grating, as two that share it under a lens array, or as two halves of either axis."""
    if request.front == "array":
        return ("x", field), ("y", field)
    if request.axes == "x":
        return (("x", field),)
    if request.axes != "xy":
        raise DesignError(f"axes {request.axes!r} is not possible; choose x, xy or hex")
    middle = (field[0] + field[2]) / 2
    left: Rect = (field[0], field[1], round(middle - GAP_MM / 2, 3), field[3])
    right: Rect = (round(middle + GAP_MM / 2, 3), field[1], field[2], field[3])
    return (("x", left), ("y", right))
