"""Table, JSON and plot of a suite."""

from __future__ import annotations

import json
import os
import platform
from pathlib import Path
from typing import Any

from moireid import __version__
from moireid.bench.mount_extremes import extremes_table
from moireid.bench.simulate_output import simulate_plot, simulate_table
from moireid.files import planned, whole_file, write_text


def outputs(folder: Path, suite: str) -> list[Path]:
    """The files that a suite writes."""
    return [folder / f"{suite}.json", folder / f"{suite}.svg"]


def write(folder: Path, result: dict[str, Any], *, overwrite: bool) -> list[Path]:
    """Write the suite's JSON, with machine and versions, and its plot; whole or not at all."""
    data, plot = outputs(folder, result["suite"])
    planned([data, plot], overwrite=overwrite)
    machine = {"processor": platform.machine(), "cores": os.cpu_count(), "python": platform.python_version()}
    document = {"moireid": __version__, "machine": machine} | result
    write_text(data, json.dumps(document, indent=1) + "\n")
    with whole_file(plot) as temporary:
        PLOTS[result["suite"]](result).savefig(temporary, format="svg", metadata={"Date": None})
    return [data, plot]


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


def fabricate_table(result: dict[str, Any]) -> str:
    """The fabricate suite as text."""
    lines = [
        f"{'page':<8}{'dpi':>5} {'raster':<13}{'edges off, dots RMS / worst':>28}{'um':>6}{'pitch, ppm':>12}"
        f"{'markers':>10}{'read':>8}{'wrong':>7}{'ms':>7}{'kB':>6}"
    ]
    for row in result["pages"]:
        for raster in ("poppler", "poppler-grey", "ghostscript"):
            if (seen := row.get(raster)) is None:
                continue
            lines.append(
                f"{row['form']:<8}{row['dpi']:>5} {raster:<13}{seen['rms_dots']:>21.2f} / {seen['worst_dots']:.2f}"
                f"{seen['worst_um']:>7.1f}{seen['pitch_ppm']:>12.1f}{seen['all_markers']:>7}/{seen['badges']:<2}"
                f"{seen['read']:>5}/{seen['badges']:<2}{seen['wrong_payloads']:>7}{1e3 * row['seconds']:>7.0f}"
                f"{row['kilobytes']:>6.0f}"
            )
    alone = result["pdf_alone"]
    lines += [
        "", "PDF, preview and assembly sheet alone (print NAME --mount none, interpreter and all): "
        f"{alone['seconds']:.2f} s, of which {alone['cpu_seconds']:.2f} s of processor time; "
        f"{alone['ratio']:.1f} times an interpreter that imports numpy and reportlab",
        "", f"{'page at the edge':<40}{'outcome':<9}{'edge, dots':>11}{'cell, rad':>11}  granted",
    ]  # fmt: skip
    for row in result["page_extremes"]:
        seen = [row[raster] for raster in ("poppler", "ghostscript") if raster in row]
        worst, phase = (max((one[name] for one in seen), default=0.0) for name in ("worst_dots", "cell_phase_rad"))
        lines.append(f"{row['case']:<40}{row['outcome']:<9}{worst:>11.2f}{phase:>11.3f}  {row['asked']}")
        lines += [f"{'':<4}{said}" for said in row["said"]]
    lines += ["", f"{'mount, facets rad':<22}{'seconds':>9}{'kB':>8}{'triangles':>11}{'chord error, mm':>17}"]
    lines += [
        f"{row['angle_rad']:<22g}{row['seconds']:>9.2f}{row['kilobytes']:>8.0f}{row['triangles']:>11}"
        f"{row['chord_error_mm']:>17.4f}{'  default' if row['default'] else ''}"
        for row in result["mounts"]
    ]
    return "\n".join([*lines, "", extremes_table(result["mount_extremes"]), "", _calibration(result["calibration"])])


