"""The view of a film whose badge lost its markers: one badge, followed by corners that a person gave (`own_page`)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.corners import Corners
from moireid.verifier.own_page import OwnPage
from moireid.verifier.track import BadgeTracker
from moireid.verifier.video import Frame

Array = NDArray[np.float64]


class ByCorners:
    """Stands where `in_view.BadgesInView` does; `trackers` has the one badge."""

    def __init__(self, badge: Badge, corners: Corners) -> None:
        """Raises: SpecError where a row of the badge is too small to be read."""
        self.trackers, self.given_up = [BadgeTracker(badge)], list[BadgeTracker]()
        self._badge, self._corners = badge, dict(corners)
        # Corners go by their names, so in a mirrored film they go round the other way.
        self._mirrored = _signed_area(self._corners[min(self._corners)]) < 0
        self._page: OwnPage | None = None

    def push(self, frame: Frame) -> bool:
        """Take in one frame; whether the badge was seen in it."""
        luma = np.ascontiguousarray(frame.luma[:, ::-1]) if self._mirrored else frame.luma
        if self._page is None:
            self._page = OwnPage(self._badge, self._turned(luma.shape[1]))
        found = self._page.find(frame.index, luma)
        return self.trackers[0].take_in(frame, luma, found, mirrored=self._mirrored)

    def _turned(self, width_px: int) -> Corners:
        """Corners in the film turned back."""
        if not self._mirrored:
            return self._corners
        return {frame: places * [-1.0, 1.0] + [width_px - 1, 0.0] for frame, places in self._corners.items()}


def _signed_area(corners: Array) -> float:
    """Positive where corners go clockwise as seen."""
    return float(cv2.contourArea(corners.astype(np.float32), oriented=True))
