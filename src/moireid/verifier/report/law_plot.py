"""The law by time: where the fringes should be, where they were, and the verdict on each few seconds behind them.

Convention: in fringe widths, a width being a turn of 2 pi; for a film in chapters it shows the one that is kept.
"""

from __future__ import annotations

import numpy as np

from moireid.verifier.report.drawing import BANDS, MEASURED, PREDICTED, broken, figure_of, svg_of
from moireid.verifier.report.seconds import LAW
from moireid.verifier.session.result import Report

#: Width and height in inches: for a page, and for a phone.
WIDE, NARROW = (7.6, 3.1), (3.6, 3.3)


def law_plot(report: Report, size: tuple[float, float] = WIDE) -> str | None:
    """The plot as SVG; None where nothing could be measured."""
    if report.measurement is None:
        return None
    signal, times = report.measurement.gratings[0], report.measurement.times_s
    figure, axes = figure_of(*size)
    shown = set()
    for part in report.segments:
        start, end = max(part.start_s, times[0]), min(part.end_s, times[-1])
        if end > start and part.tracked:
            label = None if part.verdict in shown else LAW[part.verdict]
            axes.axvspan(start, end, color=BANDS[part.verdict], alpha=0.16, linewidth=0, label=label)
            shown.add(part.verdict)
    read = np.where(np.isfinite(signal.phase_sd_rad), signal.measured_rad, np.nan)
    at, law, seen = broken(times, signal.stretch, signal.predicted_rad / (2 * np.pi), read / (2 * np.pi))
    axes.plot(at, law, color=PREDICTED, linewidth=3.2, alpha=0.55, label="where the law puts them")
    axes.plot(at, seen, color=MEASURED, linewidth=1.3, label="where they were seen")
    axes.set_xlim(times[0], max(times[-1], times[0] + 0.1))
    axes.set_xlabel("time, s")
    axes.set_ylabel("place of the fringes, in widths")
    columns = 4 if size == WIDE else 1
    axes.legend(frameon=False, fontsize=9, ncols=columns, loc="lower left", bbox_to_anchor=(-0.02, 1))
    return svg_of(figure)
