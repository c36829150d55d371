"""Table and plot of the simulate suite."""

from __future__ import annotations

import textwrap
from typing import Any

from moireid_lab.bench.simulate.left_out import left_out_table

#: Colours of the renderers in plots.
_COLOURS = ("#1f6fb2", "#7fb3d9", "#c2571a", "#e0a070")


def simulate_table(result: dict[str, Any]) -> str:
    """The simulate suite as text."""
    lines = [
        f"{'against the outside tracer':<37}{'phase':>8}{'at 60':>8}{'image':>8}{'at 60':>8}"
        f"{'usual':>9}{'estimate':>10}{'image':>8}"
    ]
    for row in result["against"]:
        fine, usual = row["fine"], row["usual"]
        lines.append(
            f"{row['name']:<37}{_rad(fine['phase_rad']):>8}{_rad(fine['steep_phase_rad']):>8}"
            f"{_percent(fine['image']):>8}{_percent(fine['steep_image']):>8}{_rad(usual['phase_rad']):>9}"
            f"{_rad(row['estimate_rad']):>10}{_percent(usual['image']):>8}"
        )
    lines += [
        "",
        f"{'renderer':<24}{'camera':>8}{'setting':>12}{'ms':>10}{'least':>9}{'spread':>9}{'phase':>9}{'image':>8}",
    ]
    for row in result["work"]:
        setting = " x ".join(map(str, row["setting"]))
        lines.append(
            f"{row['renderer']:<24}{row['camera']:>8}{setting:>12}{1e3 * row['seconds']:>10.2f}"
            f"{1e3 * row['seconds_least']:>9.2f}{1e3 * row['seconds_spread']:>9.2f}{_rad(row['phase_rad']):>9}"
            f"{_percent(row['image']):>8}"
        )
    lines += ["", speed_sentence(result), "", *left_out_table(result["left_out"])]
    return "\n".join(lines)


def speed_sentence(result: dict[str, Any]) -> str:
    """How the two renderers compare, in a sentence."""
    speed = result["speed"]
    if speed is None:
        return "no set-up of Mitsuba was measured that errs as much as an analytic setting"
    return (
        f"at equal phase error ({speed['phase_rad']:.4f} rad, {speed['camera']}) the analytic renderer is "
        f"{speed['times']:.0f} times faster than the best set-up of {speed['mitsuba']} "
        f"({speed['setting'][0]} rays, {speed['setting'][1]} segments)"
    )


def simulate_plot(result: dict[str, Any]) -> Any:
    """Seconds a frame against phase error, and against image error, both log."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(11, 4.2), layout="constrained")
    FigureCanvasSVG(figure)
    plots = figure.subplots(1, 2, sharey=True)
    rows = [row for row in result["work"] if row["phase_rad"]]
    renderers = list(dict.fromkeys(row["renderer"] for row in rows))
    marks = dict(zip(dict.fromkeys(row["camera"] for row in rows), "os^", strict=False))
    for axes, error in zip(plots, ("phase_rad", "image"), strict=True):
        for renderer, colour in zip(renderers, _COLOURS, strict=False):
            for camera, mark in marks.items():
                some = [row for row in rows if row["renderer"] == renderer and row["camera"] == camera]
                some.sort(key=lambda row: row["setting"][0] * row["setting"][1])
                line = "-" if renderer == "analytic" else ""
                axes.loglog(
                    [row[error] for row in some],
                    [row["seconds"] for row in some],
                    mark + line,
                    color=colour,
                    label=f"{renderer}, {camera}" if some else None,
                    alpha=0.85,
                )
        axes.grid(color="#e4e8ed", which="both")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.spines[["top", "right"]].set_visible(False)
    plots[0].set_xlabel("phase error, rad (RMS)")
    plots[1].set_xlabel("brightness error, share of the contrast (RMS)")
    plots[0].set_ylabel("seconds a frame")
    figure.legend(*plots[0].get_legend_handles_labels(), loc="outside right center", frameon=False, fontsize=8)
    figure.suptitle(textwrap.fill(speed_sentence(result), 100), fontsize=9)
    return figure


def _rad(figure: float | None) -> str:
    return "-" if figure is None else f"{figure:.4f}"


def _percent(figure: float | None) -> str:
    return "-" if figure is None else f"{100 * figure:.2f}%"
