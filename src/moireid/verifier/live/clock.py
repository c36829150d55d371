"""When a frame was taken: by the sender's clock, as far as our own bears it out.

A network delivers frames unevenly, so their arrival is a poor clock; but a sender may lie.  So each frame's claimed
time is moved onto our clock by one offset, found in the first second, and must then lie shortly before its arrival.
Whatever a sender claims, a frame's time is off by `SLACK_S` at most, and never later than its arrival.
"""

from __future__ import annotations

import math

#: A frame that was longer on its way than this, beyond the quickest of the first second, is left out.
SLACK_S = 0.5
#: The offset is settled on the frames of so long.
SETTLE_S = 1.0
#: A session in which more than this share of the frames was left out tells nothing of time.
MOST_LATE = 0.2


class BoundedClock:
    """Times of frames on our own clock.

    late, taken: frames that were left out, and that were not, since the offset was settled.
    """

    def __init__(self) -> None:
        self._first_s: float | None = None
        self._offset_s, self._last_s = math.inf, -math.inf
        self.late = self.taken = 0

    def place(self, claimed_s: float, arrival_s: float) -> float | None:
        """A frame's time on our clock, s; None where it is left out.

        Parameters: claimed_s: by the sender's clock, of any origin; arrival_s: by ours, rising.
        Convention: times rise strictly; those of the first `SETTLE_S` are left out, and not counted.
        """
        if not math.isfinite(claimed_s):
            self.late += 1
            return None
        if self._first_s is None:
            self._first_s = arrival_s
        if arrival_s - self._first_s < SETTLE_S:
            self._offset_s = min(self._offset_s, arrival_s - claimed_s)
            return None
        # A claim from the future is taken back to its arrival.
        time_s = min(claimed_s + self._offset_s, arrival_s)
        if arrival_s - time_s > SLACK_S or time_s <= self._last_s:
            self.late += 1
            return None
        self.taken += 1
        self._last_s = time_s
        return time_s

    @property
    def late_share(self) -> float:
        """Share of the frames that were left out."""
        return self.late / max(self.late + self.taken, 1)
