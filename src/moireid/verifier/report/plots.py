"""The plots for experts, as SVG texts; the same report always gives the same bytes.

Convention: plots over time show the track that the report keeps; for a film in chapters that is one chapter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision.figures import window_correlations
from moireid.verifier.identity.decode import read_identity
from moireid.verifier.limits import WINDOW_FRAMES
from moireid.verifier.report.drawing import INK, MEASURED, PALE, PREDICTED, broken, figure_of, svg_of
from moireid.verifier.session.result import Report


def plots_of(report: Report) -> list[tuple[str, str]]:
    """Titles and SVG texts of the plots for which this report has data."""
    if report.measurement is None:
        return []
    plots = [
        ("Measured against predicted phase", _gain_plot(report)),
        ("Measured minus predicted phase", _residual_plot(report)),
        ("Where the camera was", _parallax_plot(report)),
        ("Correlation by time", _window_plot(report)),
    ]
    coded = next((g for g in report.badge.gratings if g.code), None)
    if coded and coded.code:
        if "phase" in coded.code.roles:
            plots.append(("Symbols of the cells", _symbol_plot(report)))
        else:
            plots.append(("Bands of the badge", _band_plot(report)))
    return plots


def _residual_plot(report: Report) -> str:
    """Residual of the measured phase with its error bar."""
    assert report.measurement is not None
    signal, times = report.measurement.gratings[report.telling], report.measurement.times_s
    figure, axes = figure_of(3.7, 3.0)
    error = np.hypot(np.where(np.isfinite(signal.phase_sd_rad), signal.phase_sd_rad, np.nan), signal.pose_sd_rad)
    shown, room, left = broken(times, signal.stretch, 2 * error, signal.measured_rad - signal.predicted_rad)
    axes.fill_between(shown, -room, room, color=PREDICTED, alpha=0.25, linewidth=0, label="two error bars")
    axes.plot(shown, np.where(np.isfinite(room), left, np.nan), color=MEASURED, linewidth=1.0, label="measured - law")
    axes.set_xlabel("time, s")
    axes.set_ylabel("residual, rad")
    axes.legend(frameon=False, fontsize=9, ncols=2, loc="lower left", bbox_to_anchor=(-0.15, 1))
    return svg_of(figure)


def _window_plot(report: Report) -> str:
    """Correlation over windows of 30 frames, at each window's middle."""
    assert report.measurement is not None
    signal, times = report.measurement.gratings[report.telling], report.measurement.times_s
    figure, axes = figure_of(3.7, 3.0)
    windows = window_correlations(signal.measured_rad, signal.predicted_rad)
    half = WINDOW_FRAMES // 2
    middles, stretch = times[half:][: len(windows)], signal.stretch[half:][: len(windows)]
    axes.plot(*broken(middles, stretch, windows), color=MEASURED, linewidth=1.2)
    axes.set_ylim(min(-0.05, float(windows.min(initial=0.0)) - 0.05), 1.05)
    axes.set_xlabel("time, s")
    axes.set_ylabel("correlation of 30 frames")
    return svg_of(figure)


def _parallax_plot(report: Report) -> str:
    """The camera's place, relative to the badge."""
    assert report.measurement is not None
    figure, axes = figure_of(3.7, 3.0)
    stretch = report.measurement.gratings[report.telling].stretch
    shown, *places = broken(report.measurement.times_s, stretch, *parallax_of(report).T)
    for place, colour, name in zip(places, (MEASURED, PALE), "xy", strict=True):
        axes.plot(shown, place, color=colour, label=name)
    axes.set_xlabel("time, s")
    axes.set_ylabel("parallax, place over distance")
    axes.legend(frameon=False, fontsize=9, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    return svg_of(figure)


def _gain_plot(report: Report) -> str:
    assert report.measurement is not None
    signal = report.measurement.gratings[report.telling]
    figure, axes = figure_of(3.7, 3.0)
    ends = np.array([signal.predicted_rad.min(), signal.predicted_rad.max()])
    axes.plot(ends, ends, color=PREDICTED, linewidth=3.2, alpha=0.55, label="law: slope 1")
    axes.plot(signal.predicted_rad, signal.measured_rad, ".", color=MEASURED, markersize=3)
    axes.set_xlabel("predicted phase, rad")
    axes.set_ylabel("measured phase, rad")
    axes.legend(frameon=False, fontsize=9, loc="lower left", bbox_to_anchor=(0, 1))
    return svg_of(figure)


def _band_plot(report: Report) -> str:
    """Beat frequency of every strip and by the claimed badge's design, as differences from the reference cell."""
    assert report.measurement is not None
    grating = next((g for g in report.badge.gratings if g.code), report.badge.gratings[0])
    index = report.badge.gratings.index(grating)
    reference = grating.code.reference_cell if grating.code else 0
    own = [
        (strip.cells[0], phase.frequency_per_mm)
        for strip, phase in zip(report.track.strips, report.measurement.strips, strict=True)
        if strip.grating == index and phase is not None
    ]
    seen = np.array([np.mean([f for c, f in own if c == cell]) for cell in range(len(grating.cells))])
    design = np.array([1 / cell.pitch_mm for cell in grating.cells])
    figure, axes = figure_of(3.7, 3.0)
    bands = np.arange(1, len(seen) + 1)
    axes.barh(
        bands, 1000 * (design - design[reference]), color=PREDICTED, alpha=0.45, height=0.8, label="claimed badge"
    )
    axes.plot(1000 * (seen - seen[reference]), bands, "o", color=MEASURED, markersize=5, label="read in the film")
    axes.invert_yaxis()
    axes.set_yticks(bands)
    axes.set_xlabel("beat against reference, cycles/m")
    axes.set_ylabel("band, from the top")
    axes.legend(frameon=False, fontsize=9, ncols=2, loc="lower left", bbox_to_anchor=(-0.2, 1))
    return svg_of(figure)


def _symbol_plot(report: Report) -> str:
    """Phase of every cell on a circle; spokes mark the symbols, and a dot further out is more certain."""
    assert report.measurement is not None
    readings = read_identity(report.track, report.measurement).cells
    found = [cell for row in readings for cell in row if np.isfinite(cell.phase_sd)]
    phase = np.array([cell.phase_rad for cell in found])
    sure = 1.0 / (1.0 + np.array([cell.phase_sd for cell in found]))
    figure, axes = figure_of(3.7, 3.0)
    for turn in np.arange(4) * np.pi / 2:
        axes.plot([0, 1.08 * np.cos(turn)], [0, 1.08 * np.sin(turn)], color=PREDICTED, alpha=0.55, linewidth=2.5)
        between = turn + np.pi / 4
        axes.plot([0, 1.08 * np.cos(between)], [0, 1.08 * np.sin(between)], color=PALE, linewidth=0.8, linestyle=":")
    axes.plot(sure * np.cos(phase), sure * np.sin(phase), "o", color=MEASURED, markersize=3.5, alpha=0.6)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{len(found)} cells; spokes: symbols, dotted: points of confusion", fontsize=8, color=INK)
    return svg_of(figure)


def parallax_of(report: Report) -> NDArray[np.float64]:
    """Parallax coordinates of the page's middle, (T, 2)."""
    assert report.measurement is not None
    x0, y0, x1, y1 = report.badge.outline_mm
    camera = report.measurement.camera_mm
    return np.asarray((camera[:, :2] - ((x0 + x1) / 2, (y0 + y1) / 2)) / np.abs(camera[:, 2:]))
