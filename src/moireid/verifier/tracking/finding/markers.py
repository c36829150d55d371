"""Finding badges: the four markers of a page in a frame, and those of each page where there are several.

Markers of 10 px are found only in an enlarged picture, so the frame is enlarged tile by tile (`tiles_of`).
A film may be mirrored.  Squares are found once, and their bits are compared with the dictionary and with its mirror
image.  That costs half as much as a second search in the mirrored picture.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers
from moireid.verifier.picture import Box, Picture
from moireid.verifier.tracking.finding.page_finder import EitherWay, Grey, PageFinder, PicturePart
from moireid.verifier.tracking.finding.page_groups import moved_page, pages_of
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.search_work import search_work_ns

#: The neighbourhood is enlarged twofold if its markers are smaller than this, px.
ENLARGE_BELOW_PX = 24.0
#: One in this many searches looks for faded print; a page that is found is followed without a search.
FAINT_EVERY = 3
#: Least difference of faded print from its surroundings, and least standard deviation within a marker, counts: at a
#: contrast of 5 % in good light, black and white differ by 7 counts.
FAINT_COUNTS, FAINT_SD_COUNTS = 1.5, 2.0
#: A glance searches markers of at least this side by one threshold, with this window and difference in counts.  The
#: difference is above most noise, because outlines of noise take most time in a search.
GLANCE_PX, GLANCE_WINDOW_PX, GLANCE_COUNTS = 14.0, 9, 18.0
#: A quick look does the same for markers of this side.  On drawn rooms it finds pages of 13 px in four frames of five
#: and of 16 px in all, as a whole search does, at a third of its cost.
QUICK_PX, QUICK_WINDOW_PX, QUICK_COUNTS = 9.0, 13, 10.0
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

    least_px, most_enlarged_px2 = 16, 10**6

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

    def glance(self, luma: Picture | Grey) -> list[Array]:
        """As `pages`, but only for clear markers of at least `GLANCE_PX`; much faster."""
        coarse = self._searcher(**_one_threshold(luma.shape, GLANCE_PX, GLANCE_WINDOW_PX, GLANCE_COUNTS))
        return self._found_by(coarse, self._whole(luma))[0]

    def quick(self, luma: Picture | Grey) -> EitherWay:
        """As `either_way`, but only for clear markers of at least `QUICK_PX`; three times as fast."""
        quick = self._searcher(**_one_threshold(luma.shape, QUICK_PX, QUICK_WINDOW_PX, QUICK_COUNTS), **FINELY)
        return self._found_by(quick, self._whole(luma))

    def _found_by(self, how: cv2.aruco.ArucoDetector, part: PicturePart, before: Array | None = None) -> EitherWay:
        parameters = how.getDetectorParameters()
        if part.contrast != 1:
            parameters.adaptiveThreshConstant = part.steps(parameters.adaptiveThreshConstant)
            parameters.minOtsuStdDev *= part.contrast
            how = cv2.aruco.ArucoDetector(self._dictionaries, parameters)
        corners, identities, others, which = how.detectMarkersMultiDict(part.picture)
        self.work_ns += search_work_ns(part.picture, parameters, len(corners) + len(others))
        quads: tuple[list[Array], list[Array]] = ([], [])
        index: tuple[list[int], list[int]] = ([], [])
        if identities is None:
            return [], []
        for quad, identity, way in zip(corners, np.ravel(identities), np.ravel(which), strict=True):
            if int(identity) not in self._markers.ids:
                continue
            places = part.whole_px(quad.reshape(4, 2))
            if way == 1:
                # A mirror swaps left and right, also of the marker's corners.
                places = np.column_stack([part.width - 1 - places[:, 0], places[:, 1]])[[1, 0, 3, 2]]
            quads[way].append(places)
            index[way].append(self._markers.ids.index(int(identity)))
        straight, turned = (
            pages_of(np.array(found, float).reshape(-1, 4, 2), ids, self._corners_mm)
            for found, ids in zip(quads, index, strict=True)
        )
        moved = None if before is None else moved_page(np.array(quads[0]), index[0], self._corners_mm, before)
        return straight if moved is None else [*straight, moved], turned

    def _is_small(self, page: Array) -> bool:
        first = cv2.perspectiveTransform(self._corners_mm[:1].reshape(-1, 1, 2), page).reshape(4, 2)
        return float(np.linalg.norm(first[1] - first[0])) < ENLARGE_BELOW_PX


def _one_threshold(shape: tuple[int, ...], least_px: float, window_px: int, counts: float) -> dict[str, Any]:
    """Settings for markers of at least some side, and a single threshold."""
    return {
        "adaptiveThreshConstant": counts,
        "adaptiveThreshWinSizeMin": window_px,
        "adaptiveThreshWinSizeMax": window_px,
        # OpenCV takes the least perimeter as a share of the picture's longer side.
        "minMarkerPerimeterRate": 4 * least_px / max(shape),
    }


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
