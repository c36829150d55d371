"""The law by time: where the fringes should be, where they were, and the verdict on each few seconds behind them.

Convention: in fringe widths, a width being a turn of 2 pi; for a film in chapters it shows the one that is kept.
"""

from __future__ import annotations

import numpy as np

from moireid.frames import axis_words
from moireid.verifier.report.drawing import BANDS, MEASURED, PREDICTED, Array, broken, figure_of, svg_of
from moireid.verifier.report.seconds import LAW
from moireid.verifier.session.cover import Span, seen_spans, within
from moireid.verifier.session.result import Report

#: Width and height in inches: for a page, and for a phone.
WIDE, NARROW = (7.6, 3.1), (3.6, 3.3)
#: Height of the plot at least, in fringe widths, so that noise does not look like motion.
LEAST_WIDTHS = 0.2
#: Of a film so much longer than the part that is plotted, that part alone is shown.
MOST_BESIDE = 2.0


def law_plot(report: Report, size: tuple[float, float] = WIDE) -> str | None:
    """The plot as SVG; None where nothing could be measured."""
    if report.measurement is None:
        return None
    signal, times = report.measurement.gratings[report.telling], report.measurement.times_s
    figure, axes = figure_of(*size)
    shown: set[str] = set()
    for part in report.segments:
        for start, end in within((max(part.start_s, times[0]), min(part.end_s, times[-1])), seen_spans(times)):
            label = None if part.verdict in shown else LAW[part.verdict]
            axes.axvspan(start, end, color=BANDS[part.verdict], alpha=0.16, linewidth=0, label=label)
            shown.add(part.verdict)
    read = np.where(np.isfinite(signal.phase_sd_rad), signal.measured_rad, np.nan)
    at, law, seen = broken(times, signal.stretch, signal.predicted_rad / (2 * np.pi), read / (2 * np.pi))
    axes.plot(at, law, color=PREDICTED, linewidth=3.2, alpha=0.55, label=f"fringes by the law{_along(report)}")
    axes.plot(at, seen, color=MEASURED, linewidth=1.3, label="fringes as seen")
    axes.set_xlim(*_shown_s(report, times))
    low, high = axes.get_ylim()
    spare = max(LEAST_WIDTHS - (high - low), 0.0) / 2
    axes.set_ylim(low - spare, high + spare)
    axes.set_xlabel("time, s")
    axes.set_ylabel("place of the fringes, in widths")
    columns = 4 if size == WIDE else 1
    axes.legend(frameon=False, fontsize=9, ncols=columns, loc="lower left", bbox_to_anchor=(-0.02, 1))
    return svg_of(figure)


def _along(report: Report) -> str:
    """Which direction is shown, of a badge that senses several."""
    if len(report.badge.gratings) == 1:
        return ""
    return f", along {axis_words(report.badge.gratings[report.telling].axis)}"


def _shown_s(report: Report, times_s: Array) -> Span:
    """First and last time of the plot, s: the whole film's, so that what was not seen is seen to be missing."""
    first, last = float(times_s[0]), max(float(times_s[-1]), float(times_s[0]) + 0.1)
    film = report.cover.film_s if report.cover else (first, last)
    whole = film[1] - film[0] <= MOST_BESIDE * (last - first)
    return (min(film[0], first), max(film[1], last)) if whole else (first, last)
