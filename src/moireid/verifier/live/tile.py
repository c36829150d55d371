"""What is too poor, or too much, in the picture of a call: a tile that is too small, or shows several people.

Convention: a tile is the part of a call's window in which one person is shown; its pictures come without their
surroundings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Reason
from moireid.verifier.session.faces import FaceFinder

#: Least width of a tile, px.  `benchmarks/call_replays.py --widths` prints verdicts by width.
LEAST_WIDTH_PX = 480
#: A picture that repeats the last one is left out for so long after it.  A call whose picture was lost shows the one
#: before again: taken for a badge at rest, it would make the next one look like a jump.  No longer than that of two
#: pictures, because a call in which nothing moves must still be seen to rest.
REPEATS_S = 0.08
#: Time between two counts of faces, s, and the share of them that may find several: a poster, or somebody who passes.
COUNT_S, MOST_CROWDED = 2.0, 0.25


class TileWatch:
    """Looks at a tile now and then.  Raises: MissingExtraError where dlib is not installed."""

    def __init__(self) -> None:
        self._finder = FaceFinder()
        self._due_s, self._taken_s = -np.inf, -np.inf
        self._last: NDArray[np.uint8] | None = None
        self.width_px, self.looks, self.crowded = 0, 0, 0
        #: Whether the tile left its place, or changed its size; another person may be in it since.
        self.moved = False

    def repeated(self, luma: NDArray[np.uint8], arrival_s: float) -> bool:
        """Whether a picture only repeats the one before, as where one was lost on its way."""
        if self._last is not None and arrival_s - self._taken_s < REPEATS_S and np.array_equal(luma, self._last):
            return True
        self._last, self._taken_s = luma, arrival_s
        return False

    def push(self, frame: Frame) -> None:
        """Take a frame."""
        self.width_px = frame.luma.shape[1]
        if frame.time_s >= self._due_s:
            self._due_s = frame.time_s + COUNT_S
            self.looks += 1
            self.crowded += self._count(frame.luma) > 1

    def _count(self, luma: NDArray[np.uint8]) -> int:
        return len(self._finder.all(luma))

    def reasons(self) -> tuple[Reason, ...]:
        """Findings on what was seen so far; none where all is well."""
        found: tuple[Reason, ...] = ()
        if self.looks and self.width_px < LEAST_WIDTH_PX:
            text = f"The tile is {self.width_px} px wide; enlarge it to {LEAST_WIDTH_PX} px or more, or pin the person."
            found += (Reason("tile", "undecided", float(self.width_px), float(LEAST_WIDTH_PX), "px", text),)
        if self.moved:
            text = "The tile moved or changed its size. Pin the person, choose the tile again, and begin again."
            found += (Reason("tile_moved", "undecided", 1.0, 0.0, "moves", text),)
        share = self.crowded / max(self.looks, 1)
        if share > MOST_CROWDED:
            text = (
                f"More than one face was in the tile at {share:.0%} of the looks. Whose hand holds the badge is not "
                "known then; ask that one person alone is seen, and begin again."
            )
            found += (Reason("faces", "undecided", share, MOST_CROWDED, "share", text),)
        return found
