"""Markers moved within a finished picture of the badge, in picture pixels.

Convention: an edit takes the frame's number, its picture (height, width) uint8 and the homography page mm -> px of the
middle row, and gives the picture back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]


@dataclass(frozen=True)
class ShiftedMarkers:
    """Markers moved aside by `shift_px`, two each way, in some frames: their poses look misregistered there."""

    badge: Badge
    shift_px: float
    within: Callable[[int], bool]

    def __call__(self, frame: int, luma: Luma, homography: Array) -> Luma:
        """The picture with two markers moved apart."""
        if not self.within(frame):
            return luma
        out = luma.copy()
        # With a part of the white around it, and no fringes.
        reach = 0.65 * self.badge.squares.size_mm
        for number, (x, y) in enumerate(self.badge.squares.centers_mm):
            square = np.array(
                [[[x + a * reach, y + b * reach]] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], float
            )
            left, top, width, height = cv2.boundingRect(
                np.round(cv2.perspectiveTransform(square, homography)).astype(np.int32)
            )
            # A marker at the picture's edge is moved as far as it is seen; a negative index would count from the end.
            seen = slice(max(top, 0), max(top + height, 0)), slice(max(left, 0), max(left + width, 0))
            part = luma[seen]
            if not part.size:
                continue
            moved = np.array([[1, 0, self.shift_px if number in (0, 2) else -self.shift_px], [0, 1, 0]], float)
            out[seen] = cv2.warpAffine(part, moved, (part.shape[1], part.shape[0]), borderMode=cv2.BORDER_REPLICATE)
        return out
