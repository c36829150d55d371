"""The page's shapes, in page millimetres: the same for every program that draws them."""

from __future__ import annotations

import importlib.util
import math
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Cell, CodedFrame, Grating, Point, Rect
from moireid.frames import own_rect

CROP_MARK_MM = 6.0
CROP_GAP_MM = 2.0
#: A bar of 150 mm shows a scale error of 0.3 % as half a millimetre, which a ruler reads; a short one would not.
SCALE_BAR_MM = 150.0
#: Printers leave a rim of 3 to 5 mm white.
RIM_MM = 3.0
#: White between words and a frame or the board's edge, and the least room for words, mm.
LETTERING_GAP_MM, LEAST_LETTERING_MM = 1.0, 2.0
#: Air between a crop mark and a scale bar, and the least length of a mark; a mark that would be shorter stays whole.
BAR_GAP_MM, LEAST_MARK_MM = 0.5, 2.0
#: From the end of the level scale bar to the upright one, mm: room for a ruler.
BARS_APART_MM = 8.0


def dark_lines(grating: Grating, cell: Cell) -> list[Rect]:
    """The dark lines of one cell, cut at its border.

    Convention: lines begin at edge_mm + k pitch_mm along the grating's axis and are duty pitch_mm wide.
    Returns: rectangles as the cell's own is given: page mm, or in the frame of a turned grating (`moireid.frames`).
    Source: each edge is computed from k, never by adding up a rounded pitch, so that nothing drifts.
    """
    low, top, high, bottom = own_rect(grating.axis, cell.rect_mm)
    first = math.floor((low - cell.edge_mm) / cell.pitch_mm)
    last = math.ceil((high - cell.edge_mm) / cell.pitch_mm)
    lines: list[Rect] = []
    for k in range(first, last + 1):
        begin = cell.edge_mm + k * cell.pitch_mm
        start, stop = max(begin, low), min(begin + cell.duty * cell.pitch_mm, high)
        if stop - start > 1e-9:
            lines.append(own_rect(grating.axis, (start, top, stop, bottom)))
    return lines


def marker_squares(badge: Badge) -> list[tuple[Rect, list[Rect]]]:
    """For each marker its black square and, within, the runs of white modules; or a frame's sides and their notches.

    Convention: markers upright on the page, module rows from top to bottom.
    Returns: four pairs (black rectangle, white rectangles), page mm.
    """
    if isinstance(badge.markers, CodedFrame):
        return [(side, badge.markers.notches_in(number)) for number, side in enumerate(badge.markers.dark_mm)]
    squares = []
    for identity, square in zip(badge.markers.ids, badge.markers.dark_mm, strict=True):
        modules = marker_modules(badge.markers.dictionary, identity)
        module_mm = badge.markers.size_mm / len(modules)
        white: list[Rect] = []
        for row, line in enumerate(modules):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
            for begin, end in edges.reshape(-1, 2):
                left, top = square[0] + begin * module_mm, square[1] + row * module_mm
                white.append((left, top, left + (end - begin) * module_mm, top + module_mm))
        squares.append((square, white))
    return squares


def lettering_places(badge: Badge) -> tuple[tuple[Point, ...], float]:
    """The four places between which name and id are written, and half the height of their room, page mm.

    Convention: as `Markers.centers_mm`: the name between the first two, the id between the others.  A frame has no
        markers; the places are then above and below it.
    """
    if not isinstance(badge.markers, CodedFrame):
        return badge.markers.centers_mm, badge.markers.size_mm / 2
    board, (x0, y0, x1, y1) = badge.outline_mm, badge.markers.rect_mm
    half = max(min(y0 - board[1], board[3] - y1) / 2 - LETTERING_GAP_MM, LEAST_LETTERING_MM / 2)
    upper, lower = (board[1] + y0) / 2, (board[3] + y1) / 2
    return ((x0 - half, upper), (x1 + half, upper), (x1 + half, lower), (x0 - half, lower)), half


def marker_modules(dictionary: str, identity: int) -> NDArray[np.bool_]:
    """The modules of an ArUco marker with its black border, True where white; square, row by row from the top."""
    import cv2

    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    side = known.markerSize + 2
    return np.asarray(cv2.aruco.generateImageMarker(known, identity, side)) > 127


def crop_marks(board: Rect, length_mm: float = CROP_MARK_MM) -> list[tuple[float, float, float, float]]:
    """Eight strokes (x0, y0, x1, y1) outside the corners of the board, along its edges."""
    marks = []
    for x, outward_x in ((board[0], -1), (board[2], 1)):
        for y, outward_y in ((board[1], -1), (board[3], 1)):
            begin, end = CROP_GAP_MM, CROP_GAP_MM + length_mm
            marks.append((x + outward_x * begin, y, x + outward_x * end, y))
            marks.append((x, y + outward_y * begin, x, y + outward_y * end))
    return marks


def bar_places(page_mm: tuple[float, float], block: Rect) -> tuple[float, float]:
    """Where the two scale bars of a sheet are drawn: x of the upright one, y of the level one, mm.

    They are up to 14 mm from everything else on the sheet, as far as the paper and the printer's rim allow.  Around a
    small board the upright one is farther out, clear of the end of the level one.
    """
    clear = page_mm[0] / 2 - SCALE_BAR_MM / 2 - BARS_APART_MM
    return max(min(block[0] - 14.0, clear), 7.5), min(block[3] + 14.0, page_mm[1] - 10.5)


def clear_of_bars(
    mark: tuple[float, float, float, float], page_mm: tuple[float, float], bars: tuple[float, float]
) -> tuple[float, float, float, float]:
    """A crop mark whose outer end is cut off so that it keeps clear of the scale bars and the printer's rim."""
    x0, y0, x1, y1 = mark
    reach, middle = SCALE_BAR_MM / 2 + 1.0, (page_mm[0] / 2, page_mm[1] / 2)
    least_x, most_y = bars[0] + BAR_GAP_MM, bars[1] - BAR_GAP_MM
    low = (least_x if abs(y0 - middle[1]) <= reach else RIM_MM, RIM_MM)
    high = (page_mm[0] - RIM_MM, most_y if abs(x0 - middle[0]) <= reach else page_mm[1] - RIM_MM)
    x0, x1 = (min(max(x, low[0]), high[0]) for x in (x0, x1))
    y0, y1 = (min(max(y, low[1]), high[1]) for y in (y0, y1))
    return (x0, y0, x1, y1) if abs(x1 - x0) + abs(y1 - y0) >= LEAST_MARK_MM - 1e-6 else mark


@cache
def font_file(*, bold: bool = False) -> Path:
    """A font that covers Latin, Greek, Cyrillic and more: the DejaVu Sans that matplotlib ships.

    Found without importing matplotlib, which would cost a quarter of a second.
    """
    spec = importlib.util.find_spec("matplotlib")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent / "mpl-data/fonts/ttf" / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")
