"""What all plots of a report share: their colours, by day and by night, and lines that break where frames are missing.

A plot is a picture in a page, so its colours are variables of its own that follow the reader's choice of light or dark.
"""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.stretches import longest_step_s

Array = NDArray[np.float64]
INK, PREDICTED, MEASURED, PALE, GRID = "#1d2733", "#c2571a", "#1f6fb2", "#8a97a6", "#e4e8ed"
RIVAL = "#7a3fa0"
BANDS = {"accept": "#1c7c4a", "reject": "#b3261e", "inconclusive": "#9aa4b0"}
#: Each colour by night.
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
#: Digits of a place in a plot that nobody sees.
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
    """The figure as SVG, its colours as variables with a value by day and one by night."""
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
    """Times and values (T,) with a gap wherever frames are missing, so that no line is drawn across what nobody saw.

    Parameters: stretch (T,): number of the stretch of each frame; a new one is a gap too.
    Returns: times, then each of the values, with NaN in each gap.
    """
    if len(times_s) < 2:
        return times_s, *values
    gap = (np.diff(times_s) > longest_step_s(times_s)) | (np.diff(stretch) != 0)
    at = np.flatnonzero(gap) + 1
    return np.insert(times_s, at, times_s[at - 1]), *(np.insert(value, at, np.nan) for value in values)
