"""The chance that an older film follows a challenge, and what is wrong with the picture of a call.

In a call the part of the window in which one person is shown, the *tile*, may be too small or show several people
(`TileWatch`).

Convention: chances from 0 to 1; the pictures of a tile come without their surroundings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Reason
from moireid.verifier.session.faces import FaceFinder
from moireid_studio.challenge.challenge import FACE, Place, allowed, moved, sideways
from moireid_studio.challenge.clock import HERE, Pace


def likeliest_chance(pace: Pace = HERE) -> float:
    """Chance of the likeliest challenge, which a thief of the badge may film once, and play and pause later.

    In a call a forger may pause an older film until a prompt is read aloud, so times count for nothing there.
    Source: the greatest over all challenges, counted over places on the grid and moves to a side, over the chance of a
        challenge that is not drawn again for too few of these.
    """
    whole, most, moves = 0.0, 0.0, pace.moves
    for face_at in range(1, moves):
        # For each place and number of moves to a side: the sum of the probabilities, and the greatest.
        sums = {((0, 0, 0), 0): (1.0, 1.0)}
        for k in range(moves):
            following: dict[tuple[Place, int], tuple[float, float]] = {}
            for (place, aside), (every, one) in sums.items():
                ways = [FACE] if k == face_at else allowed(place)
                for move in ways:
                    there = moved(place, move), min(aside + sideways(move), pace.sideways)
                    before = following.get(there, (0.0, 0.0))
                    following[there] = before[0] + every / len(ways), max(before[1], one / len(ways))
            sums = following
        enough = [both for (_, aside), both in sums.items() if aside == pace.sideways]
        whole += sum(every for every, _ in enough) / (moves - 1)
        most = max(most, *(one / (moves - 1) for _, one in enough))
    return most / whole


#: Least width of a tile, px; those of `moireid lab bench live` have 960.
LEAST_WIDTH_PX = 480
#: A picture that repeats the last one is left out for so long after it.  A call whose picture was lost shows the one
#: before again: taken for a badge at rest, it would make the next one look like a jump.  No longer than that of two
#: pictures, because a call in which nothing moves must still be seen to rest.
REPEATS_S = 0.08
#: Time between two counts of faces, s, and the share of them that may find several: a poster, or a passer-by.
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
