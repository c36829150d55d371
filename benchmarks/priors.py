"""Fits the priors of the decision and calibrates its score: run `.venv/bin/python benchmarks/priors.py [FILMS.csv]`.

Films are those of `benchmarks/natural_films.py --table FILE`, true and forged; the default is
`tests/data/explanations/films.csv`.  A film's half is drawn from its name: one half fits, the other is judged.

Printed are: mean and standard deviation of what the law leaves, and of rows and places, on true films
(`limits.EXPECTED`); slope and offset of the calibrated odds (`limits.CALIBRATION_SLOPE`); on the other half, of films
at calibrated odds of 10^k, how many are true; and the cost of the log likelihood ratio, Cllr (Bruemmer and du Preez
2006): 0 for perfect odds, 1 for a score that says nothing.  `--plot FILE` draws the reliability as SVG.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.explanations.residuals import scale_rad
from moireid.verifier.limits import CALIBRATION_CAP_LOG10, CALIBRATION_OFFSET_LOG10, CALIBRATION_SLOPE, EXPECTED

FILMS = Path(__file__).parents[1] / "tests/data/explanations/films.csv"
COLUMNS = {"wander": "residual_rad", "rows": "strip_wander_rad", "places": "place_wander_rad"}
OF_A_SHEET = ("gain_0.8", "gain_1.25", "filmed_gain_0.8", "filmed_gain_1.25")
#: Widths of the bins of calibrated odds, powers of ten.
BINS = (-2.5, -1.5, -0.5, 0.5, 1.5, 2.5)
Film = dict[str, str]
Array = NDArray[np.float64]


def half(film: Film) -> int:
    """0: used for fitting, 1: used for testing."""
    return hashlib.sha256(film["film"].encode()).digest()[0] & 1


def priors(films: list[Film]) -> None:
    """Print mean and standard deviation of the logarithm of each deviation over its unit, on true films."""
    print(f"{'deviation':<12}{'films':>6}{'mean':>8}{'sd':>7}{'most':>7}{'in use: mean':>15}{'sd':>7}")
    for name, one in EXPECTED.items():
        logs = []
        for film in films:
            error, motion, strip = (float(film[c]) for c in ("expected_error_rad", "excitation_rad", "strip_sd_rad"))
            deviation = float(film[COLUMNS[name]])
            logs.append(math.log(max(deviation, 1e-6) / scale_rad(one, error, motion, strip)))
        print(
            f"{name:<12}{len(logs):>6}{np.mean(logs):>8.2f}{np.std(logs, ddof=1):>7.2f}{max(logs):>7.2f}"
            f"{one.mean_log:>15.2f}{one.sd_log:>7.2f}"
        )


def logistic(scores: Array, true: Array) -> tuple[float, float]:
    """Slope and offset, in powers of ten, of the log odds that a film is true, as many true as forged.

    Source: Newton's method on the weighted cross entropy with a ridge; scores are bounded, as odds of 10^100 are.
    """
    table = np.column_stack([scores, np.ones(len(scores))])
    weight = np.where(true > 0, 0.5 / true.sum(), 0.5 / (1 - true).sum())
    found = np.zeros(2)
    for _ in range(100):
        chance = 1 / (1 + np.exp(-table @ found))
        gradient = table.T @ (weight * (chance - true)) + 1e-4 * found
        bend = table.T @ (table * (weight * chance * (1 - chance))[:, None]) + 1e-4 * np.eye(2)
        step = np.linalg.solve(bend, gradient)
        found = found - step / max(1.0, float(np.abs(step).max()))
    return float(found[0] / math.log(10)), float(found[1] / math.log(10))


def cllr(log10: Array, true: Array) -> float:
    """Cost of the log likelihood ratio, bits."""
    nats = log10 * math.log(10)
    of_true = np.log2(1 + np.exp(-nats[true > 0])).mean()
    return float((of_true + np.log2(1 + np.exp(nats[true < 1])).mean()) / 2)


def main() -> None:
    """Fit, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("films", nargs="?", type=Path, default=FILMS)
    parser.add_argument("--plot", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    with arguments.films.open(encoding="utf-8", newline="") as stream:
        rows = [film for film in csv.DictReader(stream) if film["score"] and film["residual_rad"]]
    # A gain that a sheet as sold may have is not what the score is about; `sheet_gain` judges it.
    films = [film for film in rows if film["kind"] not in OF_A_SHEET]
    true = [film for film in films if film["kind"] == "true"]
    print(f"{len(true)} true parts of films and {len(films) - len(true)} forged ones that move enough\n")
    priors([film for film in true if half(film) == 0])
    scores = np.clip([float(film["score"]) for film in films], -20.0, 20.0)
    labels = np.array([film["kind"] == "true" for film in films], float)
    tested = np.array([half(film) == 1 for film in films])
    slope, offset = logistic(scores[~tested], labels[~tested])
    print(f"\ncalibration on one half: slope {slope:.2f}, offset {offset:.2f}", end="; ")
    print(f"in use: {CALIBRATION_SLOPE:g}, {CALIBRATION_OFFSET_LOG10:g}, capped at {CALIBRATION_CAP_LOG10:g}")
    log10, known = np.array([calibrated_log10(score) for score in scores[tested]]), labels[tested]
    print(f"Cllr on the other half: {cllr(log10, known):.3f}")
    print(f"\n{'calibrated log10 odds':<24}{'true':>6}{'forged':>8}{'true, as many of each':>24}{'expected':>10}")
    points = []
    for low, high in pairwise(BINS):
        inside = (log10 >= low) & ((log10 < high) | (high == BINS[-1]))
        good, bad = int(known[inside].sum()), int((1 - known[inside]).sum())
        if not good + bad:
            continue
        share = good / known.sum() / (good / known.sum() + bad / (1 - known).sum())
        mean = float(np.mean(log10[inside]))
        points.append((1 / (1 + 10**-mean), share))
        print(f"{f'{low:g} to {high:g}':<24}{good:>6}{bad:>8}{share:>24.3f}{points[-1][0]:>10.3f}")
    if arguments.plot:
        plot(points, arguments.plot)


def plot(points: list[tuple[float, float]], path: Path) -> None:
    """The reliability: share of true films against the calibrated odds as a probability."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4, 4), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], ":", color="grey")
    axes.plot(*zip(*points, strict=True), "o-")
    axes.set(xlabel="calibrated odds, as a probability", ylabel="share of true films", xlim=(0, 1), ylim=(0, 1))
    figure.savefig(path)


if __name__ == "__main__":
    main()
