"""When something was so: told frame by frame, kept as intervals."""

from __future__ import annotations

from dataclasses import dataclass, field

from moireid.verifier.reasons import json_number

#: Some frames that motion smeared, in which the badge is lost, or that a network brought late, end no interval.
BREAK_S = 0.4
#: Intervals that a report names, the longest first.
MOST_NAMED = 20


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
