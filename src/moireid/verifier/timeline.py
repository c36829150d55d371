"""Times of frames on a clock that never goes back, and intervals of time.

The times of a film restart where recordings were joined, for example two pieces of a transport stream.  How much later
the second piece was recorded is unknown, so nothing may be smoothed or unwrapped across the joint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from moireid.errors import SpecError
from moireid.verifier.reasons import Reason, json_number

#: Shorter breaks do not end an interval: some frames are smeared by motion, or arrive late from a network.
BREAK_S = 0.4
#: A step back by more than this is a restart.  A smaller one is a timestamp that is wrong by a frame or two: such a
#: frame gets the time of the frame before.
RESTART_S = 0.1
#: Gap in time that is put in at a restart.  Tracking, smoothing and unwrapping never reach across such a gap (a test
#: checks it).
JOINT_S = 0.5
#: A report lists at most this many intervals, the longest ones.
MOST_NAMED = 20

Span = tuple[float, float]  #: First and last time, s.


class FilmTime:
    """The times of a film's frames on a clock that never goes back.

    Convention: times are those of the file until one steps back by more than `RESTART_S`; from there on an offset is
        added, so that this frame comes `JOINT_S` after the last one.  Repeated times stay repeated.
    """

    def __init__(self) -> None:
        self._latest_s, self._offset_s = -math.inf, 0.0
        self.restarts = 0  #: How often the times started anew.

    def place(self, time_s: float) -> tuple[float, bool]:
        """The frame's time on this clock, s, and whether the times restart with it.

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
    """Findings on a film whose times restart; empty if they do not.

    Parameters: unjudged: frames that show the badge in pieces too short to be judged; most: how many are allowed.
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
    """Times of frames, kept as intervals: (first, last) of each, s."""

    spans: list[list[float]] = field(default_factory=list)

    def add(self, time_s: float) -> None:
        """Add a frame; it extends the last interval unless there was a break."""
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
        """Total length of all intervals."""
        return sum(end - start for start, end in self.spans)

    def to_json(self) -> list[list[float]]:
        """The longest `MOST_NAMED`, in order of time."""
        longest = sorted(self.spans, key=lambda span: span[0] - span[1])[:MOST_NAMED]
        return [[json_number(start), json_number(end)] for start, end in sorted(longest)]


def outside(span: Span, spans: Sequence[Span]) -> tuple[Span, ...]:
    """The parts of a span that are in none of the others."""
    left: list[Span] = [span]
    for start, end in spans:
        left = [part for one in left for part in ((one[0], min(one[1], start)), (max(one[0], end), one[1]))]
        left = [part for part in left if part[1] > part[0]]
    return tuple(left)


def within(span: Span, spans: Sequence[Span]) -> tuple[Span, ...]:
    """The parts of a span that are in any of the others."""
    parts = [(max(span[0], start), min(span[1], end)) for start, end in sorted(spans)]
    return tuple(part for part in parts if part[1] > part[0])
