"""Finding badges by their thin coded frames.

1. Threshold the picture, and follow the outlines of what is dark.
2. Of an outline with four corners, fit lines to its sides; where they meet are the frame's outer corners.
3. Read the notches in all eight ways in which the frame may lie, turned and mirrored.  One way must fit, and clearly
   better than the others: a page that is taken the wrong way round would have its fringes judged by a wrong motion.

Windows, screens and tables have four corners too.  So outlines are few for each picture, the largest, and what is not
notched like the frame costs no registration.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import CodedFrame
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.finding.page_finder import EitherWay, Grey, PageFinder, PicturePart
from moireid.verifier.tracking.finding.page_groups import MOST_PAGES
from moireid.verifier.tracking.search_work import outline_work_ns

Array = NDArray[np.float64]
#: Shortest side of a frame that is looked for, px.
LEAST_SIDE_PX = 32.0
#: Windows of the threshold, px, and least difference from the surroundings, counts: of a usual search, of one for faded
#: print, and of a quick one.
WINDOWS_PX, COUNTS, FAINT_COUNTS = (11, 23), 7.0, 1.5
QUICK_WINDOW_PX, QUICK_COUNTS = 15, 10.0
#: Gaps of an outline below this are closed, px: in the picture, and where it is enlarged.  More would join the frame to
#: what is next to the badge.
CLOSED_PX, CLOSED_ENLARGED_PX = 3, 5
#: An outline's corners are found to this share of its length.
CORNER_SHARE = 0.03
#: Points of a side that its line is fitted to: without this share at either end.
SIDE_END = 0.1
#: Most outlines that are read in one picture, the longest.
MOST_OUTLINES = 24
#: Places that are read along each side.
READ = 48
#: Least correlation of what is read with the notches, and by how much it must exceed that of any other way.
READ_CORRELATION, CLEARER = 0.55, 0.2
#: A lost frame is enlarged if its line is thinner than this, px.
ENLARGE_BELOW_PX = 2.5
#: Margin of the neighbourhood of a frame just seen, as a share of its size.
AGAIN = 0.1
#: One just seen is enlarged below this, px.
ENLARGE_AGAIN_PX = 1.9


class FrameFinder(PageFinder):
    """Finds pages by the coded frame of one layout; a search is given the threshold's windows and counts."""

    least_px, quick_share = LEAST_SIDE_PX, 0.25

    def __init__(self, frame: CodedFrame) -> None:
        x0, y0, x1, y1 = frame.rect_mm
        outer = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        usual = WINDOWS_PX, COUNTS
        super().__init__(frame, outer, usual, (WINDOWS_PX, FAINT_COUNTS), usual)
        self._frame = frame
        self._places, self._notched = _reading(frame)

    def again(self, luma: Picture | Grey, page: Array) -> list[Array]:
        """Pages within some pixels of where one is expected: a thin line is registered from within its own width."""
        box, thin = self._neighbourhood(luma.shape, page, AGAIN), self._line_px(page) < ENLARGE_AGAIN_PX
        return self._find_in(luma, box, (WINDOWS_PX[:1], COUNTS), enlarge=thin)[0]

    def quick(self, luma: Picture | Grey) -> EitherWay:
        """As `either_way`, but only for clear frames; faster."""
        return self._found_by(((QUICK_WINDOW_PX,), QUICK_COUNTS), self._whole(luma))

    def _is_small(self, page: Array) -> bool:
        return self._line_px(page) < ENLARGE_BELOW_PX

    def _line_px(self, page: Array) -> float:
        top = cv2.perspectiveTransform(self._outline_mm[:2].reshape(-1, 1, 2), page).reshape(2, 2)
        across_mm = self._frame.rect_mm[2] - self._frame.rect_mm[0]
        return float(np.linalg.norm(top[1] - top[0])) / across_mm * self._frame.line_mm

    def _found_by(
        self, how: tuple[tuple[int, ...], float], part: PicturePart, before: Array | None = None
    ) -> EitherWay:
        windows, counts = how[0], part.steps(how[1])
        closed_px = CLOSED_PX if part.scale == 1 else CLOSED_ENLARGED_PX
        found: list[tuple[float, int, Array]] = []
        outlines = _outlines(part.picture, windows, counts, LEAST_SIDE_PX * part.scale, closed_px)
        self.work_ns += outline_work_ns(part.picture, windows, counts, len(outlines))
        for quad in outlines:
            read = self._read(part.picture, quad)
            if read is None:
                continue
            score, way, corners = read
            places = part.whole_px(corners)
            if way == 1:
                places[:, 0] = part.width - 1 - places[:, 0]
            found.append((score, way, _page(self._outline_mm, places)))
        found.sort(key=lambda one: -one[0])
        straight, turned = ([page for _, way, page in found if way == asked][:MOST_PAGES] for asked in (0, 1))
        return straight, turned

    def _read(self, picture: Grey, quad: Array) -> tuple[float, int, Array] | None:
        """How well the notches fit, whether mirrored, and the frame's corners in the order of the page; None if they do
        not fit, or fit several ways.

        Parameters: quad (4, 2): outer corners in the picture, clockwise.
        """
        ways = [(way, np.roll(quad[::-1] if way else quad, turn, axis=0)) for way in (0, 1) for turn in range(4)]
        places = np.concatenate([_mapped(_page(self._outline_mm, corners), self._places) for _, corners in ways])
        seen = cv2.remap(picture, places[:, :1].astype(np.float32), places[:, 1:].astype(np.float32), cv2.INTER_LINEAR)
        values = seen.astype(float).reshape(len(ways), 4, READ)
        scores = _correlations(values, self._notched)
        best, second = np.argsort(-scores)[:2]
        if scores[best] < READ_CORRELATION or scores[best] < scores[second] + CLEARER:
            return None
        return float(scores[best]), *ways[best]


