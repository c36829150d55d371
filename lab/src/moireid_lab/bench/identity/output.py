"""Table and plot of the identity suite."""

from __future__ import annotations

from typing import Any


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
