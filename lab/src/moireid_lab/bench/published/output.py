"""The paper's tables beside ours, as text and as a plot."""

from __future__ import annotations

from typing import Any

from moireid_lab.evaluation.plots import GENUINE, INK, PALE, figure_of, plain

Document = dict[str, Any]


def published_table(result: Document) -> str:
    """A line for each condition and distance, both pipelines side by side."""
    paper = result["paper"]
    lines = [
        f"{'|rho|, windows of 30 frames':<28}{'published pipeline':<55}ours",
        f"{'mean ± deviation of films':<26}{'greatest':>15}{'mean':>15}{'sd':>7}{'range':>14}{'acc.':>6}{'mean':>15}"
        f"{'acc./open/rej.':>16}   paper",
    ]
    for row in result["rows"]:
        theirs, ours = row["published"], row["moireid"]
        least, most = theirs["window_correlation_min"]["values"], theirs["window_correlation_max"]["values"]
        span = f"{min(least):.2f} to {max(most):.2f}" if least else "-"
        verdicts = "/".join(str(_count(ours, verdict)) for verdict in ("accept", "inconclusive", "reject"))
        lines.append(
            f"{row['table'] + ', ' + format(row['distance_m'], 'g') + ' m':<26}{_spread(theirs['score']):>15}"
            f"{_spread(theirs['window_correlation_mean']):>15}{_mean(theirs['window_correlation_sd']):>7}{span:>14}"
            f"{_count(theirs, 'accept'):>6}{_spread(ours['window_correlation_mean']):>15}{verdicts:>16}"
            f"   {row['paper']}"
        )
    told = dict.fromkeys(f"{row['table']}: {row['what']}" for row in result["rows"])
    left_out = sum(row["published"]["without_score"] for row in result["rows"])
    return "\n".join(
        [
            *lines,
            "",
            f"{result['courses']} films a line.  " + "; ".join(list(told)[:2]) + ";",
            "; ".join(list(told)[2:]) + ".",
            "Renderings 1 and 2 are single sweeps, one way, at constant speed: a drift or a delay of the fringes is a",
            "mere constant on them.  These films are our simulator's, the paper's its own; the letters are ours.",
            f"Films without a published score (0 in the paper): {left_out}; they are in no mean.",
            "Paper: its figure for a condition of that description, where it is on record.  Its renderings: "
            f"{paper['renderings']['mean']:.2f}, not known by distance.",
            f"The paper's real recordings: {paper['genuine']['mean']:.2f} ± {paper['genuine']['sd']:.2f}; generated "
            f"films: {paper['forged']['mean']:.2f} ± {paper['forged']['sd']:.2f}; AUC {paper['auc']}; accepted from "
            f"{paper['threshold']}.",
        ]
    )


def published_plot(result: Document) -> Any:
    """|rho| of every film against its distance, or by condition; a panel for each table."""
    figure = figure_of(10.5, 3.6)
    panels = figure.subplots(1, 3, sharey=True)
    names = ("rendering 1", "rendering 2", "A to D")
    for axes, name in zip(panels, names, strict=True):
        rows = [row for row in result["rows"] if (row["table"] if len(row["table"]) > 1 else "A to D") == name]
        for place, row in enumerate(rows):
            for pipeline, key, colour, aside in (
                ("published", "score", PALE, -0.22),
                ("published", "window_correlation_mean", INK, 0.0),
                ("moireid", "window_correlation_mean", GENUINE, 0.22),
            ):
                values = row[pipeline][key]["values"]
                axes.plot([place + aside] * len(values), values, "o", color=colour, markersize=4, alpha=0.7)
        axes.axhline(result["paper"]["threshold"], color=INK, linewidth=1, linestyle=":")
        ticks = [row["table"] if name == "A to D" else f"{row['distance_m']:g}" for row in rows]
        axes.set_xticks(range(len(rows)), ticks)
        axes.set_xlabel(f"{name}" if name == "A to D" else f"{name}: distance, m", color=INK)
        axes.set_ylim(-0.02, 1.03)
        plain(axes)
    panels[0].set_ylabel("|rho|", color=INK)
    figure.suptitle(
        "A dot a film.  Grey: published score, its greatest window; black: its mean window; blue: our mean window; "
        "dotted: published threshold",
        fontsize=8.5,
        color=INK,
        x=0.01,
        ha="left",
    )
    return figure


def _spread(cell: Document) -> str:
    return _mean(cell) if cell["sd"] is None else f"{cell['mean']:.3f} ± {cell['sd']:.3f}"


def _mean(cell: Document) -> str:
    return "-" if cell["mean"] is None else f"{cell['mean']:.3f}"


def _count(figures: Document, verdict: str) -> int:
    return int(figures["verdicts"].get(verdict, 0))
