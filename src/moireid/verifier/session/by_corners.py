"""A badge that lost its markers: one badge in view, followed from corners that a person gave (`own_page`).

Policy: nothing that is followed so is accepted, as the page is only where somebody says.  It is rejected where
correlation, gain or residual fail, whose limits widen with the error bars of pose and page.  The likelihood ratio alone
rejects nothing: its figures are those of pages that markers hold, and rows that are read a millimetre beside their
place move apart.  Nor does anything reject where the film does not tell its focal length: on a straight path the
page's warp, its tilts and the focal length share one valley.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.camera.fit import CameraFit
from moireid.verifier.camera.self_calibration import guessed_focal_px
from moireid.verifier.corners import Corners
from moireid.verifier.limits import FOCAL_PRIOR_SD_LOG
from moireid.verifier.motion.judge import Invariant
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.tracking.badge_tracker import BadgeTracker
from moireid.verifier.tracking.own_page import OwnPage
from moireid.verifier.video import Frame

Array = NDArray[np.float64]

#: A focal length so many standard deviations from its prior is that of a film that does not tell it: true films on a
#: straight path came out at 3.5 and 4.3, all others within 2.5.
UNTOLD_SDS = 3.0


def told_by_hand(invariant: Invariant, *, focal_told: bool) -> Invariant:
    """What may be said of a page that was followed from corners; focal_told: as `focal_is_told`."""
    lifted = {"likelihood"} if focal_told else {reason.code for reason in invariant.reasons}
    reasons = tuple(
        replace(reason, level="undecided") if reason.level == "fail" and reason.code in lifted else reason
        for reason in invariant.reasons
    )
    return replace(invariant, verdict=worst(list(reasons)), reasons=reasons)


def focal_is_told(camera: CameraFit, image_px: tuple[int, int]) -> bool:
    """Whether a film's focal length was given, or found where focal lengths are."""
    away = abs(math.log(camera.focal_px / guessed_focal_px(image_px)))
    return camera.focal_given or away <= UNTOLD_SDS * FOCAL_PRIOR_SD_LOG


def never_accepted(invariant: Invariant, tracked: int, *, focal_told: bool) -> Invariant:
    """The invariant of a whole film that was followed so, with the finding that says so."""
    text = (
        f"In {tracked} frames the badge was followed from corners that a person gave, not by its markers; what is "
        "followed so can be rejected and is never accepted."
    )
    if not focal_told:
        text += " The film does not tell its focal length, so it is not rejected either; give it with --focal-px."
    reason = Reason("corners", "undecided", float(tracked), None, "frames", text)
    told = told_by_hand(invariant, focal_told=focal_told)
    reasons = (*told.reasons, reason)
    return replace(told, verdict=worst(list(reasons)), reasons=reasons)


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
