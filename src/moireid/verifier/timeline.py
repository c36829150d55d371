"""When something was so: times of frames, made to rise, and intervals of them.

The times of a film start anew where recordings were joined: two pieces of a transport stream, say.  Nobody knows how
much later the second piece was taken, so nothing may be smoothed or unwrapped across the joint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from moireid.errors import SpecError
from moireid.verifier.reasons import Reason, json_number

#: Some frames that motion smeared, in which the badge is lost, or that a network brought late, end no interval.
BREAK_S = 0.4
#: A time that lies farther back than this starts anew.  Less is a time badly told, by a frame or two: such a frame
#: counts as taken with the one before.
RESTART_S = 0.1
#: After a restart time goes on so much later: no step that follows a badge, smooths its course or unwraps its phase
#: reaches over so long (a test holds it).
JOINT_S = 0.5
#: Intervals that a report names, the longest first.
MOST_NAMED = 20


class FilmTime:
    """The times of a film's frames, made to rise.

    Convention: the film's own times until one lies more than `RESTART_S` back; from there on they are moved by one
    offset, so that the frame comes `JOINT_S` after the one before.  Times may repeat, and then repeat here.
    """

    def __init__(self) -> None:
        self._latest_s, self._offset_s = -math.inf, 0.0
        self.restarts = 0  #: How often the times started anew.

    def place(self, time_s: float) -> tuple[float, bool]:
        """A frame's time in what rises, s, and whether time starts anew with it.

        Raises: SpecError where the time is not finite.
        """
        if not math.isfinite(time_s):
            raise SpecError(f"a frame has the time {time_s}; give each frame its time in seconds, which is finite")
        restarted = time_s < self._latest_s - RESTART_S
        if restarted:
            self._offset_s += self._latest_s + JOINT_S - time_s
            self._latest_s, self.restarts = time_s, self.restarts + 1
        self._latest_s = max(self._latest_s, time_s)
        return self._latest_s + self._offset_s, restarted


def restart_findings(restarts: int, unjudged: int, most: int) -> tuple[Reason, ...]:
    """Findings on a film whose times started anew; none where they did not.

    Parameters: unjudged: frames that show the badge and lie in pieces too short to be judged; most: so many may.
    """
    if not restarts:
        return ()
    again = "once" if restarts == 1 else f"{restarts} times"
    text = (
        f"The film's times start anew {again}; nothing is followed across such a joint, and this report's times go on "
        f"{JOINT_S:g} s after it."
    )
    found = (Reason("times", "note", float(restarts), None, "restarts", text),)
    if unjudged < most:
        return found
    text = f"{unjudged} frames after it show the badge and are too few to be judged; film longer, or verify the pieces."
    return (*found, Reason("piece", "undecided", float(unjudged), float(most), "frames", text))


@dataclass
class Spans:
    """Times that are told frame by frame, kept as intervals: (first, last) of each, s."""

    spans: list[list[float]] = field(default_factory=list)

    def add(self, time_s: float) -> None:
        """One more frame; it lengthens the last interval unless there was a break."""
        if self.spans and time_s - self.spans[-1][1] <= BREAK_S:
            self.spans[-1][1] = time_s
        else:
            self.spans.append([time_s, time_s])

    @property
    def longest(self) -> tuple[float, float] | None:
        """The longest interval; None where there is none."""
        one = max(self.spans, key=lambda span: span[1] - span[0], default=None)
        return (one[0], one[1]) if one else None

    @property
    def total_s(self) -> float:
        """All intervals together."""
        return sum(end - start for start, end in self.spans)

    def to_json(self) -> list[list[float]]:
        """The longest `MOST_NAMED`, in order of time."""
        longest = sorted(self.spans, key=lambda span: span[0] - span[1])[:MOST_NAMED]
        return [[json_number(start), json_number(end)] for start, end in sorted(longest)]
