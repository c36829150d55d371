"""When a frame was taken: by the sender's clock, checked against our own.

A network delivers frames unevenly, so their arrival times are imprecise; but a sender may lie.  So one offset, found in
the first second, moves each claimed time onto our clock.  The result must lie shortly before the arrival. Whatever a
sender claims, a frame's time is wrong by at most `SLACK_S`, and never later than its arrival.
"""

from __future__ import annotations

import math

#: A frame is left out if its delay exceeds that of the fastest frame of the first second by more than this.
SLACK_S = 0.5
#: The offset is estimated from the frames of this first time.
SETTLE_S = 1.0
#: If more than this share of the frames is left out, the times of a session are not trusted.
MOST_LATE = 0.2


class BoundedClock:
    """Times of frames on our own clock.

    late, taken: numbers of frames left out and used since the offset was fixed.
    """

    #: Whether the times are checked against our own clock.
    checked = True

    def __init__(self, slack_s: float = SLACK_S) -> None:
        """slack_s: how much later than the fastest frame one may come."""
        self._slack_s = slack_s
        self._first_s: float | None = None
        self._offset_s, self._last_s = math.inf, -math.inf
        self.late = self.taken = 0

    def place(self, claimed_s: float, arrival_s: float) -> float | None:
        """A frame's time on our clock, s; None if it is left out.

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
        # A claimed time after the arrival is set to the arrival.
        time_s = min(claimed_s + self._offset_s, arrival_s)
        if arrival_s - time_s > self._slack_s or time_s <= self._last_s:
            self.late += 1
            return None
        self.taken += 1
        self._last_s = time_s
        return time_s

    @property
    def late_share(self) -> float:
        """Share of the frames that were left out."""
        return self.late / max(self.late + self.taken, 1)


class StreamClock:
    """Times of frames as a film or a stream says them, where nobody answers prompts.

    Such pictures come faster than they were taken, or in pieces of some seconds, so that their arrival tells nothing.
    """

    checked = False

    def __init__(self) -> None:
        self.late = self.taken = 0

    def place(self, claimed_s: float, arrival_s: float) -> float | None:
        """The claimed time, s; None where it is none.  Parameters: as `BoundedClock.place`."""
        if not math.isfinite(claimed_s):
            self.late += 1
            return None
        self.taken += 1
        return claimed_s

    @property
    def late_share(self) -> float:
        """Share of the frames that have no time."""
        return self.late / max(self.late + self.taken, 1)
