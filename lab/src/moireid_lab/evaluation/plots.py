"""Plots of a collection: scores by group, ROC and Tippett's."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from moireid.files import whole_file
from moireid.verifier.decision.figures import calibrated_log10
from moireid_lab.evaluation.summary import LIMITS, RATIOS

Document = dict[str, Any]
#: A line of a plot: across, up, name, colour.
Line = tuple[Any, Any, str, str]
INK = "#1d2733"
COLOURS = {"moireid": "#1f6fb2", "published": "#8a97a6", "genuine": "#1f6fb2", "forged": "#c2571a"}
#: Range of each score in the plot.  Scores outside are drawn at the edge, as they would compress all others.
SHOWN = {"moireid": (-30.0, 60.0), "published": (-0.05, 1.0)}


def write_plots(document: Document, folder: Path) -> list[Path]:
    """Write a file for each of `PLOTS`, whole or not at all."""
    return [write_svg(plot(document), folder / f"{name}.svg") for name, plot in PLOTS.items()]


def write_svg(figure: Any, path: Path) -> Path:
    """Write a figure, whole or not at all; the same bytes each time."""
    from matplotlib import rc_context

    with rc_context({"svg.hashsalt": "moireid"}), whole_file(path) as temporary:
        figure.savefig(temporary, format="svg", metadata={"Date": None})
    return path


def figure_of(width: float, height: float) -> Any:
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasSVG(figure)
    return figure


def plain(axes: Any) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(colors=INK, labelsize=9)
    axes.grid(color="#e4e8ed", linewidth=0.7)
    axes.set_axisbelow(True)


def _scores(document: Document) -> Any:
    """One dot per film, one row per group and label, one panel per pipeline; dotted: the pipeline's own limit."""
    names = list(document["pipelines"])
    kinds = list(dict.fromkeys((row["group"], row["label"]) for row in document["rows"]))[::-1]
    figure = figure_of(2.6 + 3.6 * len(names), 0.34 * len(kinds) + 2.0)
    for axes, name in zip(figure.subplots(1, len(names), sharey=True, squeeze=False)[0], names, strict=True):
        for place, kind in enumerate(kinds):
            films = [row for row in document["rows"] if (row["pipeline"], row["group"], row["label"]) == (name, *kind)]
            scores = np.clip([row["score"] for row in films if row["score"] is not None], *SHOWN[name])
            colour, lanes = COLOURS["genuine" if kind[1] == "genuine" else "forged"], np.arange(len(scores)) % 5 - 2
            axes.plot(scores, place + 0.12 * lanes, "o", color=colour, markersize=4.5, alpha=0.6)
            axes.text(SHOWN[name][1], place, f"  {len(films) - len(scores) or ''}", color=colour, va="center")
        axes.axvline(LIMITS[name], color=INK, linewidth=1, linestyle=":")
        axes.set_xlim(*SHOWN[name])
        axes.set_yticks(range(len(kinds)), [": ".join(dict.fromkeys(kind)) for kind in kinds])
        axes.set_xlabel(f"score, {name}; right: films without one", color=INK)
        plain(axes)
    return figure


def curves(lines: Iterable[Line], across: str, up: str, none: str = "", ncols: int = 2, **axes_how: Any) -> Any:
    """Lines with their names, or the words for none."""
    figure = figure_of(4.8, 4.8)
    axes = figure.add_subplot()
    for x, y, label, colour in lines:
        axes.plot(x, y, color=colour, linewidth=2, label=label)
    axes.set(xlabel=across, ylabel=up, **axes_how)
    plain(axes)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, fontsize=9, ncols=ncols, loc="lower left", bbox_to_anchor=(0, 1))
    else:
        axes.text(0.5, 0.5, none, ha="center", transform=axes.transAxes, color=INK)
    return figure


def _rocs(document: Document, part: str) -> Iterable[tuple[str, Document]]:
    """The pipelines that have a curve, and what is said of them."""
    return [(name, one[part]) for name, one in document["pipelines"].items() if "roc" in one[part]]


def _roc(document: Document) -> Any:
    """True accepts against false accepts; films without a score are never accepted."""
    lines = [
        (one["roc"]["false_accept"], one["roc"]["true_accept"], f"{name}: AUC {one['auc']:.3f}", COLOURS[name])
        for name, one in _rocs(document, "all_films")
    ]
    return curves(lines, "forged films accepted", "genuine films accepted", _one_kind(document), aspect="equal")


def _tippett(document: Document) -> Any:
    """Shares of genuine and of forged films whose calibrated odds are that great or greater."""
    lines = []
    for name, one in _rocs(document, "scored_films"):
        for key, kind in (("true_accept", "genuine"), ("false_accept", "forged")) if name in RATIOS else ():
            at, shares = _steps(one, key, *SHOWN[name])
            lines.append(([calibrated_log10(score) for score in at], shares, f"{kind} films", COLOURS[kind]))
    up = "share of films with these odds or more"
    return curves(lines, "decadic logarithm of the calibrated odds", up, _one_kind(document))


def _one_kind(document: Document) -> str:
    return f"all films are {'genuine' if document['genuine'] else 'forged'}"


def _steps(found: Document, key: str, least: float, most: float) -> tuple[Any, Any]:
    """Thresholds in rising order, each twice, and a curve's values below and above it, carried on to both edges.

    Convention: between two scores the value is that of the upper one, which is the next threshold that is met.
    """
    # The first step accepts nothing, and one of null is that of films without a score, which no threshold accepts.
    known = [k for k, at in enumerate(found["roc"]["threshold"]) if at is not None][::-1]
    at = np.array([found["roc"]["threshold"][k] for k in known])
    values = [found["roc"][key][k] for k in known] + [found["roc"][key][0]]
    return np.concatenate([[least], np.repeat(at, 2), [most]]), np.repeat(values, 2)


#: Of each file, by its name without the suffix.
PLOTS = {"scores": _scores, "roc": _roc, "tippett": _tippett}
