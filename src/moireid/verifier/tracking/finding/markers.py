"""Finding badges: the four markers of a page in a frame, and those of each page where there are several.

Markers of 10 px are found only in an enlarged picture, so the frame is enlarged tile by tile (`tiles_of`).
A film may be mirrored.  Squares are found once, and their bits are compared with the dictionary and with its mirror
image.  That costs half as much as a second search in the mirrored picture.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers
from moireid.verifier.kernel.library import picture_struct
from moireid.verifier.kernel.squares import SquareCodes
from moireid.verifier.picture import Box, Picture
from moireid.verifier.tracking.finding.page_finder import EitherWay, Grey, PageFinder, PicturePart
from moireid.verifier.tracking.finding.page_groups import (
    MOST_OF_ONE,
    moved_page,
    pages_of,
    pages_of_one,
    same_page,
    where_it_was,
)
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.search_work import ENLARGED_NS, clear_work_ns

#: The neighbourhood is enlarged twofold if its markers are smaller than this, px.
ENLARGE_BELOW_PX = 24.0
#: One in this many searches looks for faded print; a page that is found is followed without a search.
FAINT_EVERY = 3
#: Windows of the threshold, px, and least difference from the surroundings, counts: of a quick look, of a usual search,
#: of one for faded print (at a contrast of 5 % in good light, black and white differ by 7 counts), and of one of an
#: enlarged picture.  Source: no other few find as much at 8 to 36 px, sharp, blurred, smeared and faded; the narrow
#: window finds what is blurred.
QUICK = ((13, 10.0),)
USUAL = (*QUICK, (7, 5.0))
FAINT = (*USUAL, (13, 2.0))
SMALL = ((15, 5.0), (9, 3.0))
#: Shortest mean side of a marker that is looked for, px of the picture searched.
LEAST_PX = 9.0
#: A search finds a marker once: markers of one number closer than this share of their side are one.
SAME_SHARE = 0.5
#: A page with one small marker is looked for as a camera sees it whose focal length is this share of the width: median
#: of measured phone profiles (gyroflow).
FOCAL_SHARE = 0.75
#: Share of a code's number of cells that may be bright in its dark border, as OpenCV has it.
BORDER_SHARE = 0.35
#: What the kernel takes for a picture's values; it compares what was coded.
LEVELS = np.arange(256, dtype=np.float32)
#: Largest tile that is enlarged, (across, down) px and as a share of the frame, and least overlap of neighbours: a page
#: whose markers need enlarging is some 90 px high.
TILE_PX, TILE_SHARE, OVERLAP_PX = (1200, 720), 0.625, 120

Array = NDArray[np.float64]
#: Windows of the threshold, px, and differences, counts.
Windows = tuple[tuple[int, float], ...]


def faint_turns() -> Iterator[bool]:
    """Whether the next search looks for faded print; true for every `FAINT_EVERY`-th."""
    return itertools.cycle([False] * (FAINT_EVERY - 1) + [True])


class MarkerFinder(PageFinder):
    """Finds pages by at least two visible markers of one layout, the largest first.

    By `near`, a page with two markers follows once more, with the tilt that it had then.
    """

    least_px, most_enlarged_px2, quick_share, close_share = 16, 10**6, 0.13, 0.03

    def __init__(self, markers: Markers) -> None:
        self._markers, self._codes = markers, _codes(markers)
        super().__init__(markers, marker_corners_mm(markers).reshape(-1, 2), USUAL, FAINT, SMALL)

    def quick(self, luma: Picture | Grey) -> EitherWay:
        """As `either_way`, but only for clear markers; half the work."""
        return self._found_by(QUICK, self._whole(luma))

    def near(self, luma: Picture | Grey, page: Array, *, faint: bool = False) -> EitherWay:
        """As `PageFinder.near`, but quickly if that finds the page there.

        That is by three markers, or all that it has in the picture: else others nearby would hide it.
        """
        box = self._neighbourhood(luma.shape, page)
        middles = cv2.perspectiveTransform(self._corners_mm.mean(axis=1).reshape(-1, 1, 2), page).reshape(-1, 2)
        inside = int(np.all((middles >= 0) & (middles < luma.shape[1::-1]), axis=1).sum())
        pages, count = self._searched(QUICK, self._part(luma, box), page)
        here = any(same_page(found, page, self._corners_mm) for found in pages[0])
        if here and count >= min(max(inside, 2), 3):
            return pages
        return super().near(luma, page, faint=faint)

    def _found_by(self, how: Windows, part: PicturePart, before: Array | None = None) -> EitherWay:
        return self._searched(how, part, before)[0]

    def _searched(self, how: Windows, part: PicturePart, before: Array | None = None) -> tuple[EitherWay, int]:
        """Pages in a part of a picture, and the number of markers found."""
        if min(part.picture.shape) < self.least_px:
            return ([], []), 0
        picture = part.picture if part.picture.strides[1] == 1 else np.ascontiguousarray(part.picture)
        if part.scale != 1:
            self.work_ns += ENLARGED_NS * picture.size
        struct = picture_struct(picture, LEVELS)
        quads: list[Array] = []
        words: list[int] = []
        for window, counts in how:
            steps = int(part.steps(counts))
            found = self._codes.find(struct, window=window, steps=steps, least_px=LEAST_PX, most=MOST_OF_ONE)
            self.work_ns += clear_work_ns(picture, found.runs, found.read)
            for quad, word in zip(found.corners, found.word.tolist(), strict=True):
                alike = (other for other, known in zip(quads, words, strict=True) if known // 4 == word // 4)
                if not any(_is_same(quad, other) for other in alike):
                    words.append(word)
                    quads.append(quad)
        number, turn = np.divmod(np.array(words, int), 4)
        which, ways = number % len(self._markers.ids), number // len(self._markers.ids)
        turned = [np.roll(quad, -int(by), axis=0) for quad, by in zip(quads, turn, strict=True)]
        return self._pages_of(turned, which.tolist(), ways.tolist(), part, before), len(quads)

    def _pages_of(
        self, corners: list[Array], which: list[int], ways: list[int], part: PicturePart, before: Array | None
    ) -> EitherWay:
        """Pages of markers in a part of a picture, straight and mirrored.

        Parameters: corners (M, (4, 2)): from the marker's first one, clockwise in the part; which: numbers on the page;
            ways: 1 for those that are mirrored, else 0; before: as `_found_by`.
        """
        quads: tuple[list[Array], list[Array]] = ([], [])
        index: tuple[list[int], list[int]] = ([], [])
        for quad, number, way in zip(corners, which, ways, strict=True):
            places = part.whole_px(quad)
            if way == 1:
                # A mirror swaps left and right, also of the marker's corners.
                places = np.column_stack([part.width - 1 - places[:, 0], places[:, 1]])[[1, 0, 3, 2]]
            quads[way].append(places)
            index[way].append(number)
        if before is not None:
            kept = where_it_was(np.array(quads[0]), index[0], self._corners_mm, before)
            quads[0][:], index[0][:] = [quads[0][k] for k in kept], [index[0][k] for k in kept]
        straight, turned = (
            pages_of(np.array(found, float).reshape(-1, 4, 2), ids, self._corners_mm)
            for found, ids in zip(quads, index, strict=True)
        )
        if before is None and len(quads[0]) == 1 and np.ptp(quads[0][0], axis=0).max() < ENLARGE_BELOW_PX:
            straight = pages_of_one(quads[0][0], self._corners_mm[index[0][0]], FOCAL_SHARE * part.width)
        moved = None if before is None else moved_page(np.array(quads[0]), index[0], self._corners_mm, before)
        return straight if moved is None else [*straight, moved], turned

    def _is_small(self, page: Array) -> bool:
        first = cv2.perspectiveTransform(self._corners_mm[:1].reshape(-1, 1, 2), page).reshape(4, 2)
        return float(np.linalg.norm(first[1] - first[0])) < ENLARGE_BELOW_PX


def _is_same(quad: Array, other: Array) -> bool:
    """Whether two squares (4, 2) are at one place."""
    side = float(np.linalg.norm(other[1] - other[0]))
    return float(np.abs((quad - other).mean(axis=0)).max()) < SAME_SHARE * side


def _codes(markers: Markers) -> SquareCodes:
    """The page's markers as the kernel reads them: each id, then each as a mirror shows it, each by quarter turns.

    Convention: by turn t, the marker's first corner is the t-th of the square, clockwise.
    """
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
    words, cells = [], known.markerSize
    for mirrored, identity in itertools.product((False, True), markers.ids):
        bits = cv2.aruco.Dictionary.getBitsFromByteList(known.bytesList[identity : identity + 1], cells)
        bits = bits[:, ::-1] if mirrored else bits
        turned = [np.rot90(bits, -turn).ravel() for turn in range(4)]
        words.append([sum(int(bit) << place for place, bit in enumerate(code)) for code in turned])
    return SquareCodes(np.array(words, np.uint64), cells, 1, int(BORDER_SHARE * cells**2))


def tiles_of(shape: tuple[int, ...]) -> list[Box]:
    """Tiles that cover a frame (height, width) and overlap by at least `OVERLAP_PX`."""
    rows, columns = (_spans(size, most) for size, most in zip(shape[:2], reversed(TILE_PX), strict=True))
    return [(x0, y0, x1, y1) for y0, y1 in rows for x0, x1 in columns]


def _spans(size: int, most: int) -> list[tuple[int, int]]:
    long = max(min(most, round(TILE_SHARE * size)), min(size, 2 * OVERLAP_PX))
    count = max(1, math.ceil((size - OVERLAP_PX) / (long - OVERLAP_PX))) if size > long else 1
    starts = np.linspace(0, size - long, count).astype(int).tolist()
    return [(start, start + long) for start in starts]
