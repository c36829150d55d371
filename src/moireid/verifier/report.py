"""The report for people: one self-contained page with plots, and the same figures as JSON beside it."""

from __future__ import annotations

import base64
import io
import json
from importlib import resources
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from moireid.files import planned, write_text
from moireid.verifier.identity import read_identity
from moireid.verifier.verify import Report

INK, PREDICTED, MEASURED, PALE = "#1d2733", "#c2571a", "#1f6fb2", "#8a97a6"
WORDS = {
    "accept": "The fringes moved as only a real badge's do, and the badge is the one claimed.",
    "reject": "This film does not show the claimed badge as it would look in reality.",
    "inconclusive": "This film does not show enough to decide.",
}


def report_paths(folder: Path) -> list[Path]:
    """The files that `write_report` writes."""
    return [folder / "report.html", folder / "report.json"]


def write_report(report: Report, folder: Path, *, overwrite: bool = False) -> list[Path]:
    """Write report.html and report.json, each whole or not at all.  Raises: SpecError where one is in the way."""
    page, data = report_paths(folder)
    planned([page, data], overwrite=overwrite)
    write_text(page, render_page(report))
    write_text(data, json.dumps(report.to_json(), indent=1, ensure_ascii=False) + "\n")
    return [page, data]


def render_page(report: Report) -> str:
    """The report as one HTML page that asks for no other file."""
    import jinja2

    template = resources.files("moireid.verifier").joinpath("report.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    words = WORDS[report.verdict]
    if report.verdict == "accept" and report.identity.verdict == "not_claimed":
        words = "The fringes moved as only a real badge's do. No identity was claimed."
    return environment.from_string(template).render(
        report=report, data=report.to_json(), words=words, plots=_plots(report), picture=_picture(report)
    )


def _plots(report: Report) -> list[tuple[str, str]]:
    """Titles and SVG texts of the plots that this report can show."""
    if report.measurement is None:
        return []
    plots = [("Fringe phase over time", _phase_plot(report)), ("Measured against predicted", _gain_plot(report))]
    coded = next((g for g in report.badge.gratings if g.code), None)
    if coded and coded.code:
        if "phase" in coded.code.roles:
            plots.append(("Symbols of the cells", _symbol_plot(report)))
        else:
            plots.append(("Bands of the badge", _band_plot(report)))
    return plots


def _figure(width: float, height: float) -> tuple[Any, Any]:
    """A bare figure and its axes in the report's colours; no global state of the plotting library is touched."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(colors=INK, labelsize=9)
    axes.grid(color="#e4e8ed", linewidth=0.7)
    axes.set_axisbelow(True)
    return figure, axes


def _svg(figure: Any) -> str:
    from matplotlib import rc_context

    out = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "moireid", "font.family": "sans-serif"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]


def _phase_plot(report: Report) -> str:
    assert report.measurement is not None
    signal, times = report.measurement.gratings[0], report.measurement.times_s
    figure, axes = _figure(7.6, 3.0)
    axes.plot(times, signal.predicted_rad, color=PREDICTED, linewidth=3.2, alpha=0.55, label="predicted by the optics")
    axes.plot(times, signal.measured_rad, color=MEASURED, linewidth=1.2, label="measured on the fringes")
    axes.set_xlabel("time, s")
    axes.set_ylabel("phase, rad")
    axes.legend(frameon=False, fontsize=9, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    return _svg(figure)


def _gain_plot(report: Report) -> str:
    assert report.measurement is not None
    signal = report.measurement.gratings[0]
    figure, axes = _figure(3.7, 3.0)
    ends = np.array([signal.predicted_rad.min(), signal.predicted_rad.max()])
    axes.plot(ends, ends, color=PREDICTED, linewidth=3.2, alpha=0.55, label="law: slope 1")
    axes.plot(signal.predicted_rad, signal.measured_rad, ".", color=MEASURED, markersize=3)
    axes.set_xlabel("predicted phase, rad")
    axes.set_ylabel("measured phase, rad")
    axes.legend(frameon=False, fontsize=9, loc="lower left", bbox_to_anchor=(0, 1))
    return _svg(figure)


def _band_plot(report: Report) -> str:
    """Beat frequency of every strip, against the claimed badge's design, as differences to the reference cell."""
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
    figure, axes = _figure(3.7, 3.0)
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
    return _svg(figure)


def _symbol_plot(report: Report) -> str:
    """Phase of every cell on a circle; the spokes are where symbols lie, a dot's distance out is how sure it is."""
    assert report.measurement is not None
    readings = read_identity(report.track, report.measurement, report.badge).cells
    found = [cell for row in readings for cell in row if np.isfinite(cell.phase_sd)]
    phase = np.array([cell.phase_rad for cell in found])
    sure = 1.0 / (1.0 + np.array([cell.phase_sd for cell in found]))
    figure, axes = _figure(3.7, 3.0)
    for turn in np.arange(4) * np.pi / 2:
        axes.plot([0, 1.08 * np.cos(turn)], [0, 1.08 * np.sin(turn)], color=PREDICTED, alpha=0.55, linewidth=2.5)
        between = turn + np.pi / 4
        axes.plot([0, 1.08 * np.cos(between)], [0, 1.08 * np.sin(between)], color=PALE, linewidth=0.8, linestyle=":")
    axes.plot(sure * np.cos(phase), sure * np.sin(phase), "o", color=MEASURED, markersize=3.5, alpha=0.6)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{len(found)} cells; spokes: symbols, dotted: points of confusion", fontsize=8, color=INK)
    return _svg(figure)


def _picture(report: Report) -> str | None:
    """The badge as the film shows it, rectified, as a data URI."""
    if report.track.snapshot is None:
        return None
    _, png = cv2.imencode(".png", report.track.snapshot)
    return "data:image/png;base64," + base64.b64encode(png.tobytes()).decode()