def _reading(frame: CodedFrame) -> tuple[Array, Array]:
    """Places to read, (4 READ, 2) page mm, along the middle of the notches' depth, and the share of each that is
    notched, (4, READ).
    """
    (x0, y0, x1, y1), notches = frame.rect_mm, np.array(frame.notches_mm)
    # How deep the notches' middles lie within the line, from the frame's outer border.
    middles = (notches[:, :2] + notches[:, 2:]) / 2
    depth = float(np.median(np.min(np.abs(middles[:, [0, 1, 0, 1]] - (x0, y0, x1, y1)), axis=1)))
    share = (np.arange(READ) + 0.5) / READ
    across, down = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
    sides = [
        np.column_stack([across, np.full(READ, y0 + depth)]),
        np.column_stack([np.full(READ, x1 - depth), down]),
        np.column_stack([across, np.full(READ, y1 - depth)]),
        np.column_stack([np.full(READ, x0 + depth), down]),
    ]
    places = np.concatenate(sides)
    inside = [
        (places[:, 0] > a) & (places[:, 0] < c) & (places[:, 1] > b) & (places[:, 1] < d) for a, b, c, d in notches
    ]
    return places, np.any(inside, axis=0).reshape(4, READ).astype(float)


def _correlations(values: Array, notched: Array) -> Array:
    """Correlation of brightness (W, 4, M) with notches (4, M), each side about its own mean, (W,)."""
    own = values - values.mean(axis=2, keepdims=True)
    asked = notched - notched.mean(axis=1, keepdims=True)
    size = np.sqrt((own**2).sum(axis=(1, 2)) * (asked**2).sum())
    return np.asarray((own * asked).sum(axis=(1, 2)) / np.maximum(size, 1e-9))


def _outlines(picture: Grey, windows: tuple[int, ...], counts: float, least_px: float, closed_px: int) -> list[Array]:
    """Outer corners (4, 2), clockwise, of the longest outlines of dark things that have four corners."""
    found: list[tuple[int, Array]] = []
    for window in windows:
        dark = cv2.adaptiveThreshold(picture, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, window, counts)
        # Where a line is as thin as a pixel, coding breaks it.
        dark = cv2.morphologyEx(dark, cv2.MORPH_CLOSE, np.ones((closed_px, closed_px), np.uint8))
        contours, _ = cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        found += [(len(points), quad) for points in contours for quad in _corners(points, least_px)]
    found.sort(key=lambda one: -one[0])
    return [quad for _, quad in found[:MOST_OUTLINES]]


def _corners(points: NDArray[np.int32], least_px: float) -> Iterator[Array]:
    """The corners of an outline, to a fraction of a pixel, if it has four."""
    if len(points) < 3.5 * least_px:
        return
    rough = cv2.approxPolyDP(points, CORNER_SHARE * len(points), closed=True)
    if len(rough) != 4 or not cv2.isContourConvex(rough):
        return
    rough = rough.reshape(4, 2)
    if min(np.linalg.norm(rough - np.roll(rough, 1, axis=0), axis=1)) < least_px:
        return
    way = points.reshape(-1, 2)
    at = [int(np.flatnonzero((way == corner).all(axis=1))[0]) for corner in rough]
    lines = []
    for begin, end in zip(at, [*at[1:], at[0]], strict=True):
        count = (end - begin) % len(way)
        cut = max(int(SIDE_END * count), 1)
        side = way[(begin + np.arange(cut, count - cut)) % len(way)]
        if len(side) < 8:
            return
        lines.append(cv2.fitLine(side.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01).ravel().astype(float))
    quad = np.array([_meeting(lines[k - 1], lines[k]) for k in range(4)])
    if not np.all(np.isfinite(quad)) or np.abs(quad - rough).max() > 0.05 * len(points):
        return
    # Image coordinates run down, so a positive area is clockwise.
    x, y = quad.T
    area = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    yield quad if area > 0 else quad[::-1]


def _meeting(one: Array, two: Array) -> Array:
    """Where two lines (direction, point) meet; not finite if they are parallel."""
    (a, b, x, y), (c, d, u, v) = one, two
    across = a * d - b * c
    share = ((u - x) * d - (v - y) * c) / across if across else np.inf
    return np.array([x + share * a, y + share * b])


def _page(outer_mm: Array, corners_px: Array) -> Array:
    """Homography page mm -> px through four corners."""
    return np.asarray(cv2.getPerspectiveTransform(outer_mm.astype(np.float32), corners_px.astype(np.float32)), float)


def _mapped(page: Array, places_mm: Array) -> Array:
    return np.asarray(cv2.perspectiveTransform(places_mm.reshape(-1, 1, 2), page).reshape(-1, 2))
