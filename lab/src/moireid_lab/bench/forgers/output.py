"""Table and plot of the forgers suite."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from moireid_lab.bench.verdicts import COLOURS, VERDICTS

HEADINGS = {False: "forged", True: "genuine, as hands and editors spoil it"}


def forgers_table(result: dict[str, Any]) -> str:
    """Verdicts of each case, and why those that were not accepted were not."""
    lines = [f"{HEADINGS[False]:<58}{'accept':>8}{'open':>6}{'reject':>8}  s a film  most frequent reason"]
    for genuine in (False, True):
        if genuine:
            lines += ["", HEADINGS[True]]
        lines += [_line(name, rows) for name, rows in by_case(result, genuine).items()]
    return "\n".join(lines)


def _line(name: str, rows: list[dict[str, Any]]) -> str:
    counts = Counter(row["verdict"] for row in rows)
    why = Counter(code for row in rows for code in row["why"]).most_common(1)
    seconds = sum(row["seconds"] for row in rows) / len(rows)
    return (
        f"{name:<58}{counts['accept']:>8}{counts['inconclusive']:>6}{counts['reject']:>8}{seconds:>10.1f}  "
        f"{why[0][0] if why else ''}"
    )


def by_case(result: dict[str, Any], genuine: bool) -> dict[str, list[dict[str, Any]]]:
    """Rows of each case, in the order of the suite."""
    cases: dict[str, list[dict[str, Any]]] = {}
    for row in result["rows"]:
        if row["genuine"] == genuine:
            cases.setdefault(row["case"], []).append(row)
    return cases


def forgers_plot(result: dict[str, Any]) -> Any:
    """One bar a case: share of its films by verdict."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    groups = {genuine: by_case(result, genuine) for genuine in (False, True)}
    # A row for each case, and an empty one with the heading of each group, from the top.
    rows = [row for genuine, cases in groups.items() if cases for row in ((HEADINGS[genuine], []), *cases.items())]
    figure = Figure(figsize=(8, 0.18 * len(rows) + 1), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    begins = np.zeros(len(rows))
    for verdict, label in VERDICTS.items():
        shares = [sum(film["verdict"] == verdict for film in films) / max(len(films), 1) for _, films in rows]
        axes.barh(range(len(rows)), shares, left=begins, color=COLOURS[verdict], label=label)
        begins += shares
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=7)
    for mark, (_, films) in zip(axes.get_yticklabels(), rows, strict=True):
        mark.set_fontweight("normal" if films else "bold")
    axes.set(xlabel="share of films", xlim=(0, 1), ylim=(len(rows) - 0.5, -0.5))
    axes.tick_params(axis="y", length=0)
    axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    axes.spines[["top", "right", "left"]].set_visible(False)
    return figure
