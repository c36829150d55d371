"""How far a page may move from one frame in which it is seen to the next, and whether it reaches out of the picture."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import scale_px_per_mm

Array = NDArray[np.float64]
#: From one sighting to the next a page moves by at most this share of its size, and its scale by at most this ratio.
MOVED_SIZES, MOVED_SCALE = 0.5, 1.25


class PageMotion:
    """Whether two pages of one layout, homographies page mm -> px, may be one page a moment apart."""

    def __init__(self, badge: Badge) -> None:
        corners_mm, (width, height) = marker_corners_mm(badge.markers), badge.page_mm
        self._middle = corners_mm.mean(axis=(0, 1))
        self._size_mm = float(np.ptp(corners_mm.reshape(-1, 2), axis=0).max())
        self._outline_mm = np.array([[[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]])

    def is_small(self, before: Array, now: Array) -> bool:
        """Whether a page is near another, at about its size."""
        scales = scale_px_per_mm(before, self._middle), scale_px_per_mm(now, self._middle)
        apart = np.linalg.norm(self._middle_px(before) - self._middle_px(now))
        grown = max(scales) / min(scales)
        return bool(grown < MOVED_SCALE and apart < MOVED_SIZES * self._size_mm * scales[0])

    def cut_page(self, pages: Iterable[Array], before: list[Array], shape: tuple[int, ...]) -> Array | None:
        """The first page that reaches out of a picture (height, width) and was at one of the places before."""
        for page in pages:
            outline = cv2.perspectiveTransform(self._outline_mm, page)[0]
            cut = np.any(outline < 0) or np.any(outline > shape[1::-1])
            if cut and any(self.is_small(one, page) for one in before):
                return page
        return None

    def _middle_px(self, page: Array) -> Array:
        mapped = page @ (*self._middle, 1.0)
        return np.asarray(mapped[:2] / mapped[2])
