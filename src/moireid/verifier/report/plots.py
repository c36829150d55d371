"""The plots of a report as SVG texts: the law over time, and the plots for experts.

The plot of the law shows where the fringes should be, where they were, and behind them the verdict on each few seconds.
All plots share their colours, for light and dark pages, and their lines break where frames are missing.  A plot is a
picture in a page, so its colours are variables of its own that follow the reader's choice of light or dark.  The same
report always gives the same bytes.

Convention: plots over time show the track that the report keeps; for a film in chapters that is one chapter.  Places of
fringes are in fringe widths; one width is a phase of 2 pi.
"""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Grating
from moireid.frames import axis_words
from moireid.verifier.camera.stretches import longest_step_s
from moireid.verifier.decision.figures import window_correlations
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.decode import read_identity
from moireid.verifier.limits import WINDOW_FRAMES
from moireid.verifier.report.seconds import BANDS, LAW
from moireid.verifier.session.cover import seen_spans
from moireid.verifier.session.result import Report
from moireid.verifier.timeline import Span, within

Array = NDArray[np.float64]
INK, PREDICTED, MEASURED, PALE, GRID = "#1d2733", "#c2571a", "#1f6fb2", "#8a97a6", "#e4e8ed"
RIVAL = "#7a3fa0"
#: Each colour on a dark page.
DARK = {
    INK: "#e6eaef",
    PREDICTED: "#f0a06c",
    MEASURED: "#7db8ee",
    RIVAL: "#c9a0e6",
    PALE: "#93a0ae",
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


def label(axes: Any, along: str, up: str, *, columns: int = 1, left: float = 0) -> None:
    """Name the axes, and above them the lines.

    Parameters: columns: of the lines' names, 0 for no names; left: where these begin, as a share of the plot's width.
    """
    axes.set_xlabel(along)
    axes.set_ylabel(up)
    if columns:
        axes.legend(frameon=False, fontsize=9, ncols=columns, loc="lower left", bbox_to_anchor=(left, 1))


#: Width and height in inches: for a page, for a phone, and of a plot for experts.
WIDE, NARROW, SMALL = (7.6, 3.1), (3.6, 3.3), (3.7, 3.0)
#: The line of the law.
BY_LAW = {"color": PREDICTED, "linewidth": 3.2, "alpha": 0.55}
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
    axes.plot(at, law, **BY_LAW, label=f"fringes by the law{_along(report)}")
    axes.plot(at, seen, color=MEASURED, linewidth=1.3, label="fringes as seen")
    axes.set_xlim(*_shown_s(report, times))
    low, high = axes.get_ylim()
    spare = max(LEAST_WIDTHS - (high - low), 0.0) / 2
    axes.set_ylim(low - spare, high + spare)
    label(axes, "time, s", "place of the fringes, in widths", columns=4 if size == WIDE else 1, left=-0.02)
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


def plots_of(report: Report) -> list[tuple[str, str]]:
    """Titles and SVG texts of the plots for which this report has data."""
    if report.measurement is None:
        return []
    found, signal = report.measurement, report.measurement.gratings[report.most_informative]
    plots = [
        ("Measured against predicted phase", _gain_plot(signal)),
        ("Measured minus predicted phase", _residual_plot(found, signal)),
        ("Where the camera was", _parallax_plot(report, found, signal)),
        ("Correlation by time", _window_plot(found, signal)),
    ]
    coded = next((g for g in report.badge.gratings if g.code), None)
    if coded and coded.code and "phase" in coded.code.roles:
        plots.append(("Symbols of the cells", _symbol_plot(report, found)))
    elif coded:
        plots.append(("Bands of the badge", _band_plot(report, found, coded)))
    return plots


def _residual_plot(found: Measurement, signal: GratingSignal) -> str:
    """Residual of the measured phase with its error bar."""
    figure, axes = figure_of(*SMALL)
    error = np.hypot(np.where(np.isfinite(signal.phase_sd_rad), signal.phase_sd_rad, np.nan), signal.pose_sd_rad)
    shown, room, left = broken(found.times_s, signal.stretch, 2 * error, signal.measured_rad - signal.predicted_rad)
    axes.fill_between(shown, -room, room, color=PREDICTED, alpha=0.25, linewidth=0, label="two error bars")
    axes.plot(shown, np.where(np.isfinite(room), left, np.nan), color=MEASURED, linewidth=1.0, label="measured - law")
    label(axes, "time, s", "residual, rad", columns=2, left=-0.15)
    return svg_of(figure)


def _window_plot(found: Measurement, signal: GratingSignal) -> str:
    """Correlation over windows of 30 frames, at each window's middle."""
    figure, axes = figure_of(*SMALL)
    windows = window_correlations(signal.measured_rad, signal.predicted_rad)
    half = WINDOW_FRAMES // 2
    middles, stretch = found.times_s[half:][: len(windows)], signal.stretch[half:][: len(windows)]
    axes.plot(*broken(middles, stretch, windows), color=MEASURED, linewidth=1.2)
    axes.set_ylim(min(-0.05, float(windows.min(initial=0.0)) - 0.05), 1.05)
    label(axes, "time, s", "correlation of 30 frames", columns=0)
    return svg_of(figure)


def _parallax_plot(report: Report, found: Measurement, signal: GratingSignal) -> str:
    """The camera's place, relative to the badge."""
    figure, axes = figure_of(*SMALL)
    shown, *places = broken(found.times_s, signal.stretch, *report.parallax.T)
    for place, colour, name in zip(places, (MEASURED, PALE), "xy", strict=True):
        axes.plot(shown, place, color=colour, label=name)
    label(axes, "time, s", "parallax, place over distance", columns=2)
    return svg_of(figure)


def _gain_plot(signal: GratingSignal) -> str:
    figure, axes = figure_of(*SMALL)
    ends = np.array([signal.predicted_rad.min(), signal.predicted_rad.max()])
    axes.plot(ends, ends, **BY_LAW, label="law: slope 1")
    axes.plot(signal.predicted_rad, signal.measured_rad, ".", color=MEASURED, markersize=3)
    label(axes, "predicted phase, rad", "measured phase, rad")
    return svg_of(figure)


def _band_plot(report: Report, found: Measurement, grating: Grating) -> str:
    """Beat frequency of every band, measured and by the claimed badge's design, as difference from the reference."""
    index = report.badge.gratings.index(grating)
    reference = grating.code.reference_cell if grating.code else 0
    own = [
        (strip.cells[0], phase.frequency_per_mm)
        for strip, phase in zip(report.track.strips, found.strips, strict=True)
        if strip.grating == index and phase is not None
    ]
    seen = np.array([np.mean([f for c, f in own if c == cell]) for cell in range(len(grating.cells))])
    design = np.array([1 / cell.pitch_mm for cell in grating.cells])
    figure, axes = figure_of(*SMALL)
    bands = np.arange(1, len(seen) + 1)
    by_design = 1000 * (design - design[reference])
    axes.barh(bands, by_design, color=PREDICTED, alpha=0.45, height=0.8, label="claimed badge")
    axes.plot(1000 * (seen - seen[reference]), bands, "o", color=MEASURED, markersize=5, label="read in the film")
    axes.invert_yaxis()
    axes.set_yticks(bands)
    label(axes, "beat against reference, cycles/m", "band, from the top", columns=2, left=-0.2)
    return svg_of(figure)


def _symbol_plot(report: Report, found: Measurement) -> str:
    """Phase of every cell on a circle; spokes mark the symbols, and a dot further out is more certain."""
    read = [cell for row in read_identity(report.track, found).cells for cell in row if np.isfinite(cell.phase_sd)]
    phase = np.array([cell.phase_rad for cell in read])
    sure = 1.0 / (1.0 + np.array([cell.phase_sd for cell in read]))
    figure, axes = figure_of(*SMALL)
    for turn in np.arange(4) * np.pi / 2:
        axes.plot([0, 1.08 * np.cos(turn)], [0, 1.08 * np.sin(turn)], color=PREDICTED, alpha=0.55, linewidth=2.5)
        between = turn + np.pi / 4
        axes.plot([0, 1.08 * np.cos(between)], [0, 1.08 * np.sin(between)], color=PALE, linewidth=0.8, linestyle=":")
    axes.plot(sure * np.cos(phase), sure * np.sin(phase), "o", color=MEASURED, markersize=3.5, alpha=0.6)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{len(read)} cells; spokes: symbols, dotted: points of confusion", fontsize=8, color=INK)
    return svg_of(figure)
