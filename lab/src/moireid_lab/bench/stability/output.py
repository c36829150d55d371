"""Table and plot of the stability suite."""

from __future__ import annotations

from typing import Any


def stability_table(result: dict[str, Any]) -> str:
    """The stability suite as text."""
    lines = [f"{'case':<36}{'outcome':<12}{'verdict':<14}{'mended':>7}{'tracked':>9}  why"]
    lines += [
        f"{row['name']:<36}{row['outcome']:<12}{row['verdict']:<14}{row['symbols_corrected']:>7}"
        f"{row['tracked']:>5}/{row['frames']:<3}  {row['why']}"
        for row in result["rows"]
    ]
    if result.get("scenes"):
        lines += ["", f"{'renderer on':<38}{'outcome':<10}{'phase, rad (bar)':>19}{'image (bar)':>18}  why"]
        lines += [
            f"{row['name']:<38}{row['outcome']:<10}{_with_bar(row, 'phase_rad', 'bar_rad'):>19}"
            f"{_with_bar(row, 'image', 'bar_image'):>18}  {row['why']}"
            for row in result["scenes"]
        ]
    return "\n".join(lines)


def _with_bar(row: dict[str, Any], figure: str, bar: str) -> str:
    """A figure and its error bar, or a dash."""
    return "-" if row.get(figure) is None else f"{row[figure]:.4f} ({row[bar]:.4f})"


def stability_plot(result: dict[str, Any]) -> Any:
    """One bar a case: frames in which the badge was followed, coloured by outcome."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    rows = result["rows"][::-1]
    colours = {"right": "#2e7d4f", "unreadable": "#8a97a6", "refused": "#c9a227", "wrong": "#c0392b"}
    figure = Figure(figsize=(7, 0.24 * len(rows) + 1), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    for outcome, colour in colours.items():
        some = [(k, row["tracked"] / row["frames"]) for k, row in enumerate(rows) if row["outcome"] == outcome]
        axes.barh([k for k, _ in some], [share for _, share in some], color=colour, label=f"{outcome}: {len(some)}")
    axes.set_yticks(range(len(rows)), [row["name"] for row in rows], fontsize=8)
    axes.set_xlabel("share of frames in which the badge was followed")
    axes.legend(frameon=False, ncols=4, loc="lower left", bbox_to_anchor=(0, 1))
    axes.spines[["top", "right"]].set_visible(False)
    return figure
