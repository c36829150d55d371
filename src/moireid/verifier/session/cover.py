"""Which seconds of a film were judged?

A verdict is about the frames in which the badge was seen, its fringes could be read, and it moved between one cut and
the next.  Two seconds with a badge prove nothing about a film of thirty.

Convention: seconds of the film's own time, as `Verifier.now_s`; each frame counts for the usual time between frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import unbroken
from moireid.verifier.camera.stretches import longest_step_s
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MIN_COVER_SHARE, MIN_PRESENT_SHARE, REST_RAD
from moireid.verifier.reasons import Level, Reason, json_number
from moireid.verifier.timeline import Span

Array = NDArray[np.float64]
#: Seconds whose pictures were lost are not covered, though motion is followed across them (`limits.MIN_GAP_S`), so
#: removing frames gains no cover.  A gap shorter than this is only jitter in the file's times.
JITTER_S = 0.05
#: Spans that a sentence names.
MOST_NAMED = 3


@dataclass(frozen=True)
class Cover:
    """Share of the film that is judged, 0 to 1; the spans (from, to) that are, s; the longest time that is not, s; the
    film's first and last time, s; the spans in which the badge was seen, s; the share of the frames in these spans that
    show it.
    """

    share: float
    spans_s: tuple[Span, ...]
    longest_gap_s: float
    film_s: Span = (0.0, 0.0)
    seen_s: tuple[Span, ...] = ()
    present_share: float = 1.0

    def to_json(self) -> dict[str, Any]:
        """As the `cover` object of `verify --json`."""
        return {
            "share": json_number(self.share),
            "spans_s": [_rounded(span) for span in self.spans_s],
            "longest_gap_s": json_number(self.longest_gap_s),
            "film_s": _rounded(self.film_s),
            "seen_s": [_rounded(span) for span in self.seen_s],
        }


def _rounded(span: Span) -> list[float]:
    return [json_number(round(time_s, 3)) for time_s in span]


def seen_spans(times_s: Array) -> tuple[Span, ...]:
    """Runs of tracked frames at these times (T,), first and last time of each, s."""
    if not len(times_s):
        return ()
    runs = unbroken(times_s, longest_step_s(times_s, JITTER_S))
    return tuple((float(times_s[run[0]]), float(times_s[run[-1]])) for run in runs)


def judged_spans(signals: Sequence[GratingSignal]) -> tuple[Span, ...]:
    """Runs of frames in which a grating's fringes were read and moved, first and last time of each, s.

    Convention: a stretch in which the badge rests does not count, as it shows nothing (`REST_RAD`).
    """
    if not signals:
        return ()
    times = signals[0].times_s
    read = np.any([_moving_frames(signal) for signal in signals], axis=0)
    if not read.any():
        return ()
    longest = longest_step_s(times, JITTER_S)
    runs = unbroken(times[read], longest)
    return tuple((float(times[read][run[0]]), float(times[read][run[-1]])) for run in runs)


def _moving_frames(signal: GratingSignal) -> NDArray[np.bool_]:
    """Mask of the frames whose phase was read and whose stretch moves, (T,)."""
    counted = np.isfinite(signal.phase_sd_rad)
    for number in np.unique(signal.stretch[counted]):
        part = counted & (signal.stretch == number)
        if signal.predicted_rad[part].std() < REST_RAD:
            counted[part] = False
    return counted


def cover_of(
    spans: Sequence[Span],
    first_s: float,
    last_s: float,
    frames: int,
    seen: Sequence[Span] = (),
    tracked: int | None = None,
) -> Cover:
    """The cover of a film by spans of its chapters.

    Parameters: first_s, last_s: times of the film's first and last frame; frames: number of them; seen: spans in which
        the badge was seen; tracked: number of frames that show it, None for all of these spans.
    """
    step = (last_s - first_s) / (frames - 1) if frames > 1 else 0.0
    joined = _joined(spans, step)
    ends = [first_s - step, *(end for _, end in joined)]
    starts = [*(start for start, _ in joined), last_s + step]
    gaps = [max(start - end - step, 0.0) for end, start in zip(ends, starts, strict=True)]
    judged = sum(end - start + step for start, end in joined)
    whole = last_s - first_s + step
    share = min(judged / whole, 1.0) if whole > 0 else 0.0
    shown = tuple(_joined(seen, step))
    held = sum(end - start + step for start, end in shown) / step if step > 0 else 0.0
    present = min(tracked / held, 1.0) if tracked is not None and held > 0 else 1.0
    return Cover(share, tuple(joined), max(gaps), (first_s, last_s), shown, present)


def _joined(spans: Sequence[Span], step_s: float) -> list[Span]:
    """The spans in order; those that overlap or are at most about a frame apart are joined."""
    joined: list[Span] = []
    for start, end in sorted(spans):
        if joined and start <= joined[-1][1] + 1.5 * step_s:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((start, end))
    return joined


def cover_findings(cover: Cover, least: float | None = None) -> tuple[Reason, ...]:
    """Whether enough of the film is judged, and whether the badge is there throughout.

    Parameters: least: share of the film, 0 to 1; None for `MIN_COVER_SHARE`.
    """
    least = MIN_COVER_SHARE if least is None else least
    if cover.present_share >= MIN_PRESENT_SHARE:
        return (_cover_finding(cover, least),)
    text = (
        f"Where the badge is seen, only {100 * cover.present_share:.0f} % of the frames show it, so what the others "
        "show is not known. Film again, in better light and with slower moves."
    )
    flicker = Reason("flicker", "undecided", cover.present_share, MIN_PRESENT_SHARE, "share", text)
    return _cover_finding(cover, least), flicker


def _cover_finding(cover: Cover, least: float) -> Reason:
    """Whether enough of the film is judged; least: share, 0 to 1."""
    level: Level = "pass" if cover.share >= least else "undecided"
    named = [f"{start:.1f} to {end:.1f} s" for start, end in cover.spans_s[:MOST_NAMED]]
    where = ", ".join(named) + (" and more" if len(cover.spans_s) > MOST_NAMED else "")
    text = f"The verdict covers {100 * cover.share:.0f} % of the film" + (f" ({where})" if where else "")
    text += f"; at least {100 * least:.0f} % are needed." if level == "undecided" else "."
    return Reason("cover", level, cover.share, least, "share", text)
