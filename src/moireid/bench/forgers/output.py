"""Table and plot of the forgers suite."""

from __future__ import annotations

from collections import Counter
from typing import Any

VERDICTS = ("accept", "inconclusive", "reject")
COLOURS = {"accept": "#2e7d4f", "inconclusive": "#8a97a6", "reject": "#c0392b"}


def forgers_table(result: dict[str, Any]) -> str:
    """Verdicts of each case, and why those that were not accepted were not."""
    lines = [f"{'forged':<58}{'accept':>8}{'open':>6}{'reject':>8}  s a film  most frequent reason"]
    for genuine in (False, True):
        if genuine:
            lines += ["", "genuine, as hands and editors spoil it"]
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

    cases = [(name, rows) for genuine in (False, True) for name, rows in by_case(result, genuine).items()][::-1]
    figure = Figure(figsize=(8, 0.22 * len(cases) + 1), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    begins = [0.0] * len(cases)
    for verdict in VERDICTS:
        shares = [sum(row["verdict"] == verdict for row in rows) / len(rows) for _, rows in cases]
        axes.barh(range(len(cases)), shares, left=begins, color=COLOURS[verdict], label=verdict)
        begins = [begin + share for begin, share in zip(begins, shares, strict=True)]
    axes.set_yticks(range(len(cases)), [name for name, _ in cases], fontsize=7)
    axes.set_xlabel("share of films")
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    axes.spines[["top", "right"]].set_visible(False)
    return figure
