"""Where one badge was: what is remembered of it from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Seen:
    """A frame in which the badge was: its number, its time, and the page's homography."""

    frame: int
    time_s: float
    page: Array


@dataclass
class Course:
    """The first frame in which the badge was seen, and the last two; None: nowhere yet.

    Convention: homographies page mm -> px, h33 = 1.
    """

    first: Seen | None = None
    before: Seen | None = None
    last: Seen | None = None
    #: Whether it was seen in the frame before.
    followed: bool = False

    def follow(self, seen: Seen) -> None:
        """It was seen."""
        self.before, self.last, self.followed = self.last, seen, True
        self.first = self.first or seen

    def lose(self) -> None:
        """It is not in this frame: do not look for it where it was."""
        self.followed = False

    def expected(self, frame: int) -> Array | None:
        """The homography of a frame if the badge moves on as it did, None where it was not in the frame before.

        Source: the picture's last motion, page to page, once more.
        """
        if not self.followed or self.last is None:
            return None
        last, before = self.last, self.before
        if before is None or frame - last.frame != 1 or last.frame - before.frame != 1:
            return last.page
        moved = last.page @ np.linalg.inv(before.page) @ last.page
        return np.asarray(moved / moved[2, 2])