def _calibration(found: dict[str, Any]) -> str:
    """What photographs of the pitch test sheet tell, in a sentence."""
    if not found["read"]:
        return f"pitch test sheet: none of {found['photographs']} photographs could be read"
    return (
        f"pitch test sheet: {found['read']} of {found['photographs']} photographs read, lens pitch off by "
        f"{found['median_error_percent']:.4f} % (median) and {found['worst_error_percent']:.4f} % (worst), "
        f"{found['rms_in_sd']:.2f} of the stated standard deviations (RMS)"
    )


def fabricate_plot(result: dict[str, Any]) -> Any:
    """Edge error against resolution for each form of the page; chord error against seconds and size of the mesh."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 3.6), layout="constrained")
    FigureCanvasSVG(figure)
    pages, *meshes = figure.subplots(1, 3, width_ratios=(1.3, 1, 1))
    _plot_edges(pages, result["pages"])
    for axes, key, label in zip(
        meshes, ("seconds", "kilobytes"), ("meshing and writing, s", "mount.stl, kB"), strict=True
    ):
        rows = result["mounts"]
        errors = [1e3 * row["chord_error_mm"] for row in rows]
        axes.loglog([row[key] for row in rows], errors, "o-", color="#1f6fb2")
        for row, error in zip(rows, errors, strict=True):
            words = f"{row['angle_rad']:g} rad" + (" (default)" if row["default"] else "")
            axes.annotate(words, (row[key], error), (6, 5), textcoords="offset points", fontsize=8)
            if row["default"]:
                axes.plot(row[key], error, "o", ms=12, mfc="none", color="#c2571a")
        axes.set_xlabel(label)
        axes.set_ylabel("worst chord error of the mount, um")
        axes.margins(x=0.3, y=0.15)
    for axes in (pages, *meshes):
        axes.grid(color="#e4e8ed", which="major")
        axes.spines[["top", "right"]].set_visible(False)
    return figure


def _plot_edges(axes: Any, pages: list[dict[str, Any]]) -> None:
    """Worst edge of each form at each resolution, worse of the rasters of one bit, and greyed for the plain vector."""
    styles = {
        ("dots", False): ("o-", "#1f6fb2", "dots (default)"), ("bitmap", False): ("s--", "#2e7d4f", "bitmap"),
        ("vector", False): ("^-", "#c2571a", "vector, one bit a dot"),
        ("vector", True): ("v:", "#c2571a", "vector, greyed"),
    }  # fmt: skip
    for (form, grey), (line, colour, label) in styles.items():
        places, worst = [], []
        for row in pages:
            rasters = ("poppler-grey",) if grey else ("poppler", "ghostscript")
            seen = [row[raster]["worst_um"] for raster in rasters if raster in row]
            if row["form"] == form and seen:
                places.append(row["dpi"])
                worst.append(max(seen))
        # Forms lie on one another where all keep to half a dot, so the later ones are drawn open.
        axes.loglog(places, worst, line, color=colour, label=label, mfc="none" if line != "o-" else colour, ms=8)
    places = sorted({row["dpi"] for row in pages})
    axes.loglog(places, [25400 / dpi / 2 for dpi in places], color="#8a97a6", lw=6, alpha=0.35, label="half a dot")
    axes.set_xticks(places, [str(dpi) for dpi in places])
    axes.set_yticks([5, 10, 20, 40], ["5", "10", "20", "40"])
    axes.minorticks_off()
    axes.set_xlabel("dots per inch")
    axes.set_ylabel("worst edge off its place, um")
    axes.legend(frameon=False, fontsize=8)


TABLES = {
    "identity": lambda result: identity_table(result), "stability": stability_table, "fabricate": fabricate_table,
    "simulate": simulate_table,
}  # fmt: skip
PLOTS = {
    "identity": lambda result: identity_plot(result),
    "stability": stability_plot,
    "fabricate": fabricate_plot,
    "simulate": simulate_plot,
}


def identity_table(result: dict[str, Any]) -> str:
    """The identity suite as text."""
    names = ("cell errors", "phase rms", "beat error", "decode s")
    head = f"{'clips':<18}{'read':>9}{'wrong':>7}{'accepted':>10}" + "".join(f"{name:>13}" for name in names)
    lines = [head]
    for row in result["conditions"]:
        lines.append(
            f"{row['name']:<18}{row['read']:>5}/{row['clips']:<3}{row['wrong_payloads']:>7}{row['accepted']:>10}"
            f"{row['wrong_cells']:>13.5f}{row['phase_rms_rad']:>13.4f}{row['beat_error_worst']:>13.5f}{row['identity_s']:>13.3f}"
        )
    lines.append("")
    for kind, counts in result["built"].items():
        told = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())
        lines.append(f"films of the {kind:<9} told as: {told}")
    lines.append("")
    lines += _matching_lines(result["matching"])
    lines.append("")
    lines.append(
        f"{'clips cut short':<18}{'frames':>7}{'cell errors':>13}{'soft':>7}{'hard':>7}{'measure':>10}{'decode ms':>11}"
    )
    for row in result["shorter"]:
        lines.append(
            f"{row['name']:<18}{row['frames']:>12}{row['cells_wrong']:>12.5f}{row['soft_read']:>12.2f}"
            f"{row['hard_read']:>12.2f}{row['measure_ms']:>12.0f}{row['identity_ms']:>12.0f}"
        )
    return "\n".join(lines)


def _matching_lines(matching: dict[str, Any]) -> list[str]:
    """The rates in sentences."""
    acquired, scores, issued = matching["failure_to_acquire"], matching["scores"], matching["issued"]
    model, undetected = matching["model"], matching["undetected"]
    tails = ", ".join(f"{100 * tail['other_films']:.2f} % for {100 * tail['model']:g} %" for tail in model["tails"])
    lines = [
        f"failure to acquire: {acquired['failed']} of {acquired['films']} films "
        f"(at most {acquired['interval'][1]:.4f})",
        f"scores, threshold {scores['threshold']:.3f} fixed on the other half of the films: "
        f"FNMR {scores['fnmr']:.4f} (at most {scores['fnmr_interval'][1]:.4f}) of {scores['films']} films, "
        f"FMR {scores['fmr']:.1e} (at most {scores['fmr_interval'][1]:.1e}) of {scores['comparisons']:,} comparisons, "
        f"equal error rate {scores['equal_error_rate']:.1e}",
        f"least score of the same badge {scores['genuine_least']:.3f}, greatest of others "
        f"{scores['impostor_greatest']:.3f}",
        f"error model: Student's t of {model['freedom']:.1f} degrees, scale {model['scale_rad']:.4f} rad; beyond its "
        f"tails lie of other films: {tails}",
    ]
    lines += [
        f"phase errors x {row['factor']:<4g}{row['source']:<13} FNMR {row['fnmr']:.4f} (at most "
        f"{row['fnmr_interval'][1]:.4f}), FMR {row['fmr']:.1e} (at most {row['fmr_interval'][1]:.1e}) over "
        f"{row['comparisons']:,} comparisons"
        for row in matching["decoding"]
    ]
    lines += [
        f"{issued['payloads']:,} issued words differ in {issued['least_distance_bytes']} bytes or more; "
        f"the code promises {issued['promised_bytes']}",
        f"wrong payloads of {undetected['words_each']:,} words at random: {undetected['random']}; "
        f"of as many with one error more than can be mended: {undetected['one_error_too_many']}",
    ]
    return lines


def identity_plot(result: dict[str, Any]) -> Any:
    """Scatter of the cells' phase against distance, with the point of confusion."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 3.6), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    for bits, colour in ((64, "#1f6fb2"), (128, "#c2571a")):
        rows = [row for row in result["conditions"] if row["name"].startswith(f"{bits} ")]
        metres = [float(row["name"].split(", ")[1].removesuffix(" m")) for row in rows]
        axes.semilogy(metres, [row["phase_rms_rad"] for row in rows], "o-", color=colour, label=f"{bits} bits")
    axes.axhline(3.14159 / 4, color="#8a97a6", linestyle=":", label="point of confusion")
    axes.set_xlabel("distance, m")
    axes.set_ylabel("phase error of a cell, rad (RMS)")
    axes.grid(color="#e4e8ed")
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return figure
