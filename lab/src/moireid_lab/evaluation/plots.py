"""Plots of a collection: scores by group, ROC, DET, accuracy against threshold, and Tippett's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from moireid.files import whole_file
from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.limits import CALIBRATION_CAP_LOG10
from moireid_lab.evaluation.summary import LIMITS, RATIOS

Document = dict[str, Any]
INK, PALE = "#1d2733", "#8a97a6"
GENUINE, FORGED = "#1f6fb2", "#c2571a"
LINES = {"moireid": ("#1f6fb2", "-"), "published": ("#8a97a6", "--")}
#: Range of each score in the plot.  Scores outside are drawn at the edge, as they would compress all others.
SHOWN = {"moireid": (-30.0, 60.0), "published": (-0.05, 1.0)}
RATES = (0.001, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 0.999)


def write_plots(document: Document, folder: Path) -> list[Path]:
    """Write a file for each of `PLOTS`, whole or not at all."""
    from matplotlib import rc_context

    paths = []
    for name, plot in PLOTS.items():
        path = folder / f"{name}.svg"
        with rc_context({"svg.hashsalt": "moireid"}), whole_file(path) as temporary:
            plot(document).savefig(temporary, format="svg", metadata={"Date": None})
        paths.append(path)
    return paths


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
    """One dot per film, one row per group and label, one panel per pipeline."""
    pipelines = document["pipelines"]
    kinds = [(row["group"], row["label"]) for row in next(iter(pipelines.values()))["groups"]][::-1]
    figure = figure_of(2.6 + 3.6 * len(pipelines), 0.34 * len(kinds) + 1.5)
    panels = figure.subplots(1, len(pipelines), sharey=True, squeeze=False)[0]
    for axes, (pipeline, figures) in zip(panels, pipelines.items(), strict=True):
        least, most = SHOWN[pipeline]
        for place, kind in enumerate(kinds):
            own = [
                row for row in document["rows"] if row["pipeline"] == pipeline and (row["group"], row["label"]) == kind
            ]
            _dots(axes, place, own, GENUINE if kind[1] == "genuine" else FORGED, (least, most))
        best = figures["scored_films"].get("best_threshold")
        if best:
            axes.axvline(best["threshold"], color=INK, linewidth=1, linestyle=":")
        axes.set_xlim(least - 0.04 * (most - least), most + 0.15 * (most - least))
        axes.set_xlabel(f"score, {pipeline}", color=INK)
        plain(axes)
        axes.text(
            most + 0.05 * (most - least),
            1.0,
            "no\nscore",
            transform=axes.get_xaxis_transform(),
            fontsize=7,
            color=PALE,
            va="bottom",
        )
    names = [group if group == label else f"{group}: {label}" for group, label in kinds]
    panels[0].set_yticks(range(len(kinds)), names)
    panels[0].set_ylim(-0.6, len(kinds) - 0.4)
    figure.suptitle(
        "A dot: a film; an arrow: a score beyond the edge; bar: the median; dotted: the threshold of greatest accuracy",
        fontsize=9,
        color=INK,
        x=0.01,
        ha="left",
    )
    return figure


def _dots(axes: Any, place: int, rows: list[Document], colour: str, shown: tuple[float, float]) -> None:
    """The films of one row: dots in five lanes, arrows beyond the edges, the number of films without a score."""
    least, most = shown
    scores = np.array(sorted(row["score"] for row in rows if row["score"] is not None))
    lanes = place + 0.12 * (np.arange(len(scores)) % 5 - 2) if len(scores) > 1 else np.full(len(scores), float(place))
    within = (scores >= least) & (scores <= most)
    axes.plot(scores[within], lanes[within], "o", color=colour, markersize=4.5, alpha=0.6, markeredgewidth=0)
    for edge, beyond, mark in ((least, scores < least, "<"), (most, scores > most, ">")):
        axes.plot(np.full(beyond.sum(), edge), lanes[beyond], mark, color=colour, markersize=5, alpha=0.8)
    if len(scores) > 4:
        median = float(np.clip(np.median(scores), least, most))
        axes.plot([median, median], [place - 0.36, place + 0.36], color=INK, linewidth=1.6)
    if len(scores) < len(rows):
        axes.text(
            most + 0.08 * (most - least), place, str(len(rows) - len(scores)), color=colour, va="center", fontsize=9
        )


def _roc(document: Document) -> Any:
    """True accepts against false accepts; films without a score are never accepted."""
    figure = figure_of(4.6, 4.6)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="#c9d0d8", linewidth=1)
    for name, figures in document["pipelines"].items():
        found = figures["all_films"]
        if "roc" in found:
            colour, style = LINES[name]
            label = f"{name}: AUC {found['auc']:.3f}"
            axes.plot(
                found["roc"]["false_accept"], found["roc"]["true_accept"], style, color=colour, linewidth=2, label=label
            )
    axes.set_xlabel("forged films accepted")
    axes.set_ylabel("genuine films accepted")
    axes.set_aspect("equal")
    plain(axes)
    _legend_or_reason(axes, document)
    return figure


def _det(document: Document) -> Any:
    """False rejects against false accepts, on axes that make normally distributed scores a straight line.

    Rates of 0 and 1 are at infinity there, so they are drawn half a film away.
    """
    figure = figure_of(4.6, 4.6)
    axes = figure.add_subplot()
    ends = [-norm.ppf(1 - RATES[0]), norm.ppf(1 - RATES[0])]
    axes.plot(ends, ends, color="#c9d0d8", linewidth=1)
    for name, figures in document["pipelines"].items():
        found = figures["all_films"]
        if "roc" in found:
            colour, style = LINES[name]
            # The last step accepts films without a score, which no threshold does.
            steps = slice(None, -1 if found["roc"]["threshold"][-1] is None else None)
            x = _deviate(np.array(found["roc"]["false_accept"][steps]), found["forged"])
            y = _deviate(1 - np.array(found["roc"]["true_accept"][steps]), found["genuine"])
            axes.plot(x, y, style, color=colour, linewidth=2, label=f"{name}: EER {100 * found['eer']:.1f} %")
    ticks = [float(norm.ppf(rate)) for rate in RATES]
    names = [f"{100 * rate:g}" for rate in RATES]
    axes.set_xticks(ticks, names)
    axes.set_yticks(ticks, names)
    axes.set_xlabel("forged films accepted, %")
    axes.set_ylabel("genuine films not accepted, %")
    axes.set_aspect("equal")
    axes.set_xlim(ends)
    axes.set_ylim(ends)
    plain(axes)
    _legend_or_reason(axes, document)
    return figure


def _accuracy(document: Document) -> Any:
    """Accuracy and balanced accuracy against the threshold, a panel for each pipeline."""
    figure = figure_of(1.0 + 3.6 * len(document["pipelines"]), 3.6)
    panels = figure.subplots(1, len(document["pipelines"]), sharey=True, squeeze=False)[0]
    for axes, (name, figures) in zip(panels, document["pipelines"].items(), strict=True):
        for key, style in (("accuracy", "-"), ("balanced_accuracy", "--")):
            thresholds, values = _steps(figures["all_films"], key, *SHOWN[name])
            axes.plot(
                thresholds,
                values,
                style,
                color=GENUINE,
                linewidth=2,
                label=key.replace("_", " "),
                drawstyle="steps-pre",
            )
        axes.axvline(LIMITS[name], color=INK, linewidth=1, linestyle=":")
        axes.set_xlim(*SHOWN[name])
        axes.set_ylim(0, 1.02)
        axes.set_xlabel(f"accepted from this score, {name}", color=INK)
        plain(axes)
    panels[0].set_ylabel("share of films put right", color=INK)
    _legend_or_reason(panels[0], document)
    return figure


def _tippett(document: Document) -> Any:
    """Shares of genuine and of forged films whose calibrated odds are that great or greater."""
    figure = figure_of(5.6, 4.0)
    axes = figure.add_subplot()
    for name in RATIOS:
        for key, colour, kind in (("true_accept", GENUINE, "genuine"), ("false_accept", FORGED, "forged")):
            found = document["pipelines"].get(name, {}).get("scored_films", {})
            at, shares = _steps(found, key, *SHOWN[name])
            at = [calibrated_log10(score) for score in at]
            axes.plot(at, shares, color=colour, linewidth=2, label=f"{kind} films", drawstyle="steps-pre")
    axes.set_xlim(-1.1 * CALIBRATION_CAP_LOG10, 1.1 * CALIBRATION_CAP_LOG10)
    axes.axvline(0, color=INK, linewidth=1, linestyle=":")
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlabel("decadic logarithm of the calibrated odds", color=INK)
    axes.set_ylabel("share of films with these odds or more", color=INK)
    plain(axes)
    _legend_or_reason(axes, document)
    return figure


def _steps(found: Document, key: str, least: float, most: float) -> tuple[Any, Any]:
    """Thresholds in rising order and a curve's values there, carried on to both edges; nothing where there is no curve.

    Convention: between two scores the value is that of the upper one, which is the next threshold that is met.
    """
    if "roc" not in found:
        return [], []
    # The first step accepts nothing, and one of null is that of films without a score, which no threshold accepts.
    known = [k for k, at in enumerate(found["roc"]["threshold"]) if at is not None][::-1]
    at = np.array([found["roc"]["threshold"][k] for k in known])
    values = np.array([found["roc"][key][k] for k in known] + [found["roc"][key][0]])
    return np.concatenate([[least], at, [most]]), np.concatenate([values[:1], values])


def _deviate(rates: Any, films: int) -> Any:
    """Normal deviates of rates among `films` films."""
    return norm.ppf(np.clip(rates, 0.5 / films, 1 - 0.5 / films))


def _legend_or_reason(axes: Any, document: Document) -> None:
    """Names of the lines, or why there are none."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, fontsize=9, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
        return
    kind = "genuine" if document["genuine"] else "forged"
    axes.text(0.5, 0.5, f"all films are {kind}", ha="center", transform=axes.transAxes, color=INK)


#: Of each file, by its name without the suffix.
PLOTS = {"scores": _scores, "roc": _roc, "det": _det, "accuracy": _accuracy, "tippett": _tippett}
