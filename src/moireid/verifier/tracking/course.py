"""Where one badge was in the first frame and the last two frames that show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Seen:
    """A frame that shows the badge: its number, its time, and the page's homography."""

    frame: int
    time_s: float
    page: Array


@dataclass
class Course:
    """The first frame that shows the badge, and the last two; None if there is none yet.

    Convention: homographies page mm -> px, h33 = 1.
    """

    first: Seen | None = None
    before: Seen | None = None
    last: Seen | None = None
    #: Whether the last frame shows the badge.
    followed: bool = False

    def follow(self, seen: Seen) -> None:
        """Record a frame that shows the badge."""
        self.before, self.last, self.followed = self.last, seen, True
        self.first = self.first or seen

    def lose(self) -> None:
        """Record that this frame does not show the badge: its place is no longer known."""
        self.followed = False

    def expected(self, frame: int) -> Array | None:
        """The expected homography in a frame; None if the last frame did not show the badge.

        Source: the last motion between two frames, applied once more.
        """
        if not self.followed or self.last is None:
            return None
        last, before = self.last, self.before
        if before is None or frame - last.frame != 1 or last.frame - before.frame != 1:
            return last.page
        moved = last.page @ np.linalg.inv(before.page) @ last.page
        return np.asarray(moved / moved[2, 2])
