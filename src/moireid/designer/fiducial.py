"""The coded frame of a badge: a thin line around its fields, with notches that show its orientation."""

from __future__ import annotations

import math

from moireid.badge import CodedFrame, Fiducial, Rect
from moireid.designer.request import DESIGN_FOCAL_PX, Request
from moireid.errors import DesignError
from moireid.fiducials import LEAST_LINE_MM, THINNEST_LINE_SHARE

#: Slots of a side, and which of them are notched, clockwise from the top left corner: top, right, bottom, left.  Of
#: the choices of six in sixteen it is one of those that differ most from themselves turned and mirrored: in four.
SLOTS = 4
NOTCHED: tuple[tuple[int, ...], ...] = ((0, 1, 2), (0, 2), (1,), ())
#: A notch's length as a share of its slot, and its depth as a share of the line.  It is open to the inside, so that the
#: frame's outer border is whole.
NOTCH_LENGTH, NOTCH_DEPTH = 0.3, 0.6
#: Width of the line at the far end, px.  Source: `benchmarks/fiducials.py`.
MIN_LINE_PX = 2.0
#: Squares are promised down to 9.1 px (`link`), so a line of 1 mm is followed as far as squares of so many.
LINE_AS_MARKER = 9.1 / MIN_LINE_PX
#: A format whose markers are larger than its range asks for, as its cameras are coarse, has a wider line too.
MARKER_LINES = 7.0
#: White between a frame's line and a field, in lines and at least, mm: the sheet lies within.
GAP_LINES, LEAST_GAP_MM = 1.05, 1.5
#: White between a frame's line and the board's edge, in lines: the outline must not run into a dark jacket.
EDGE_LINES = 2.0
#: Least shares of the board's height above and below a frame; and within these, clear of the board's edge and of the
#: frame's white, what name and id need, mm.
ENDS, NAME_MM, ID_MM = 0.11, 7.0, 6.5


def frame_and_field(request: Request, board: Rect) -> tuple[Rect, float, Rect]:
    """The frame's outer border, its line, mm, and the field within, for a request and its board.

    Convention: page mm.  The line is as wide as the far end of the range, or the format, asks for.
    Raises: DesignError for markers that are not known.
    """
    if request.markers != "frame":
        raise DesignError(f"markers {request.markers!r} is not possible; choose squares or frame")
    (x0, y0, x1, y1), frame, height = board, request.frame, board[3] - board[1]
    far_mm = 1000.0 * request.range_m[1]
    # A line that is too thin for its frame is refused by readers; the frame is smaller than the board.
    thinnest = max(LEAST_LINE_MM, THINNEST_LINE_SHARE * max(x1 - x0, height))
    widths = (MIN_LINE_PX * far_mm / DESIGN_FOCAL_PX, (frame.marker_mm or 0.0) / MARKER_LINES, thinnest)
    line_mm = math.ceil(10 * max(widths) - 1e-9) / 10
    margin, white = max(frame.margin_mm, EDGE_LINES * line_mm), max(EDGE_LINES * line_mm, LEAST_GAP_MM)
    head, foot = (
        max(max(ENDS, share) * height, margin + white + words_mm)
        for share, words_mm in ((frame.head, NAME_MM), (frame.foot, ID_MM))
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


def explain_fiducial(fiducial: Fiducial, far_px_per_mm: float) -> tuple[str, str]:
    """The row of `explain` about it: what, and the figure with its unit."""
    if isinstance(fiducial, CodedFrame):
        what, size_mm = "frame's line", fiducial.line_mm
    else:
        what, size_mm = "marker", fiducial.size_mm
    return f"{what}, far end", f"{far_px_per_mm * size_mm:.1f} pixels of {size_mm:g} mm"
