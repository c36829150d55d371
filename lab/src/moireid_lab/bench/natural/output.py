"""Table and plot of the natural suite."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from moireid_lab.bench.natural.cases import DISTANCES_M, MOTIONS

Row = dict[str, Any]
#: Films with this much motion, rad, hold enough of it for a verdict.
ENOUGH_RAD = 0.3
#: From the worst verdict to the best one.
ORDER = ("reject", "inconclusive", "accept")
COLOURS = dict(zip(MOTIONS, ("#22577a", "#d98a3d", "#7a8a5a"), strict=True))
STYLES = dict(zip(DISTANCES_M, ("-", "--"), strict=True))


def natural_table(result: dict[str, Any]) -> str:
    """Verdicts, log odds and judge time for each motion, distance and length; then the nested pairs."""
    head = (
        f"{'true badge':<18}{'length':>6}{'films':>7}{'accepted':>10}{'inconclusive':>14}{'rejected':>10}"
        f"{f'of >= {ENOUGH_RAD:g} rad':>15}{'log10 odds':>12}{'ms a film':>11}{'ms a frame':>12}  reasons"
    )
    lines = [_line(key, rows) for key, rows in groups(result).items()]
    worse, count = nested_pairs(result["rows"])
    pairs = f"the longer part's verdict is worse than that of a part inside it: {worse} of {count} pairs"
    return "\n".join([head, *lines, "", pairs])


def groups(result: dict[str, Any]) -> dict[tuple[str, float, int], list[Row]]:
    """Rows by motion, distance and length, in the order of the motions."""
    found: dict[tuple[str, float, int], list[Row]] = {}
    for row in result["rows"]:
        found.setdefault((row["motion"], row["distance_m"], row["seconds"]), []).append(row)
    return dict(sorted(found.items(), key=lambda one: (MOTIONS.index(one[0][0]), *one[0][1:])))


def nested_pairs(rows: list[Row]) -> tuple[int, int]:
    """Pairs of a part and a longer one around it: how many have a worse verdict on the longer one, and how many are."""
    films: dict[tuple[str, float, int], list[Row]] = {}
    for row in rows:
        films.setdefault((row["motion"], row["distance_m"], row["seed"]), []).append(row)
    pairs = [(inner, outer) for parts in films.values() for inner in parts for outer in parts if _inside(inner, outer)]
    worse = sum(ORDER.index(outer["verdict"]) < ORDER.index(inner["verdict"]) for inner, outer in pairs)
    return worse, len(pairs)


def _inside(inner: Row, outer: Row) -> bool:
    """Whether a part is inside a longer one of its film."""
    begins_later = inner["start_s"] >= outer["start_s"]
    ends_earlier = inner["start_s"] + inner["seconds"] <= outer["start_s"] + outer["seconds"]
    return bool(inner["seconds"] < outer["seconds"] and begins_later and ends_earlier)


def accepted_share(rows: list[Row]) -> float:
    """Share of the rows that are accepted, 0 to 1."""
    return float(np.mean([row["verdict"] == "accept" for row in rows]))


def median_odds(rows: list[Row]) -> float:
    """Median of the log10 odds, over the rows that have them; nan without any."""
    scores = [row["score"] for row in rows if row["score"] is not None]
    return float(np.median(scores)) if scores else float("nan")


def with_enough_motion(rows: list[Row]) -> list[Row]:
    """The rows with at least `ENOUGH_RAD` of motion."""
    return [row for row in rows if (row["excitation_rad"] or 0.0) >= ENOUGH_RAD]


def _line(key: tuple[str, float, int], rows: list[Row]) -> str:
    motion, distance, seconds = key
    counts = Counter(row["verdict"] for row in rows)
    enough = with_enough_motion(rows)
    moved = f"{sum(row['verdict'] == 'accept' for row in enough)} of {len(enough)}"
    judge_s = sum(row["judge_s"] for row in rows)
    a_frame = 1e3 * judge_s / max(sum(row["frames"] for row in rows), 1)
    why = Counter(code for row in rows for code in row["why"]).most_common(3)
    return (
        f"{motion:<12}{distance:>4g} m{seconds:>6} s{len(rows):>7}{counts['accept']:>10}{counts['inconclusive']:>14}"
        f"{counts['reject']:>10}{moved:>15}{median_odds(rows):>12.2f}{1e3 * judge_s / len(rows):>11.0f}{a_frame:>12.2f}"
        f"  {', '.join(code for code, _ in why)}"
    ).rstrip()


def natural_plot(result: dict[str, Any]) -> Any:
    """Share of accepted parts and median log10 odds against the parts' length, a line for each motion and distance."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    found = groups(result)
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    FigureCanvasSVG(figure)
    shares, odds = figure.subplots(1, 2)
    lengths = sorted({seconds for _, _, seconds in found})
    for motion, distance in dict.fromkeys((motion, distance) for motion, distance, _ in found):
        own = {seconds: rows for (*film, seconds), rows in found.items() if film == [motion, distance]}
        look = {"color": COLOURS[motion], "ls": STYLES[distance], "marker": "o", "ms": 4}
        for axes, measure in ((shares, accepted_share), (odds, median_odds)):
            axes.plot(list(own), [measure(rows) for rows in own.values()], label=f"{motion} {distance:g} m", **look)
    for axes, label in ((shares, "share accepted"), (odds, "median log10 odds")):
        axes.set(xlabel="length, s", ylabel=label, xscale="log")
        axes.set_xticks(lengths, [str(seconds) for seconds in lengths])
        axes.minorticks_off()
        axes.grid(alpha=0.2)
        axes.spines[["top", "right"]].set_visible(False)
    shares.set_ylim(-0.05, 1.05)
    figure.legend(handles=shares.lines, frameon=False, ncols=6, loc="outside upper center", fontsize=8)
    return figure
