"""Table and plot of the verify suite."""

from __future__ import annotations

from typing import Any

from moireid_lab.bench.verify.suite import both_rad

#: Colours of the working resolutions, and marks of the frames used.
COLOURS = {1.0: "#12406b", 0.75: "#1f6fb2", 0.5: "#3fa7a0", 1 / 3: "#c9a227"}
MARKS = {1: "o", 2: "s", 3: "^", 4: "D"}
OTHERS = {
    "focal length given": "#2e7d4f",
    "nothing solved": "#8a5aa8",
    "poses not smoothed": "#c2571a",
    "published": "#7a1f1f",
}


def verify_table(result: dict[str, Any]) -> str:
    """The verify suite as text."""
    lines = [
        f"{'setting':<36}{'fringes':>9}{'poses':>9}{'gain':>8}{'right':>8}{'CPU ms':>9}{'spread':>8}{'decodings':>11}"
        f"{'ms':>8}{'spread':>8}{'decodings':>11}"
    ]
    knee = result["knee"]
    for row in result["work"]:
        lines.append(
            f"{setting_name(row['setting']):<36}{_figure(row['phase_rad'], 4):>9}{_figure(row['pose_rad'], 4):>9}"
            f"{_figure(row['gain_error'], 4):>8}{row['right']:>6}/{row['films']}{row['cpu_ms']:>9.2f}"
            f"{row['cpu_ms_spread']:>8.2f}{row['cpu_ms_to_decoding']:>11.2f}{row['ms']:>8.1f}{row['ms_spread']:>8.1f}"
            f"{row['ms_to_decoding']:>11.2f}{_marks(row, knee)}"
        )
    lines += ["", knee_sentence(result), ""]
    lines.append(f"{'motion':<38}{'expected':<15}{'came out':<14}{'':<7}{'rad':>6}{'gain':>17}{'tracked':>11}  why")
    for row in result["extremes"]:
        outcome = "WRONG" if row["outcome"] == "wrong" else row["outcome"]
        gain = "-" if row["gain_ratio"] is None else f"{row['gain_ratio']:.3f} ± {_figure(row['gain_sd'], 3)}"
        lines.append(
            f"{row['name']:<38}{row['expected']:<15}{row['verdict'] or '-':<14}{outcome:<7}"
            f"{_figure(row['true_excitation_rad'], 2):>6}{gain:>17}{row['tracked']:>6}/{row['frames']:<4}  {row['why']}"
        )
    return "\n".join(lines)


def setting_name(setting: dict[str, Any]) -> str:
    """A setting in words."""
    if setting["estimator"] != "ours":
        return str(setting["estimator"])
    frames = {1: "every frame", 2: "every 2nd frame", 3: "every 3rd frame"}.get(setting["every"])
    share = {1.0: "", 0.75: ", 3/4 size", 0.5: ", 1/2 size"}.get(setting["scale"], ", 1/3 size")
    return f"{frames or 'every 4th frame'}{share}"


def knee_sentence(result: dict[str, Any]) -> str:
    """Where the knee is, and how far from it the default stands, in a sentence."""
    knee = result["knee"]
    if knee is None:
        return "no setting judges all films right"
    default = next(row for row in result["work"] if row["default"])
    if knee["default"]:
        return "the default is at the knee: of the settings that judge all films right it has the least error x time"
    return (
        f"the knee is at {setting_name(knee['setting'])}: {both_rad(knee):.4f} rad in {knee['cpu_ms']:.2f} CPU ms; the "
        f"default has {both_rad(default):.4f} rad in {default['cpu_ms']:.2f} CPU ms a frame of the film"
    )


def verify_plot(result: dict[str, Any]) -> Any:
    """CPU milliseconds a frame against the errors of phase, of gain, and of the verdict."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(12, 4.6), layout="constrained")
    FigureCanvasSVG(figure)
    plots = figure.subplots(1, 3, sharey=True, width_ratios=(3, 3, 2))
    xs = {
        0: lambda row: both_rad(row) if row["pose_rad"] else row["phase_rad"],
        1: lambda row: row["gain_error"],
        2: lambda row: 100 * (1 - row["right"] / row["films"]),
    }
    for place, axes in enumerate(plots):
        _panel(axes, result, xs[place])
        axes.set_yscale("log")
        if place < 2:
            axes.set_xscale("log")
        for scale in (axes.xaxis, axes.yaxis)[0 if place < 2 else 1 :]:
            scale.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            scale.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            scale.set_minor_formatter(NullFormatter())
        axes.grid(color="#e4e8ed", which="both", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    plots[0].set_ylabel("CPU milliseconds a frame of the film")
    plots[0].set_xlabel("phase error of fringes and poses, rad (RMS)")
    plots[1].set_xlabel("error of the gain ratio (RMS)")
    plots[2].set_xlabel("verdicts that are not right, %")
    figure.legend(*plots[0].get_legend_handles_labels(), loc="outside right center", frameon=False, fontsize=8)
    figure.suptitle(knee_sentence(result), fontsize=9)
    return figure


def _panel(axes: Any, result: dict[str, Any], error: Any) -> None:
    """All settings of one error; the default is starred, the knee ringed."""
    for scale, colour in COLOURS.items():
        own = [
            row for row in result["work"] if row["setting"]["estimator"] == "ours" and row["setting"]["scale"] == scale
        ]
        own = [row for row in own if error(row) is not None]
        if not own:
            continue
        axes.plot([error(row) for row in own], [row["cpu_ms"] for row in own], color=colour, linewidth=1, alpha=0.6)
        for row in own:
            # Films that a setting cannot read are missing in its errors, so settings with a wrong verdict are hollow.
            face = colour if row["right"] == row["films"] else "white"
            axes.plot(error(row), row["cpu_ms"], MARKS[row["setting"]["every"]], color=colour, mfc=face, markersize=6)
        name = {1.0: "full size", 0.75: "3/4 size", 0.5: "1/2 size"}.get(scale, "1/3 size")
        axes.plot([], [], "-", color=colour, linewidth=3, label=name)
    for every, mark in MARKS.items():
        words = {1: "every frame", 2: "every 2nd", 3: "every 3rd"}.get(every, "every 4th")
        axes.plot([], [], mark, color="#5a6673", markersize=6, label=words)
    axes.plot([], [], "o", color="#5a6673", mfc="white", markersize=6, label="hollow: a verdict is not right")
    for row in result["work"]:
        name = row["setting"]["estimator"]
        if name in OTHERS and error(row) is not None:
            axes.plot(error(row), row["cpu_ms"], "P", color=OTHERS[name], markersize=9)
        if name in OTHERS:
            axes.plot([], [], "P", color=OTHERS[name], markersize=9, label=name)
        if row["default"] and error(row) is not None:
            axes.plot(error(row), row["cpu_ms"], "*", color="#12406b", mec="white", markersize=17, zorder=5)
    axes.plot([], [], "*", color="#12406b", markersize=11, label="the default")
    knee = result["knee"]
    if knee is not None:
        axes.plot(error(knee), knee["cpu_ms"], "o", mfc="none", mec="#c0392b", mew=1.6, markersize=15, zorder=6)
        axes.plot([], [], "o", mfc="none", mec="#c0392b", mew=1.6, markersize=11, label="the knee")


def _marks(row: dict[str, Any], knee: dict[str, Any] | None) -> str:
    default = "  default" if row["default"] else ""
    return default + ("  knee" if knee is not None and row["setting"] == knee["setting"] else "")


def _figure(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
