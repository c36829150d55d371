"""The measured phase of the fringes against the one that optics predict, as a figure for notebooks.

Convention: phases in rad, mean 0; frames that could not be read are left out.
"""

from __future__ import annotations

import io

import numpy as np
from matplotlib.figure import Figure

from moireid.errors import SpecError
from moireid.verifier.report.plots import GRID, MEASURED, PREDICTED, broken
from moireid.verifier.signal_table import SignalTable


class NotebookFigure(Figure):
    """A figure that a notebook shows, though it is in none of pyplot's lists."""

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png")
        return out.getvalue()


def phase_figure(signals: SignalTable, grating: int | None = None) -> NotebookFigure:
    """Draw both phases over time, and one against the other.

    Parameters: grating: its number, None for the one whose predicted phase moves most.
    Raises: SpecError where there are no signals, or no such grating.
    """
    number = signals.most_moved() if grating is None else grating
    if number not in range(signals.gratings):
        raise SpecError(f"grating {number!r} is not on this badge; give 0 to {signals.gratings - 1}")
    predicted, error = signals[f"predicted_rad_{number}"], signals[f"phase_sd_rad_{number}"]
    measured = np.where(np.isfinite(error), signals[f"measured_rad_{number}"], np.nan)
    figure = NotebookFigure(figsize=(9.0, 3.4), layout="constrained")
    time, slope = figure.subplots(1, 2, width_ratios=(2, 1))
    at, law, seen = broken(signals["time_s"], np.zeros(len(predicted), np.int64), predicted, measured)
    time.plot(at, law, color=PREDICTED, linewidth=3.0, alpha=0.55, label="predicted by optics")
    time.plot(at, seen, color=MEASURED, linewidth=1.3, label="measured")
    time.set(xlabel="time, s", ylabel="phase of the fringes, rad")
    time.legend(frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    ends = [predicted.min(), predicted.max()]
    slope.plot(ends, ends, color=PREDICTED, linewidth=3.0, alpha=0.55)
    slope.plot(predicted, measured, ".", color=MEASURED, markersize=3)
    slope.set(xlabel="predicted, rad", ylabel="measured, rad")
    for axes in (time, slope):
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color=GRID, linewidth=0.7)
    return figure
