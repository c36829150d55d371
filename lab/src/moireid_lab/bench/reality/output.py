"""Table and plot of the reality suite."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from moireid.simulate.effects.table import KINDS, STRENGTHS
from moireid_lab.bench.reality.cases import NOTHING, TRUE
from moireid_lab.bench.verdicts import COLOURS, VERDICTS

Row = dict[str, Any]
#: Shades of the strengths, from light to strong.
SHADES = {"light": "#9fb4c7", "ordinary": "#22577a", "strong": "#0b2239"}
WIDTH = 34


def reality_table(result: dict[str, Any]) -> str:
    """Verdicts, gain error, residual and time of every effect, strength and distance; then the forged films."""
    head = f"{'accept':>8}{'open':>6}{'reject':>8}{'gain error':>12}{'residual':>10}{'s a film':>10}  reasons"
    lines = [f"{'true badge':<{WIDTH}}{head}"]
    lines += [_line(key, rows) for key, rows in groups(result, true=True).items()]
    if forged := groups(result, true=False):
        lines += ["", f"{'forged badge':<{WIDTH}}{head}"]
        lines += [_line(key, rows) for key, rows in forged.items()]
    return "\n".join([*lines, "", *summary(result)])


def groups(result: dict[str, Any], *, true: bool) -> dict[tuple[str, str, float], list[Row]]:
    """Rows by effect, strength and distance, in the order of the effects; forged ones of all kinds together."""
    found: dict[tuple[str, str, float], list[Row]] = {}
    for row in result["rows"]:
        if (row["badge"] == TRUE) == true:
            found.setdefault((row["effect"], row["strength"], row["distance_m"]), []).append(row)
    effects = [NOTHING, *KINDS]
    return dict(
        sorted(found.items(), key=lambda one: (effects.index(one[0][0]), STRENGTHS.index(one[0][1]), one[0][2]))
    )


def summary(result: dict[str, Any]) -> list[str]:
    """Shares at the ordinary strength: of the true films accepted and rejected, of the forged ones accepted."""
    rows = [row for row in result["rows"] if row["strength"] == "ordinary" and row["effect"] != NOTHING]
    lines = []
    for true in (True, False):
        verdicts = Counter(row["verdict"] for row in rows if (row["badge"] == TRUE) == true)
        if count := sum(verdicts.values()):
            told = ", ".join(f"{label} {verdicts[key]}" for key, label in VERDICTS.items())
            lines.append(f"{'true' if true else 'forged'} films at ordinary strength: {count} ({told})")
    return lines


def gain_error(rows: list[Row]) -> float:
    """Root mean square distance of the gain from 1, over the films that have one; nan without any."""
    gains = [row["gain"] for row in rows if row["gain"] is not None]
    return float(np.sqrt(np.mean(np.square(np.array(gains) - 1)))) if gains else float("nan")


def residual(rows: list[Row]) -> float:
    """Median residual of the phase, rad, over the films that have one; nan without any."""
    found = [row["residual_rad"] for row in rows if row["residual_rad"] is not None]
    return float(np.median(found)) if found else float("nan")


def _line(key: tuple[str, str, float], rows: list[Row]) -> str:
    effect, strength, distance = key
    counts = Counter(row["verdict"] for row in rows)
    why = Counter(code for row in rows for code in row["why"]).most_common(3)
    seconds = sum(row["seconds"] for row in rows) / len(rows)
    name = f"{effect} {strength if effect != NOTHING else ''}".strip()
    return (
        f"{name:<{WIDTH - 5}}{distance:>3g} m{counts['accept']:>8}{counts['inconclusive']:>6}{counts['reject']:>8}"
        f"{gain_error(rows):>12.3f}{residual(rows):>10.3f}{seconds:>10.1f}  {', '.join(code for code, _ in why)}"
    ).rstrip()


def reality_plot(result: dict[str, Any]) -> Any:
    """For each effect: the verdicts on true films by strength, and gain error, residual and run time."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    found = groups(result, true=True)
    effects = list(dict.fromkeys(effect for effect, _, _ in found))
    figure = Figure(figsize=(11, 0.36 * max(len(effects), 1) + 1.4), layout="constrained")
    FigureCanvasSVG(figure)
    shares, *others = figure.subplots(1, 4, sharey=True, width_ratios=(2, 1, 1, 1))
    for place, strength in enumerate(STRENGTHS):
        rows = {effect: _both(found, effect, strength) for effect in effects}
        _bars(shares, [rows[effect] for effect in effects], 0.27 * (place - 1), label=place == 0)
        for axes, measure in zip(others, (gain_error, residual, _seconds), strict=True):
            values = [measure(rows[effect]) if rows[effect] else float("nan") for effect in effects]
            axes.plot(values, range(len(effects)), "o", ms=4, color=SHADES[strength], label=strength)
    shares.set_yticks(range(len(effects)), effects, fontsize=8)
    shares.set(xlabel="share of true films", xlim=(0, 1), ylim=(len(effects) - 0.5, -0.5))
    shares.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)
    for axes, label in zip(others, ("gain error", "residual, rad", "verify, s a film"), strict=True):
        axes.set(xlabel=label)
        axes.grid(axis="y", alpha=0.2)
    figure.legend(
        handles=others[0].lines[: len(STRENGTHS)], frameon=False, ncols=3, loc="outside upper right", fontsize=8
    )
    return figure


def _both(found: dict[tuple[str, str, float], list[Row]], effect: str, strength: str) -> list[Row]:
    """Rows of all distances."""
    return [row for (one, how, _), rows in found.items() if (one, how) == (effect, strength) for row in rows]


def _bars(axes: Any, films: list[list[Row]], offset: float, *, label: bool) -> None:
    """One thin bar an effect: share of its films by verdict."""
    begins = np.zeros(len(films))
    for verdict, name in VERDICTS.items():
        shares = [sum(row["verdict"] == verdict for row in rows) / max(len(rows), 1) for rows in films]
        places = np.arange(len(films)) + offset
        axes.barh(places, shares, 0.24, left=begins, color=COLOURS[verdict], label=name if label else None)
        begins += shares


def _seconds(rows: list[Row]) -> float:
    return float(np.mean([row["seconds"] for row in rows]))
