"""Parts that the plots of the suites share: bars of verdicts, and error against run time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from moireid_lab.bench.bench_rows import Row
from moireid_lab.evaluation.plots import figure_of, plain

__all__ = ["COLOURS", "error_against_time", "figure_of", "plain", "verdict_bars"]

#: None looks like praise or alarm: an accepted forgery is a failure, an accepted badge none.
COLOURS = {"accept": "#22577a", "inconclusive": "#d3dae2", "reject": "#d98a3d"}
SERIES = ("#12406b", "#3fa7a0", "#c9a227", "#c2571a", "#8a5aa8", "#2e7d4f", "#7a1f1f", "#8a97a6", "#1f6fb2")


def verdict_bars(
    axes: Any, films: Sequence[Sequence[Row]], *, offset: float = 0.0, height: float = 0.8, label: bool = True
) -> None:
    """One bar for each group of rows: the share of its films by verdict."""
    places, begins = np.arange(len(films)) + offset, np.zeros(len(films))
    for verdict, colour in COLOURS.items():
        shares = [sum(row["verdict"] == verdict for row in rows) / max(len(rows), 1) for rows in films]
        axes.barh(places, shares, height, left=begins, color=colour, label=verdict if label else None)
        begins += shares


def error_against_time(
    series: Mapping[str, Sequence[Row]],
    errors: Mapping[str, Callable[[Row], float | None]],
    seconds: Callable[[Row], float],
    time_label: str,
    marked: Mapping[str, Row | None] | None = None,
) -> Any:
    """A panel for each error: run time against it, both log, a line for each series.

    Parameters: errors: each by the label of its axis; rows without it are left out; marked: rows that are ringed, such
        as the default, by their name in the legend.
    """
    figure = figure_of(1.5 + 3.6 * len(errors), 4.4)
    panels = figure.subplots(1, len(errors), sharey=True, squeeze=False)[0]
    for axes, (label, error) in zip(panels, errors.items(), strict=True):
        for k, (name, rows) in enumerate(series.items()):
            known = [(e, seconds(row)) for row in rows if (e := error(row)) is not None]
            axes.plot(
                *(zip(*known, strict=True) if known else ([], [])), "o-", color=SERIES[k % len(SERIES)], label=name
            )
        for mark, (name, row) in zip("*os", (marked or {}).items(), strict=False):
            if row is not None and (at := error(row)) is not None:
                axes.plot(at, seconds(row), mark, mfc="none", mec="#c0392b", markersize=15, label=name)
        axes.set(xscale="log", yscale="log", xlabel=label)
        plain(axes)
    panels[0].set_ylabel(time_label)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right center", frameon=False, fontsize=8)
    return figure
