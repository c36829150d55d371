"""The plot of a report as an SVG text: the law over time.

It shows where the fringes should be, where they were, and behind them the verdict on each few seconds.  Its lines break
where frames are missing.  It is a picture in a page, so its colours are variables of its own that follow the reader's
choice of light or dark.  The same report always gives the same bytes.

Convention: it shows the track that the report keeps; for a film in chapters that is one chapter.  Places of fringes are
in fringe widths; one width is a phase of 2 pi.
"""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.frames import axis_words
from moireid.verifier.camera.stretches import longest_step_s
from moireid.verifier.report.seconds import BANDS, LAW
from moireid.verifier.session.cover import seen_spans
from moireid.verifier.session.result import Report
from moireid.verifier.timeline import Span, within

Array = NDArray[np.float64]
INK, PREDICTED, MEASURED, GRID = "#1d2733", "#c2571a", "#1f6fb2", "#e4e8ed"
#: Each colour on a dark page.
DARK = {
    INK: "#e6eaef",
    PREDICTED: "#f0a06c",
    MEASURED: "#7db8ee",
    GRID: "#36414e",
    BANDS["accept"]: "#54b884",
    BANDS["reject"]: "#ff8a80",
    BANDS["inconclusive"]: "#76818d",
}
#: Digits of a coordinate in a plot that are too fine to be seen.
FINE = re.compile(r"(\d+\.\d{2})\d+")


def figure_of(width: float, height: float) -> tuple[Any, Any]:
    """An empty figure and its axes in the report's colours, without the plotting library's global state; inches."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    figure.patch.set_visible(False)
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    axes.patch.set_visible(False)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(INK)
    axes.tick_params(colors=INK, labelsize=9)
    axes.grid(color=GRID, linewidth=0.7)
    axes.set_axisbelow(True)
    return figure, axes


def svg_of(figure: Any) -> str:
    """The figure as SVG, its colours as variables with one value for light pages and one for dark pages."""
    from matplotlib import rc_context

    out = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "moireid", "font.family": "sans-serif"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    text = FINE.sub(r"\1", text[text.index("<svg") :])
    for number, colour in enumerate(DARK):
        text = text.replace(colour, f"var(--c{number})")
    day = ";".join(f"--c{number}:{colour}" for number, colour in enumerate(DARK))
    night = ";".join(f"--c{number}:{colour}" for number, colour in enumerate(DARK.values()))
    style = f"svg{{{day}}}text{{fill:var(--c0)}}@media screen and (prefers-color-scheme:dark){{svg{{{night}}}}}"
    head = text.index(">") + 1
    return f"{text[:head]}<style>{style}</style>{text[head:]}"


def broken(times_s: Array, stretch: NDArray[np.int64], *values: Array) -> tuple[Array, ...]:
    """Times and values (T,) with a gap wherever frames are missing, so that no line is drawn across unseen time.

    Parameters: stretch (T,): number of the stretch of each frame; a new one is a gap too.
    Returns: times, then each of the values, with NaN in each gap.
    """
    if len(times_s) < 2:
        return times_s, *values
    gap = (np.diff(times_s) > longest_step_s(times_s)) | (np.diff(stretch) != 0)
    at = np.flatnonzero(gap) + 1
    return np.insert(times_s, at, times_s[at - 1]), *(np.insert(value, at, np.nan) for value in values)


#: Width and height in inches: for a page, and for a phone.
WIDE, NARROW = (7.6, 3.1), (3.6, 3.3)
#: Height of the plot at least, in fringe widths, so that noise does not look like motion.
LEAST_WIDTHS = 0.2
#: The time axis shows the whole film if that is at most so many times as long as the plotted part; else only this part.
MAX_FILM_SHOWN_RATIO = 2.0


def law_plot(report: Report, size: tuple[float, float] = WIDE) -> str | None:
    """The plot as SVG; None if nothing could be measured."""
    if report.measurement is None:
        return None
    signal, times = report.measurement.gratings[report.most_informative], report.measurement.times_s
    figure, axes = figure_of(*size)
    shown: set[str] = set()
    for part in report.segments:
        for start, end in within((max(part.start_s, times[0]), min(part.end_s, times[-1])), seen_spans(times)):
            name = None if part.verdict in shown else LAW[part.verdict]
            axes.axvspan(start, end, color=BANDS[part.verdict], alpha=0.16, linewidth=0, label=name)
            shown.add(part.verdict)
    read = np.where(np.isfinite(signal.phase_sd_rad), signal.measured_rad, np.nan)
    at, law, seen = broken(times, signal.stretch, signal.predicted_rad / (2 * np.pi), read / (2 * np.pi))
    axes.plot(at, law, color=PREDICTED, linewidth=3.2, alpha=0.55, label=f"fringes by the law{_along(report)}")
    axes.plot(at, seen, color=MEASURED, linewidth=1.3, label="fringes as seen")
    axes.set_xlim(*_shown_s(report, times))
    low, high = axes.get_ylim()
    spare = max(LEAST_WIDTHS - (high - low), 0.0) / 2
    axes.set_ylim(low - spare, high + spare)
    axes.set(xlabel="time, s", ylabel="place of the fringes, in widths")
    columns = 4 if size == WIDE else 1
    axes.legend(frameon=False, fontsize=9, ncols=columns, loc="lower left", bbox_to_anchor=(-0.02, 1))
    return svg_of(figure)


def _along(report: Report) -> str:
    """Which direction is shown, for a badge that senses several."""
    if len(report.badge.gratings) == 1:
        return ""
    return f", along {axis_words(report.badge.gratings[report.most_informative].axis)}"


def _shown_s(report: Report, times_s: Array) -> Span:
    """First and last time of the plot, s: of the whole film, so that one sees what is missing."""
    first, last = float(times_s[0]), max(float(times_s[-1]), float(times_s[0]) + 0.1)
    film = report.cover.film_s if report.cover else (first, last)
    whole = film[1] - film[0] <= MAX_FILM_SHOWN_RATIO * (last - first)
    return (min(film[0], first), max(film[1], last)) if whole else (first, last)
