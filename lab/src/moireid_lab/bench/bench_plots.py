"""The one plot of a bench: outcomes as bars, or one figure against another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from moireid_lab.bench.part import Row
from moireid_lab.evaluation.plots import figure_of, plain

COLOURS = {"right": "#22577a", "inconclusive": "#d3dae2", "wrong": "#d98a3d"}


def plot_of(rows: Sequence[Row], keys: Sequence[str]) -> Any:
    """A figure of the rows of a bench's table.

    Parameters: keys: none, where the rows count outcomes by question and kind; else those of the figures across and up,
        both log, and of what is a line of its own.
    """
    if not keys:
        bars = [row for row in rows if all(name in row for name in COLOURS)]
        figure = figure_of(8, 0.18 * len(bars) + 1.5)
        axes, begins = figure.add_subplot(), np.zeros(len(bars))
        for name, colour in COLOURS.items():
            values = [row[name] for row in bars]
            axes.barh(range(len(bars)), values, left=begins, color=colour, label=name)
            begins += np.array(values)
        axes.set_yticks(range(len(bars)), [f"{row['question']}, {row['kind']}"[:60] for row in bars], fontsize=7)
        axes.invert_yaxis()
    else:
        across, up, *by = keys
        figure = figure_of(7, 4.4)
        axes = figure.add_subplot()
        known = [row for row in rows if row.get(across) and row.get(up)]
        for name in dict.fromkeys(", ".join(str(row[key]) for key in by) for row in known):
            own = [row for row in known if ", ".join(str(row[key]) for key in by) == name]
            axes.loglog([row[across] for row in own], [row[up] for row in own], "o-", label=name)
        axes.set(xlabel=across, ylabel=up)
    plain(axes)
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)
    return figure
