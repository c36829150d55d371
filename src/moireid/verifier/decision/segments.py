"""The verdict by time: the motion invariant in each few seconds of a film.

Convention: a segment is judged by the same limits as a film; one with little motion is inconclusive, which does not
    count against the film.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from moireid.verifier.decision.judge import judge_signals
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.limits import SEGMENT_S, WINDOW_FRAMES
from moireid.verifier.reasons import Verdict, json_number


@dataclass(frozen=True)
class Segment:
    """Some seconds of a film: start and end, frames that show the badge, and their verdict."""

    start_s: float
    end_s: float
    tracked: int
    verdict: Verdict
    correlation: float | None = None
    gain_ratio: float | None = None
    excitation_rad: float | None = None

    def to_json(self) -> dict[str, Any]:
        """As an entry of `segments` of `verify --json`."""
        names = ("start_s", "end_s", "tracked", "verdict", "correlation", "gain_ratio", "excitation_rad")
        return {name: json_number(getattr(self, name)) for name in names}


def judge_segments(measurement: Measurement, first: int = 0, sheet: SheetGain = DESIGNED) -> tuple[Segment, ...]:
    """Segments of `SEGMENT_S`, one after another from tracked frame `first` on; sheet: as `judge.judge_signals`.

    Returns: segments with at least one tracked frame; those with less than a window of frames are inconclusive.
    """
    times = measurement.times_s
    number = np.floor((times - times[first]) / SEGMENT_S).astype(int)
    found = []
    for k in np.unique(number[first:]):
        frames = np.flatnonzero(number == k)
        start = float(times[first] + k * SEGMENT_S)
        end = float(min(start + SEGMENT_S, times[-1]))
        if len(frames) < WINDOW_FRAMES:
            found.append(Segment(start, end, len(frames), "inconclusive"))
            continue
        judged = judge_signals(tuple(signal.part(frames) for signal in measurement.gratings), sheet, whole=False)
        found.append(
            Segment(
                start, end, len(frames), judged.verdict, judged.correlation, judged.gain_ratio, judged.excitation_rad
            )
        )
    return tuple(found)
