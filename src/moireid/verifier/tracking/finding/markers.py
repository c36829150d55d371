"""Finding badges: the four markers of a page in a frame, and those of each page where there are several.

The whole frame is searched until a badge is found, and then only its neighbourhood: a search of the whole frame costs
ten times the rest of the work.  Markers of 10 px are found only in an enlarged picture, which costs some six times as
much, so the frame is enlarged tile by tile (`tiles_of`).
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
from moireid.verifier.picture import Box, Picture, as_picture
from moireid.verifier.tracking.finding.page_groups import EitherWay, moved_page, pages_of
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.search_work import search_work_ns

#: Margin of the neighbourhood, as a share of the badge's size: the motion between two frames that it allows.
NEIGHBOURHOOD = 0.5
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
FINE_CELL_PX, FINE_MARGIN = 8, 0.25
#: Largest tile that is enlarged, (across, down) px and as a share of the frame, and least overlap of neighbours: a page
#: whose markers need enlarging is some 90 px high.
TILE_PX, TILE_SHARE, OVERLAP_PX = (1200, 720), 0.625, 120

Array = NDArray[np.float64]


def faint_turns() -> Iterator[bool]:
    """Whether the next search looks for faded print; true for every `FAINT_EVERY`-th."""
    return itertools.cycle([False] * (FAINT_EVERY - 1) + [True])


class MarkerFinder:
    """Finds pages by the markers of one layout; between pictures it keeps only `work_ns`, the work of all searches.

    Convention: homographies page mm -> image px, (3, 3) with h33 = 1; the centre of the top left pixel is (0, 0).
    """

    def __init__(self, markers: Markers) -> None:
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
        self._dictionaries = [known, _mirrored(known)]
        self._detector = self._searcher()
        # Faded print differs by less than OpenCV's defaults: 7 counts from its surroundings, 10 between black and
        # white.  Lower limits make a search slower, so they are not used in every search.
        finely = {"perspectiveRemovePixelPerCell": FINE_CELL_PX, "perspectiveRemoveIgnoredMarginPerCell": FINE_MARGIN}
        self._faint = self._searcher(adaptiveThreshConstant=FAINT_COUNTS, minOtsuStdDev=FAINT_SD_COUNTS, **finely)
        least, most, step = SMALL_WINDOWS_PX
        self._small = self._searcher(
            adaptiveThreshWinSizeMin=least, adaptiveThreshWinSizeMax=most, adaptiveThreshWinSizeStep=step, **finely
        )
        self._finely, self._markers = finely, markers
        self._corners_mm = marker_corners_mm(markers)
        self.work_ns = 0.0

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

    def pages(self, luma: Picture | NDArray[np.uint8], *, faint: bool = False) -> list[Array]:
        """Homographies of all pages in the frame with at least two visible markers, the largest first.

        Parameters: faint: also look for faded print, which takes longer.
        """
        return self.either_way(luma, faint=faint)[0]

    def either_way(self, luma: Picture | NDArray[np.uint8], *, faint: bool = False) -> EitherWay:
        """As `pages`, and also the mirrored pages."""
        return self._find_in(luma, (0, 0, luma.shape[1], luma.shape[0]), self._faint if faint else self._detector)

    def enlarged(self, luma: Picture | NDArray[np.uint8], box: Box) -> EitherWay:
        """As `either_way`, for small markers in a part of the frame."""
        return self._find_in(luma, box, self._small, enlarge=True)

    def around(self, page: Array, shape: tuple[int, ...]) -> Box | None:
        """The neighbourhood of a page if its markers are so small that enlarging helps; otherwise None."""
        return self._neighbourhood(shape, page) if self._marker_px(page) < ENLARGE_BELOW_PX else None

    def closely(self, luma: Picture | NDArray[np.uint8], page: Array) -> EitherWay:
        """As `near`, by the windows of small markers; for a page that was just lost, or for what may be a page."""
        small = self._marker_px(page) < ENLARGE_BELOW_PX
        return self._find_in(luma, self._neighbourhood(luma.shape, page), self._small, enlarge=small, before=page)

    def pages_near(self, luma: Picture | NDArray[np.uint8], page: Array, *, faint: bool = False) -> list[Array]:
        """As `pages`, but only in the neighbourhood of the page in the last frame."""
        return self.near(luma, page, faint=faint)[0]

    def near(self, luma: Picture | NDArray[np.uint8], page: Array, *, faint: bool = False) -> EitherWay:
        """As `either_way`, but only in the neighbourhood of the page in a recent frame.

        A page with two markers follows once more, with the tilt that it had then.
        """
        x0, y0, x1, y1 = box = self._neighbourhood(luma.shape, page)
        small = self._marker_px(page) < ENLARGE_BELOW_PX and (x1 - x0) * (y1 - y0) < 10**6
        return self._find_in(luma, box, self._faint if faint else self._detector, enlarge=small, before=page)

    def again(self, luma: Picture | NDArray[np.uint8], page: Array) -> list[Array]:
        """No pages: registration finds squares that are some pixels off by itself."""
        return []

    def glance(self, luma: Picture | NDArray[np.uint8]) -> list[Array]:
        """As `pages`, but only for clear markers of at least `GLANCE_PX`; much faster."""
        coarse = self._searcher(**_one_threshold(luma.shape, GLANCE_PX, GLANCE_WINDOW_PX, GLANCE_COUNTS))
        return self._found_by(coarse, as_picture(luma).whole, 1.0, (0, 0), luma.shape[1])[0]

    def quick(self, luma: Picture | NDArray[np.uint8]) -> EitherWay:
        """As `either_way`, but only for clear markers of at least `QUICK_PX`; three times as fast."""
        quick = self._searcher(**_one_threshold(luma.shape, QUICK_PX, QUICK_WINDOW_PX, QUICK_COUNTS), **self._finely)
        return self._found_by(quick, as_picture(luma).whole, 1.0, (0, 0), luma.shape[1])

    def _neighbourhood(self, shape: tuple[int, ...], page: Array) -> Box:
        corners = cv2.perspectiveTransform(self._corners_mm.reshape(-1, 1, 2), page).reshape(-1, 2)
        low, high = corners.min(axis=0), corners.max(axis=0)
        grow = NEIGHBOURHOOD * (high - low).max()
        x0, y0 = np.maximum(np.floor(low - grow), 0).astype(int)
        x1, y1 = np.minimum(np.ceil(high + grow), (shape[1], shape[0])).astype(int)
        return int(x0), int(y0), int(x1), int(y1)

    def _find_in(
        self,
        luma: Picture | NDArray[np.uint8],
        box: Box,
        detector: cv2.aruco.ArucoDetector,
        *,
        enlarge: bool = False,
        before: Array | None = None,
    ) -> EitherWay:
        """Pages in a part of the frame, which is enlarged twofold if `enlarge`."""
        x0, y0, x1, y1 = box
        if x1 - x0 < 16 or y1 - y0 < 16:
            return [], []
        crop, scale = as_picture(luma).part(box), 1.0
        if enlarge:
            scale = 2.0
            crop = np.asarray(cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC))
        return self._found_by(detector, crop, scale, (x0, y0), luma.shape[1], before)

    def _found_by(
        self,
        detector: cv2.aruco.ArucoDetector,
        picture: NDArray[np.uint8],
        scale: float,
        origin: tuple[int, int],
        width: int,
        before: Array | None = None,
    ) -> EitherWay:
        """Pages in a scaled part of the frame that begins at `origin`, in px of the frame."""
        corners, identities, others, which = detector.detectMarkersMultiDict(picture)
        self.work_ns += search_work_ns(picture, detector.getDetectorParameters(), len(corners) + len(others))
        quads: tuple[list[Array], list[Array]] = ([], [])
        index: tuple[list[int], list[int]] = ([], [])
        if identities is None:
            return [], []
        for quad, identity, way in zip(corners, np.ravel(identities), np.ravel(which), strict=True):
            if int(identity) not in self._markers.ids:
                continue
            # Scaling keeps pixel edges, not centres, in place: x' + 0.5 = scale (x + 0.5).
            places = (quad.reshape(4, 2) + 0.5) / scale - 0.5 + origin
            if way == 1:
                # A mirror swaps left and right, also of the marker's corners.
                places = np.column_stack([width - 1 - places[:, 0], places[:, 1]])[[1, 0, 3, 2]]
            quads[way].append(places)
            index[way].append(self._markers.ids.index(int(identity)))
        straight, turned = (
            pages_of(np.array(found, float).reshape(-1, 4, 2), ids, self._corners_mm)
            for found, ids in zip(quads, index, strict=True)
        )
        moved = None if before is None else moved_page(np.array(quads[0]), index[0], self._corners_mm, before)
        return straight if moved is None else [*straight, moved], turned

    def _marker_px(self, page: Array) -> float:
        first = cv2.perspectiveTransform(self._corners_mm[:1].reshape(-1, 1, 2), page).reshape(4, 2)
        return float(np.linalg.norm(first[1] - first[0]))


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
