"""The measured phase, with the best fit of the law and of the best rival.

Convention: as `law_plot`; each curve has mean 0 in each stretch, as in the comparison of explanations.
"""

from __future__ import annotations

import numpy as np

from moireid.verifier.explanations.honest import PhaseSeries, phase_series
from moireid.verifier.explanations.rivals import RIVALS, nearest
from moireid.verifier.explanations.table import Explanation, cause_of, simplest
from moireid.verifier.explanations.words import does
from moireid.verifier.report.plots import BY_LAW, MEASURED, NARROW, RIVAL, WIDE, Array, broken, figure_of, label, svg_of
from moireid.verifier.session.result import Report

#: The shapes of the rivals that have one of their own over the whole film.
SHAPED = {rival.name: rival.variants for rival in RIVALS if rival.variants is not None}
#: Room above and below the curves, as a share of their height; a rival that fits badly is cut off there.
SPARE = 0.25


def rival_plot(report: Report, size: tuple[float, float] = WIDE) -> str | None:
    """The plot as SVG; None if nothing was compared."""
    best = shaped_rival(report)
    if best is None or report.measurement is None:
        return None
    signal = report.measurement.gratings[report.most_informative]
    series = phase_series(signal)
    if series is None:
        return None
    first_s = float(signal.times_s[np.isfinite(signal.phase_sd_rad)][0])
    curves = [phase / (2 * np.pi) for phase in (series.law_rad, best_fit(best, series), series.measured_rad)]
    at, law, rival, seen = broken(series.times_s + first_s, series.stretch, *curves)
    figure, axes = figure_of(*size)
    axes.plot(at, law, **BY_LAW, label="by the law")
    axes.plot(at, seen, color=MEASURED, linewidth=1.3, label="as seen")
    words = f"if they {does(best.name, best.parameters)}"
    axes.plot(at, rival, color=RIVAL, linewidth=1.8, linestyle=(0, (5, 4)), label=words)
    axes.set_xlim(at[0], at[-1])
    low, high = min(np.nanmin(law), np.nanmin(seen)), max(np.nanmax(law), np.nanmax(seen))
    axes.set_ylim(low - SPARE * (high - low), high + SPARE * (high - low))
    label(axes, "time, s", "place of the fringes, in widths", columns=1 if size == NARROW else 3, left=-0.02)
    return svg_of(figure)


def shaped_rival(report: Report) -> Explanation | None:
    """Of the rivals with a shape of their own, the one that is nearest to the film.

    Convention: the one that headline and findings name; else the one that fits best, and of several that are equally
    good within a factor of ten the simplest; if none fits better than the law, one that would look the same.
    """
    found = report.invariant.explanations
    known = {one.name: one for one in found if one.name in SHAPED and one.log10_odds is not None}
    alike = [one for one in known.values() if one.fits and one.share is not None]
    if alike and not any(one.better_than_law for one in known.values()):
        return max(alike, key=lambda one: one.share or 0.0)
    cause = cause_of(found[1:])
    return cause if cause is not None and cause.name in known else simplest(list(known.values()))


def best_fit(one: Explanation, series: PhaseSeries) -> Array:
    """The phase (N,) of a rival with the parameters that fit the measured phase best, rad.

    Notes
    -----
    Source: weighted least squares over the rival's shapes, as `explanations.rivals`; a gain is that of the table.
    """
    if one.name == "another_gain":
        return one.parameters["gain"] * series.law_rad
    root = np.sqrt(series.weight)
    fits = [nearest(series, columns, series.measured_rad) for _, columns in SHAPED[one.name](series)]
    return min(fits, key=lambda fit: float(np.sum((root * (series.measured_rad - fit)) ** 2)))
