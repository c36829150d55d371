"""Finding badges: the four markers of a page in a frame, and those of each page where there are several.

The whole frame is searched until a badge is found; then only its neighbourhood, because a full-frame search costs
ten times the rest of the work.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers
from moireid.verifier.pages import pages_of

#: Share of its own size that the badge may move between two frames and still be found in its neighbourhood.
NEIGHBOURHOOD = 0.5
#: Finer pictures of the neighbourhood help small markers: below this size in pixels it is enlarged twofold.
ENLARGE_BELOW_PX = 24.0
#: Every so many searches look for faded print; once it is found, it is followed without a search.
FAINT_EVERY = 3
#: A glance looks for markers of this side with one threshold, of this window and so many counts, above most noise,
#: whose outlines are what a search spends its time on.
GLANCE_PX, GLANCE_WINDOW_PX, GLANCE_COUNTS = 14.0, 9, 18.0


class MarkerFinder:
    """Finds the markers of one page, frame after frame."""

    def __init__(self, markers: Markers) -> None:
        parameters = cv2.aruco.DetectorParameters()
        # OpenCV's default refuses a perimeter under 3 % of the picture's width: 14 px a side at 1080p.
        parameters.minMarkerPerimeterRate = 0.01
        # Corners are refined against the whole page afterwards (`register`), so none is refined here.
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        # The default of 0.6 corrects no bit of DICT_4X4_50, whose words lie at least 4 bits apart.  One bit is
        # allowed: the four ids and their places on the page, checked below, leave no room for a chance find.
        parameters.errorCorrectionRate = 1.0
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
        self._detector = cv2.aruco.ArucoDetector(dictionary, parameters)
        # Faded print differs from its surroundings by less than OpenCV's default of 7 counts; asked for always, a
        # lower figure would make every search find more to look at.
        faint = cv2.aruco.DetectorParameters()
        faint.minMarkerPerimeterRate, faint.errorCorrectionRate = 0.01, 1.0
        faint.cornerRefinementMethod, faint.adaptiveThreshConstant = cv2.aruco.CORNER_REFINE_NONE, 2.0
        self._faint = cv2.aruco.ArucoDetector(dictionary, faint)
        coarse = cv2.aruco.DetectorParameters()
        coarse.adaptiveThreshConstant, coarse.errorCorrectionRate = GLANCE_COUNTS, 1.0
        coarse.adaptiveThreshWinSizeMin = coarse.adaptiveThreshWinSizeMax = GLANCE_WINDOW_PX
        coarse.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        self._coarse, self._dictionary = coarse, dictionary
        self._searches = 0
        self._markers = markers
        self._corners_mm = marker_corners_mm(markers)
        self._last: NDArray[np.float64] | None = None
        #: The last two frames in which the badge was, with their homographies.
        self._course: list[tuple[int, NDArray[np.float64]]] = []

    def find(self, luma: NDArray[np.uint8]) -> NDArray[np.float64] | None:
        """Homography page mm -> image px from the markers found, or None where fewer than two are.

        Convention: image px of the centre of the top left pixel are (0, 0); returns (3, 3) with h33 = 1.
        """
        found = self.pages_near(luma) or self.pages(luma)
        return found[0] if found else None

    def pages(self, luma: NDArray[np.uint8]) -> list[NDArray[np.float64]]:
        """Homographies of all pages in the frame, the largest first.  Convention: as `find`."""
        return self._find_in(luma, (0, 0, luma.shape[1], luma.shape[0]))

    def pages_near(self, luma: NDArray[np.uint8]) -> list[NDArray[np.float64]]:
        """As `pages`, in the neighbourhood of the page's place in the frame before; [] where it was not there."""
        return self._find_in(luma, self._neighbourhood(luma.shape)) if self._last is not None else []

    def glance(self, luma: NDArray[np.uint8]) -> list[NDArray[np.float64]]:
        """As `pages`, but for clear markers of `GLANCE_PX` and more, at a small part of the cost."""
        # OpenCV takes the least perimeter as a share of the picture's longer side.
        self._coarse.minMarkerPerimeterRate = 4 * GLANCE_PX / max(luma.shape)
        return self._found_by(cv2.aruco.ArucoDetector(self._dictionary, self._coarse), luma, 1.0, (0, 0))

    def expected(self, frame: int) -> NDArray[np.float64] | None:
        """The homography of a frame if the badge moves on as it did, None where it was not in the frame before.

        Source: the picture's last motion, page to page, once more.
        """
        if self._last is None:
            return None
        (before, first), (after, second) = (self._course * 2)[-2:]
        if frame - after != 1 or after - before != 1:
            return second
        moved = second @ np.linalg.inv(first) @ second
        return np.asarray(moved / moved[2, 2])

    def follow(self, homography: NDArray[np.float64] | None, frame: int) -> None:
        """Take over the refined homography of this frame as the place to look next; None: the badge was not there."""
        self._last = homography
        if homography is not None:
            self._course = [*self._course[-1:], (frame, homography)]

    def _neighbourhood(self, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
        assert self._last is not None
        corners = cv2.perspectiveTransform(self._corners_mm.reshape(-1, 1, 2), self._last).reshape(-1, 2)
        low, high = corners.min(axis=0), corners.max(axis=0)
        grow = NEIGHBOURHOOD * (high - low).max()
        x0, y0 = np.maximum(np.floor(low - grow), 0).astype(int)
        x1, y1 = np.minimum(np.ceil(high + grow), (shape[1], shape[0])).astype(int)
        return int(x0), int(y0), int(x1), int(y1)

    def _find_in(self, luma: NDArray[np.uint8], box: tuple[int, int, int, int]) -> list[NDArray[np.float64]]:
        x0, y0, x1, y1 = box
        if x1 - x0 < 16 or y1 - y0 < 16:
            return []
        crop = np.ascontiguousarray(luma[y0:y1, x0:x1])
        scale = 1.0
        if self._last is not None and self._marker_px() < ENLARGE_BELOW_PX and crop.size < 10**6:
            scale = 2.0
            crop = np.asarray(cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC))
        self._searches += 1
        detector = self._faint if self._searches % FAINT_EVERY == 0 else self._detector
        return self._found_by(detector, crop, scale, (x0, y0))

    def _found_by(
        self, detector: cv2.aruco.ArucoDetector, picture: NDArray[np.uint8], scale: float, origin: tuple[int, int]
    ) -> list[NDArray[np.float64]]:
        """Pages in a part of the frame that begins at `origin` and was scaled, told in the frame's own px."""
        corners, identities, _ = detector.detectMarkers(picture)
        if identities is None:
            return []
        quads, index = [], []
        for quad, identity in zip(corners, np.ravel(identities), strict=True):
            if int(identity) in self._markers.ids:
                # Scaling keeps pixel edges, not centres, in place: x' + 0.5 = scale (x + 0.5).
                quads.append((quad.reshape(4, 2) + 0.5) / scale - 0.5 + origin)
                index.append(self._markers.ids.index(int(identity)))
        return pages_of(np.array(quads, float).reshape(-1, 4, 2), index, self._corners_mm)

    def _marker_px(self) -> float:
        assert self._last is not None
        first = cv2.perspectiveTransform(self._corners_mm[:1].reshape(-1, 1, 2), self._last).reshape(4, 2)
        return float(np.linalg.norm(first[1] - first[0]))


def marker_corners_mm(markers: Markers) -> NDArray[np.float64]:
    """Corners of the four black squares, (4, 4, 2): marker; top left, top right, bottom right, bottom left; x, y."""
    half = markers.size_mm / 2
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return np.asarray(markers.centers_mm)[:, None, :] + square
