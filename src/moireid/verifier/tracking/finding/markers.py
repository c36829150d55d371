"""Finding badges: the four markers of a page in a frame, and those of each page where there are several.

Markers of 10 px are found only in an enlarged picture, so the frame is enlarged tile by tile (`tiles_of`).
A film may be mirrored.  Squares are found once, and their bits are compared with the dictionary and with its mirror
image.  That costs half as much as a second search in the mirrored picture.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers
from moireid.verifier.kernel.library import picture_struct
from moireid.verifier.kernel.squares import SquareCodes
from moireid.verifier.picture import Box, Picture
from moireid.verifier.tracking.finding.page_finder import EitherWay, Grey, PageFinder, PicturePart
from moireid.verifier.tracking.finding.page_groups import MOST_OF_ONE, moved_page, pages_of, same_page
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.search_work import clear_work_ns, search_work_ns

#: The neighbourhood is enlarged twofold if its markers are smaller than this, px.
ENLARGE_BELOW_PX = 24.0
#: One in this many searches looks for faded print; a page that is found is followed without a search.
FAINT_EVERY = 3
#: Least difference of faded print from its surroundings, and least standard deviation within a marker, counts: at a
#: contrast of 5 % in good light, black and white differ by 7 counts.
FAINT_COUNTS, FAINT_SD_COUNTS = 1.5, 2.0
#: A quick look is by the kernel: one threshold with this window and difference in counts, for markers of this side.
QUICK_PX, QUICK_WINDOW_PX, QUICK_COUNTS = 9.0, 13, 10.0
#: Share of a code's number of cells that may be bright in its dark border, as OpenCV has it.
BORDER_SHARE = 0.35
#: What the kernel takes for a picture's values; it compares what was coded.
LEVELS = np.arange(256, dtype=np.float32)
#: Windows of the threshold in an enlarged picture, px: least, most, step; more windows find few more markers.
SMALL_WINDOWS_PX = (7, 27, 10)
#: Pixels per cell when bits of small and faint markers are read, and the margin left out, where cells are blurred.
FINELY = {"perspectiveRemovePixelPerCell": 8, "perspectiveRemoveIgnoredMarginPerCell": 0.25}
#: Largest tile that is enlarged, (across, down) px and as a share of the frame, and least overlap of neighbours: a page
#: whose markers need enlarging is some 90 px high.
TILE_PX, TILE_SHARE, OVERLAP_PX = (1200, 720), 0.625, 120

Array = NDArray[np.float64]


def faint_turns() -> Iterator[bool]:
    """Whether the next search looks for faded print; true for every `FAINT_EVERY`-th."""
    return itertools.cycle([False] * (FAINT_EVERY - 1) + [True])


class MarkerFinder(PageFinder):
    """Finds pages by at least two visible markers of one layout, the largest first.

    By `near`, a page with two markers follows once more, with the tilt that it had then.
    """

    least_px, most_enlarged_px2, quick_share = 16, 10**6, 0.10

    def __init__(self, markers: Markers) -> None:
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
        self._dictionaries, self._markers = [known, _mirrored(known)], markers
        # Faded print differs by less than OpenCV's defaults: 7 counts from its surroundings, 10 between black and
        # white.  Lower limits make a search slower, so they are not used in every search.
        faint = self._searcher(adaptiveThreshConstant=FAINT_COUNTS, minOtsuStdDev=FAINT_SD_COUNTS, **FINELY)
        least, most, step = SMALL_WINDOWS_PX
        small = self._searcher(
            adaptiveThreshWinSizeMin=least, adaptiveThreshWinSizeMax=most, adaptiveThreshWinSizeStep=step, **FINELY
        )
        super().__init__(markers, marker_corners_mm(markers).reshape(-1, 2), self._searcher(), faint, small)
        self._codes = _codes(self._dictionaries, markers.ids)

    def _searcher(self, **settings: Any) -> cv2.aruco.ArucoDetector:
        """OpenCV's detector with our settings and these."""
        parameters = cv2.aruco.DetectorParameters()
        # OpenCV's default refuses a perimeter under 3 % of the picture's width: 14 px a side at 1080p.
        parameters.minMarkerPerimeterRate = 0.01
        # `register` refines the whole page afterwards, so corners need no refinement here.
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        # The default of 0.6 corrects no bit of DICT_4X4_50, whose words differ by at least 4 bits.  One wrong bit is
        # allowed here: the four ids and their places on the page are checked below.
        parameters.errorCorrectionRate = 1.0
        for name, value in settings.items():
            setattr(parameters, name, value)
        return cv2.aruco.ArucoDetector(self._dictionaries, parameters)

    def quick(self, luma: Picture | Grey) -> EitherWay:
        """As `either_way`, but only for clear markers of at least `QUICK_PX`; ten times as fast."""
        return self._clear_in(self._whole(luma))[0] if min(luma.shape[:2]) >= self.least_px else ([], [])

    def near(self, luma: Picture | Grey, page: Array, *, faint: bool = False) -> EitherWay:
        """As `PageFinder.near`; by the kernel, if it finds the page there.

        That is by three markers, or all that it has in the picture: else others nearby would hide it.
        """
        box = self._neighbourhood(luma.shape, page)
        middles = cv2.perspectiveTransform(self._corners_mm.mean(axis=1).reshape(-1, 1, 2), page).reshape(-1, 2)
        inside = int(np.all((middles >= 0) & (middles < luma.shape[1::-1]), axis=1).sum())
        if not faint and min(box[2] - box[0], box[3] - box[1]) >= self.least_px:
            pages, count = self._clear_in(self._part(luma, box), page)
            here = any(same_page(found, page, self._corners_mm) for found in pages[0])
            if here and count >= min(max(inside, 2), 3):
                return pages
        return super().near(luma, page, faint=faint)

    def _clear_in(self, part: PicturePart, before: Array | None = None) -> tuple[EitherWay, int]:
        """Pages with clear markers in a part of a picture, by the kernel, and the number of markers found."""
        picture = part.picture if part.picture.strides[1] == 1 else np.ascontiguousarray(part.picture)
        found = self._codes.find(
            picture_struct(picture, LEVELS),
            window=QUICK_WINDOW_PX,
            steps=int(part.steps(QUICK_COUNTS)),
            least_px=QUICK_PX,
            most=MOST_OF_ONE,
        )
        self.work_ns += clear_work_ns(picture, found.runs, found.read)
        number, turn = np.divmod(found.word, 4)
        which, ways = number % len(self._markers.ids), number // len(self._markers.ids)
        quads = [np.roll(quad, -int(by), axis=0) for quad, by in zip(found.corners, turn, strict=True)]
        return self._pages_of(quads, which.tolist(), ways.tolist(), part, before), len(quads)

    def _found_by(self, how: cv2.aruco.ArucoDetector, part: PicturePart, before: Array | None = None) -> EitherWay:
        parameters = how.getDetectorParameters()
        if part.contrast != 1:
            parameters.adaptiveThreshConstant = part.steps(parameters.adaptiveThreshConstant)
            parameters.minOtsuStdDev *= part.contrast
            how = cv2.aruco.ArucoDetector(self._dictionaries, parameters)
        corners, identities, others, ways = how.detectMarkersMultiDict(part.picture)
        self.work_ns += search_work_ns(part.picture, parameters, len(corners) + len(others))
        if identities is None:
            return [], []
        ours = [k for k, identity in enumerate(np.ravel(identities)) if int(identity) in self._markers.ids]
        which = [self._markers.ids.index(int(np.ravel(identities)[k])) for k in ours]
        quads = [corners[k].reshape(4, 2) for k in ours]
        return self._pages_of(quads, which, [int(np.ravel(ways)[k]) for k in ours], part, before)

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
        straight, turned = (
            pages_of(np.array(found, float).reshape(-1, 4, 2), ids, self._corners_mm)
            for found, ids in zip(quads, index, strict=True)
        )
        moved = None if before is None else moved_page(np.array(quads[0]), index[0], self._corners_mm, before)
        return straight if moved is None else [*straight, moved], turned

    def _is_small(self, page: Array) -> bool:
        first = cv2.perspectiveTransform(self._corners_mm[:1].reshape(-1, 1, 2), page).reshape(4, 2)
        return float(np.linalg.norm(first[1] - first[0])) < ENLARGE_BELOW_PX


