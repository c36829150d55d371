"""Markers moved within a finished picture of the badge, so that their poses look misregistered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge

Luma = NDArray[np.uint8]
#: Of half a marker's side: with a part of the white around it, and no fringes.
REACH = 1.3


@dataclass(frozen=True)
class ShiftedMarkers:
    """Markers moved aside by `shift_px`, two each way, in the frames of which `within` is true."""

    badge: Badge
    shift_px: float
    within: Callable[[int], bool]

    def __call__(self, frame: int, luma: Luma, homography: NDArray[np.float64]) -> Luma:
        """The picture with two markers moved apart; homography: page mm to px, of its middle row."""
        if not self.within(frame):
            return luma
        out, reach = luma.copy(), REACH * self.badge.squares.size_mm / 2
        for number, centre in enumerate(self.badge.squares.centers_mm):
            square = np.array(centre) + reach * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
            seen = np.rint(cv2.perspectiveTransform(square[None], homography)[0]).astype(int)
            # A marker at the picture's edge is moved as far as it is seen; a negative index would count from the end.
            (left, top), (right, bottom) = np.maximum(seen.min(axis=0), 0), np.maximum(seen.max(axis=0) + 1, 0)
            part = luma[top:bottom, left:right]
            if part.size:
                moved = np.array([[1, 0, self.shift_px if number in (0, 2) else -self.shift_px], [0, 1, 0]], float)
                size = part.shape[::-1]
                out[top:bottom, left:right] = cv2.warpAffine(part, moved, size, borderMode=cv2.BORDER_REPLICATE)
        return out
