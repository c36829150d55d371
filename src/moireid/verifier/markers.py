"""Finding the badge: the four markers of the page in a frame.

The whole frame is searched until the badge is found; then only its neighbourhood, because a full-frame search costs
ten times the rest of the work.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers

#: Share of its own size that the badge may move between two frames and still be found in its neighbourhood.
NEIGHBOURHOOD = 0.5
#: Finer pictures of the neighbourhood help small markers: below this size in pixels it is enlarged twofold.
ENLARGE_BELOW_PX = 24.0
#: Every so many searches look for faded print; once it is found, it is followed without a search.
FAINT_EVERY = 3


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
        if self._last is not None:
            found = self._find_in(luma, self._neighbourhood(luma.shape))
            if found is not None:
                return found
        return self._find_in(luma, (0, 0, luma.shape[1], luma.shape[0]))

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

    def _find_in(self, luma: NDArray[np.uint8], box: tuple[int, int, int, int]) -> NDArray[np.float64] | None:
        x0, y0, x1, y1 = box
        if x1 - x0 < 16 or y1 - y0 < 16:
            return None
        crop = np.ascontiguousarray(luma[y0:y1, x0:x1])
        scale = 1.0
        if self._last is not None and self._marker_px() < ENLARGE_BELOW_PX and crop.size < 10**6:
            scale = 2.0
            crop = np.asarray(cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC))
        self._searches += 1
        detector = self._faint if self._searches % FAINT_EVERY == 0 else self._detector
        corners, identities, _ = detector.detectMarkers(crop)
        if identities is None:
            return None
        image, page = [], []
        for quad, identity in zip(corners, np.ravel(identities), strict=True):
            if int(identity) in self._markers.ids:
                # Enlarging keeps pixel edges, not centres, in place: x' + 0.5 = scale (x + 0.5).
                image.append((quad.reshape(4, 2) + 0.5) / scale - 0.5 + (x0, y0))
                page.append(self._corners_mm[self._markers.ids.index(int(identity))])
        if len(image) < 2:
            return None
        return fit_homography(np.concatenate(page), np.concatenate(image))

    def _marker_px(self) -> float:
        assert self._last is not None
        first = cv2.perspectiveTransform(self._corners_mm[:1].reshape(-1, 1, 2), self._last).reshape(4, 2)
        return float(np.linalg.norm(first[1] - first[0]))


def marker_corners_mm(markers: Markers) -> NDArray[np.float64]:
    """Corners of the four black squares, (4, 4, 2): marker; top left, top right, bottom right, bottom left; x, y."""
    half = markers.size_mm / 2
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return np.asarray(markers.centers_mm)[:, None, :] + square


def fit_homography(page_mm: NDArray[np.float64], image_px: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Homography page -> image through at least four pairs (N, 2), None where they do not agree.

    A marker that was found where the others do not expect it (another badge, a misread bit) is left out by RANSAC.
    """
    side_px = np.linalg.norm(image_px[1] - image_px[0])
    homography, used = cv2.findHomography(page_mm, image_px, cv2.RANSAC, max(2.0, 0.15 * float(side_px)))
    if homography is None or used.sum() < 8 or not np.all(np.isfinite(homography)):
        return None
    return np.asarray(homography / homography[2, 2])
