"""Table and plots of the fabricate suite."""

from __future__ import annotations

from typing import Any

from moireid_lab.bench.fabricate.mount_extremes import extremes_table


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
        "",
        "PDF, preview and assembly sheet alone (print NAME --mount none, interpreter and all): "
        f"{alone['seconds']:.2f} s, of which {alone['cpu_seconds']:.2f} s of processor time; "
        f"{alone['ratio']:.1f} times an interpreter that imports numpy and reportlab",
        "",
        f"{'page at the edge':<40}{'outcome':<9}{'edge, dots':>11}{'cell, rad':>11}  granted",
    ]
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
    """The result of the photographs of the pitch test sheet, in a sentence."""
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
        ("dots", False): ("o-", "#1f6fb2", "dots (default)"),
        ("vector", False): ("^-", "#c2571a", "vector, one bit a dot"),
        ("vector", True): ("v:", "#c2571a", "vector, greyed"),
    }
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
