"""The one plot of a bench: outcomes as bars, one figure against another, or how often each outcome came."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from moireid_lab.bench.part import Row
from moireid_lab.evaluation.plots import figure_of, plain

COLOURS = {"right": "#22577a", "inconclusive": "#d3dae2", "wrong": "#d98a3d"}


def plot_of(rows: Sequence[Row], columns: Sequence[str], keys: Sequence[str]) -> Any:
    """A figure of the rows of a bench's table.

    Parameters: columns: headings; keys: none, where the rows count outcomes; one, to count its values; else those of
        the figures across and up, both log, and of what is a line of its own.
    """
    if not keys:
        bars = [row for row in rows if all(name in row for name in COLOURS)]
        names = [", ".join(str(row[name]) for name in columns if isinstance(row.get(name), str)) for row in bars]
        return _bars([name[:60] for name in names], {name: [row[name] for row in bars] for name in COLOURS})
    if len(keys) == 1:
        counts = Counter(str(row[keys[0]]) for row in rows if keys[0] in row)
        return _bars(list(counts), {keys[0]: list(counts.values())})
    across, up, *by = keys
    figure = figure_of(7, 4.4)
    axes = figure.add_subplot()
    known = [row for row in rows if row.get(across) and row.get(up)]
    for name in dict.fromkeys(", ".join(str(row[key]) for key in by) for row in known):
        own = [row for row in known if ", ".join(str(row[key]) for key in by) == name]
        axes.loglog([row[across] for row in own], [row[up] for row in own], "o-", label=name)
    axes.set(xlabel=across, ylabel=up)
    return _with_legend(figure, axes)


def _bars(names: list[str], counts: dict[str, list[int]]) -> Any:
    """One bar for each name, in parts."""
    figure = figure_of(8, 0.18 * len(names) + 1.5)
    axes, begins = figure.add_subplot(), np.zeros(len(names))
    for part, values in counts.items():
        axes.barh(range(len(names)), values, left=begins, color=COLOURS.get(part), label=part)
        begins += np.array(values)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.invert_yaxis()
    return _with_legend(figure, axes)


def _with_legend(figure: Any, axes: Any) -> Any:
    plain(axes)
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)
    return figure
