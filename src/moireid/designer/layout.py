"""Where markers, grating and bands lie on the page.

The board stands in the middle of the page, so that the camera that looks at the page's centre looks at the badge's.
Four markers stand in its corners; the grating runs from edge to edge between the upper and the lower pair, because
its width is what separates beat frequencies; the name stands between the upper markers.
"""

from __future__ import annotations

from dataclasses import dataclass

from moireid.badge import Markers, Rect
from moireid.designer.request import Request
from moireid.errors import DesignError
from moireid.idcodes.pitch import BANDS
from moireid.profiles import PAPERS_MM

#: The published prototype's marker is 26 mm on a 146 mm board; other boards keep the proportion.
MARKER_MM_PER_BOARD_MM = 26.0 / 146.0
DICTIONARY = "DICT_4X4_50"
#: White around a marker, in modules: OpenCV asks for one; the sixth part of a 4x4 marker is a module.
QUIET_MODULES = 1.05
MARGIN_MM = 5.0
#: Paper left around the board for crop marks and scale bars.
PAPER_MARGIN_MM = 12.0


@dataclass(frozen=True)
class Layout:
    """Rectangles in page coordinates, mm; bands from top to bottom."""

    page_mm: tuple[float, float]
    board_mm: Rect
    grating_mm: Rect
    bands_mm: tuple[Rect, ...]
    markers: Markers


def lay_out(request: Request) -> Layout:
    """Place everything.  Raises: DesignError where the board does not fit the paper, or holds no grating."""
    if request.paper not in PAPERS_MM:
        raise DesignError(f"paper {request.paper!r} is not known; choose one of {', '.join(PAPERS_MM)}")
    page_mm = PAPERS_MM[request.paper]
    width, height = request.size_mm
    room = tuple(side - 2 * PAPER_MARGIN_MM for side in page_mm)
    if width > room[0] or height > room[1]:
        raise DesignError(
            f"a board of {width:g} x {height:g} mm does not fit {request.paper}; at most {room[0]:g} x {room[1]:g} mm "
            "leave room for crop marks"
        )
    marker_mm = round(MARKER_MM_PER_BOARD_MM * min(width, height), 2)
    x0, y0 = (page_mm[0] - width) / 2, (page_mm[1] - height) / 2
    board: Rect = (x0, y0, x0 + width, y0 + height)
    quiet_mm = QUIET_MODULES * marker_mm / 6
    top = y0 + MARGIN_MM + marker_mm + quiet_mm
    band_mm = int(100 * (board[3] - MARGIN_MM - marker_mm - quiet_mm - top) / BANDS) / 100
    if band_mm <= 0.5 or width < 3 * marker_mm:
        raise DesignError(f"a board of {width:g} x {height:g} mm leaves no room for the fringes; give at least 60x66")
    top = (board[1] + board[3] - BANDS * band_mm) / 2
    left, right = board[0] + MARGIN_MM, board[2] - MARGIN_MM
    bands = tuple((left, top + k * band_mm, right, top + (k + 1) * band_mm) for k in range(BANDS))
    inset = MARGIN_MM + marker_mm / 2
    centers = (
        (board[0] + inset, board[1] + inset), (board[2] - inset, board[1] + inset),
        (board[2] - inset, board[3] - inset), (board[0] + inset, board[3] - inset),
    )  # fmt: skip
    grating: Rect = (left, top, right, top + BANDS * band_mm)
    return Layout(page_mm, board, grating, bands, Markers(DICTIONARY, marker_mm, (0, 1, 2, 3), centers))
