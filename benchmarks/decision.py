"""Fits the likelihood ratio's figures on one half of a collection of films, and prints its decisions on the other.

Run `.venv/bin/python benchmarks/decision.py [FIGURES.csv]`; the default is `tests/data/decision/figures.csv`, films
by an outside simulator.  A film's half is drawn from its name.  Films with too little motion are counted separately:
they are inconclusive whatever the ratio is.  Last, it prints how much of each fixed limit of `limits.py` the true films
use.
"""

from __future__ import annotations

import csv
import hashlib
import math
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from moireid.evaluation.statistics import area, interval, roc
from moireid.verifier.explanations.likelihood import log10_ratio, scale_rad
from moireid.verifier.limits import (
    ACCEPTED_LOG10,
    EXPECTED,
    EXPLAINED_SDS,
    GAIN_REJECTED_SDS,
    GAIN_TOLERANCE_SHARE,
    MAX_STRIP_WANDER_RAD,
    MIN_EXCITATION_RAD,
    MIN_EXCITATION_TO_ERROR_RATIO,
    REJECTED_LOG10,
    RESIDUAL_FLOOR_RAD,
    RESIDUAL_MOTION_SHARE,
    Expected,
)

FIGURES = Path(__file__).parents[1] / "tests/data/decision/figures.csv"
COLUMNS = {
    "wander": "slow_wander_rad",
    "jitter": "wandering_rad",
    "spell": "spell_rad",
    "strips": "strip_wander_rad",
    "places": "place_wander_rad",
}
Film = dict[str, str]


def half(film: Film) -> int:
    """0: used for fitting, 1: used for testing."""
    return hashlib.sha256(film["name"].encode()).digest()[0] & 1


def moved(film: Film) -> bool:
    """Whether the film shows enough motion to be judged."""
    excitation, error = float(film["excitation_rad"]), float(film["expected_error_rad"])
    return excitation >= max(MIN_EXCITATION_RAD, MIN_EXCITATION_TO_ERROR_RATIO * error)


def fitted(films: list[Film]) -> dict[str, Expected]:
    """Means and standard deviations of the logarithms on these films, all true."""
    found = {}
    for name, one in EXPECTED.items():
        logs = []
        for film in films:
            errors = (float(film[column]) for column in ("expected_error_rad", "excitation_rad", "strip_sd_rad"))
            unit = scale_rad(one, *errors)
            logs.append(math.log(float(film[COLUMNS[name]]) / unit))
        found[name] = replace(one, mean_log=float(np.mean(logs)), sd_log=float(np.std(logs, ddof=1)))
    return found


def score(film: Film, expected: dict[str, Expected]) -> float:
    """The likelihood ratio's logarithm of a film."""
    shown = {name: float(film[column]) for name, column in COLUMNS.items()}
    motion, error = float(film["excitation_rad"]), float(film["expected_error_rad"])
    gain, gain_sd, strip_sd = (float(film[column]) for column in ("gain_ratio", "gain_sd", "strip_sd_rad"))
    return log10_ratio(gain, gain_sd, shown, motion, error, expected, strip_sd_rad=strip_sd)[0]


def decided(films: list[Film], expected: dict[str, Expected]) -> None:
    """Print what is decided of films, by kind."""
    scores = {film["name"]: score(film, expected) for film in films}
    print(f"{'kind':<14}{'films':>6}{'accept':>8}{'open':>6}{'reject':>8}{'least':>9}{'median':>9}{'most':>9}")
    for kind in sorted({film["kind"] for film in films}, key=lambda kind: (kind != "none", kind)):
        own = [scores[film["name"]] for film in films if film["kind"] == kind]
        verdicts = Counter(
            "accept" if s >= ACCEPTED_LOG10 else "reject" if s <= REJECTED_LOG10 else "open" for s in own
        )
        row = "".join(f"{verdicts[name]:>{width}}" for name, width in (("accept", 8), ("open", 6), ("reject", 8)))
        print(f"{kind:<14}{len(own):>6}{row}{min(own):>9.2f}{np.median(own):>9.2f}{max(own):>9.2f}")
    genuine = np.array([scores[film["name"]] for film in films if film["kind"] == "none"])
    forged = np.array([scores[film["name"]] for film in films if film["kind"] != "none"])
    for what, count, of in (
        ("true films accepted", int((genuine >= ACCEPTED_LOG10).sum()), len(genuine)),
        ("forged films accepted", int((forged >= ACCEPTED_LOG10).sum()), len(forged)),
        ("forged films rejected", int((forged <= REJECTED_LOG10).sum()), len(forged)),
    ):
        low, high = interval(count, of)
        print(f"{what}: {count} of {of} ({100 * low:.1f} to {100 * high:.1f} %)")
    print(f"AUC {area(roc(genuine, forged)):.4f}")


def used(films: list[Film]) -> None:
    """Print how much of each fixed limit true films use: 1 is at the limit."""
    shares: dict[str, list[float]] = {"gain": [], "residual": [], "strips": []}
    for film in films:
        error, motion = (float(film[column]) for column in ("expected_error_rad", "excitation_rad"))
        gain, gain_sd = (float(film[column]) for column in ("gain_ratio", "gain_sd"))
        explained = EXPLAINED_SDS * error
        shares["gain"].append(abs(gain - 1) / (GAIN_TOLERANCE_SHARE + GAIN_REJECTED_SDS * gain_sd))
        residual = math.hypot(RESIDUAL_FLOOR_RAD, RESIDUAL_MOTION_SHARE * motion, explained)
        shares["residual"].append(float(film["wandering_rad"]) / residual)
        shares["strips"].append(float(film["strip_wander_rad"]) / math.hypot(MAX_STRIP_WANDER_RAD, explained))
    print(f"\nhow much of each limit {len(films)} true films use\n{'limit':<10}{'median':>8}{'most':>8}")
    for name, own in shares.items():
        print(f"{name:<10}{np.median(own):>8.2f}{max(own):>8.2f}")


def main() -> None:
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURES
    with path.open(encoding="utf-8", newline="") as stream:
        films = list(csv.DictReader(stream))
    still = [film for film in films if not moved(film)]
    films = [film for film in films if moved(film)]
    print(f"{len(films)} films judged, {len(still)} with too little motion")
    own = fitted([film for film in films if half(film) == 0 and film["kind"] == "none"])
    print(f"\nfitted on one half\n{'figure':<10}{'mean':>8}{'sd':>8}{'in use: mean':>16}{'sd':>8}")
    for name, one in own.items():
        print(
            f"{name:<10}{one.mean_log:>8.2f}{one.sd_log:>8.2f}{EXPECTED[name].mean_log:>16.2f}{EXPECTED[name].sd_log:>8.2f}"
        )
    for title, expected in (("with what was fitted", own), ("with the figures in use", EXPECTED)):
        print(f"\nthe other half, {title}")
        decided([film for film in films if half(film) == 1], expected)
    used([film for film in films if film["kind"] == "none"])


if __name__ == "__main__":
    main()