def _codes(dictionaries: Sequence[cv2.aruco.Dictionary], ids: Sequence[int]) -> SquareCodes:
    """The page's markers as the kernel reads them: of each dictionary, each id, each by quarter turns.

    Convention: by turn t, the marker's first corner is the t-th of the square, clockwise.
    """
    words = []
    for dictionary, identity in itertools.product(dictionaries, ids):
        bits = cv2.aruco.Dictionary.getBitsFromByteList(
            dictionary.bytesList[identity : identity + 1], dictionary.markerSize
        )
        turned = [np.rot90(bits, -turn).ravel() for turn in range(4)]
        words.append([sum(int(bit) << place for place, bit in enumerate(code)) for code in turned])
    cells = dictionaries[0].markerSize
    return SquareCodes(np.array(words, np.uint64), cells, 1, int(BORDER_SHARE * cells**2))


def _mirrored(dictionary: cv2.aruco.Dictionary) -> cv2.aruco.Dictionary:
    """The same markers as a mirror shows them."""
    side, words = dictionary.markerSize, dictionary.bytesList
    bits = [cv2.aruco.Dictionary.getBitsFromByteList(words[k : k + 1], side) for k in range(len(words))]
    turned = [cv2.aruco.Dictionary.getByteListFromBits(np.ascontiguousarray(word[:, ::-1])) for word in bits]
    return cv2.aruco.Dictionary(np.concatenate(turned), side, dictionary.maxCorrectionBits)


def tiles_of(shape: tuple[int, ...]) -> list[Box]:
    """Tiles that cover a frame (height, width) and overlap by at least `OVERLAP_PX`."""
    rows, columns = (_spans(size, most) for size, most in zip(shape[:2], reversed(TILE_PX), strict=True))
    return [(x0, y0, x1, y1) for y0, y1 in rows for x0, x1 in columns]


def _spans(size: int, most: int) -> list[tuple[int, int]]:
    long = max(min(most, round(TILE_SHARE * size)), min(size, 2 * OVERLAP_PX))
    count = max(1, math.ceil((size - OVERLAP_PX) / (long - OVERLAP_PX))) if size > long else 1
    starts = np.linspace(0, size - long, count).astype(int).tolist()
    return [(start, start + long) for start in starts]
