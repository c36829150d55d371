"""When a frame was taken, and how fast a challenge goes.

A network delivers frames unevenly, so their arrival times are imprecise; but a sender may lie.  So one offset, found in
the first second, moves each claimed time onto our clock.  The result must be shortly before the arrival.  Whatever a
sender claims, a frame's time is wrong by at most `SLACK_S`, and never later than its arrival.

A challenge is before this device's own camera, or in a call, where each answer comes later: the prompt is read aloud,
the words are transmitted, the person reacts, and the picture is transmitted back.  How long that takes differs from
call to call, so the next prompt comes only after the last one was followed.  A forger can then pause an older film
until the words come.  So no answer's time counts for anything there, and more moves replace the times (`chance.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

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

        Parameters
        ----------
        claimed_s
            By the sender's clock, of any origin.
        arrival_s
            By ours, rising.

        Notes
        -----
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


class StreamClock(BoundedClock):
    """Times of frames as a film or a stream gives them, where no prompts can be answered.

    Such pictures come faster than they were taken, or in pieces of some seconds, so that their arrival means nothing.
    """

    checked = False

    def place(self, claimed_s: float, arrival_s: float) -> float | None:
        """The claimed time, s; None where it is none."""
        if math.isfinite(claimed_s):
            self.taken += 1
            return claimed_s
        self.late += 1
        return None


#: A move begins at earliest and at latest this long after its prompt, and ends within `DONE_S`.  People need 0.2 s to
#: react to what they see and half a second to read a word; the rest is for the delay of the picture.
SOONEST_S, LATEST_S, DONE_S = 0.15, 2.0, 3.0
#: Time between two prompts, drawn at random between these: the least is enough to finish and rest.
LEAST_GAP_S, MOST_GAP_S = 3.6, 6.4
#: Moves of a challenge, one of them across the face, and the least number that go sideways: without these, the fringes
#: of most badges hardly move and cannot be judged.
MOVES, SIDEWAYS = 6, 2

#: In a call: time for the one who asks to read a prompt aloud, and the most delay of the call, there and back.
READ_S, DELAY_S = 2.0, 2.0
CALL_LATEST_S, CALL_DONE_S = LATEST_S + READ_S + DELAY_S, DONE_S + READ_S + DELAY_S
#: In a call: the time from a followed prompt to the next.  The least is enough to come to rest.
LEAST_CALL_GAP_S, MOST_CALL_GAP_S = 1.6, 3.2
#: In a call: more moves, as times count for nothing; and more of them sideways, as the badge rests for longer between.
CALL_MOVES, CALL_SIDEWAYS = 9, 4
#: In a call the latest answer may come later than the soonest by this time: reading aloud differs by 1 s, reactions by
#: 1.5 s, and the call's delay may jump by half a second.
SPREAD_S = 3.0
#: A step's speed is measured over at least the time of a camera's frame; in a call over that of three, as two of them
#: may be lost.
FRAME_S, CALL_FRAME_S = 1 / 24, 3 / 24
#: In a call pictures may come this much later than their times say: who asks sends them, and gains nothing by a lie.
CALL_SLACK_S = 2.0
#: In a call a prompt waits for so long until the badge rests.
REST_WAIT_S = 30.0


@dataclass(frozen=True)
class Pace:
    """How many moves, and how many sideways at least; by when an answer begins and is done (s after its prompt); and
    what comes between two prompts.  frame_s: least time over which a step's speed is measured.

    in_call: the next prompt waits for the answer to the last one, and until the badge rests; gaps count from then.
    """

    moves: int
    sideways: int
    latest_s: float
    done_s: float
    gap_s: tuple[float, float]
    frame_s: float = FRAME_S
    in_call: bool = False


HERE = Pace(MOVES, SIDEWAYS, LATEST_S, DONE_S, (LEAST_GAP_S, MOST_GAP_S))
CALL = Pace(
    CALL_MOVES,
    CALL_SIDEWAYS,
    CALL_LATEST_S,
    CALL_DONE_S,
    (LEAST_CALL_GAP_S, MOST_CALL_GAP_S),
    CALL_FRAME_S,
    in_call=True,
)
