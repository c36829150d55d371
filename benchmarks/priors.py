"""Fits the priors of the decision and calibrates its score: run `moireid lab bench priors`.

Films are those of `moireid lab bench natural --table FILE`, true and forged; without `--table FILE`, those of
`tests/data/explanations/films.csv`.  A film's half is drawn from its name: one half fits, the other is judged.

Printed are: mean and standard deviation of what the law leaves, and of rows and places, on true films
(`limits.OWN_MOTION`, `PARTS`); slope and offset of the calibrated odds (`CALIBRATION_SLOPE`); on the other half, of
films at calibrated odds of 10^k, how many are true; and the cost of the log likelihood ratio, Cllr (Bruemmer and du
Preez 2006): 0 for perfect odds, 1 for a score that says nothing.
"""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.limits import (
    CALIBRATION_CAP_LOG10,
    CALIBRATION_OFFSET_LOG10,
    CALIBRATION_SLOPE,
    OWN_MOTION,
    PARTS,
)
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.evaluation.statistics import cllr

FILMS = Path(__file__).parents[1] / "tests/data/explanations/films.csv"
COLUMNS_OF = {"own_motion": "residual_rad", "rows": "strip_wander_rad", "places": "place_wander_rad"}
OF_A_SHEET = ("gain_0.8", "gain_1.25", "filmed_gain_0.8", "filmed_gain_1.25")
#: Widths of the bins of calibrated odds, powers of ten.
BINS = (-2.5, -1.5, -0.5, 0.5, 1.5, 2.5)
Film = dict[str, str]
Array = NDArray[np.float64]


def half(film: Film) -> int:
    """0: used for fitting, 1: used for testing."""
    return hashlib.sha256(film["film"].encode()).digest()[0] & 1


def priors(films: list[Film]) -> Iterator[Row]:
    """Mean and standard deviation of the logarithm of each deviation over its unit, on true films."""
    for name, column in COLUMNS_OF.items():
        one = OWN_MOTION if name == "own_motion" else PARTS[name]
        logs = []
        for film in films:
            error, motion, strip = (float(film[c]) for c in ("expected_error_rad", "excitation_rad", "strip_sd_rad"))
            deviation = float(film[column])
            logs.append(math.log(max(deviation, 1e-6) / one.unit_rad(motion, error, strip)))
        found = {"mean": float(np.mean(logs)), "sd": float(np.std(logs, ddof=1)), "most": max(logs)}
        yield {"deviation": name, "films": len(logs)} | found | {"mean in use": one.mean_log, "sd in use": one.sd_log}


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


def rows(wish: Wish) -> Iterator[Row]:
    """Fit: rows of the priors, of the calibration, and of the reliability."""
    with wish.own.table.open(encoding="utf-8", newline="") as stream:
        every = [film for film in csv.DictReader(stream) if film["score"] and film["residual_rad"]]
    # A gain that a sheet as sold may have is not what the score is about; `sheet_gain` judges it.
    films = [film for film in every if film["kind"] not in OF_A_SHEET]
    forged = sum(film["kind"] != "true" for film in films)
    yield {"parts of films: true": len(films) - forged, "forged": forged}
    yield from priors([film for film in films if film["kind"] == "true" and half(film) == 0])
    scores = np.clip([float(film["score"]) for film in films], -20.0, 20.0)
    labels = np.array([film["kind"] == "true" for film in films], float)
    tested = np.array([half(film) == 1 for film in films])
    slope, offset = logistic(scores[~tested], labels[~tested])
    log10, known = np.array([calibrated_log10(score) for score in scores[tested]]), labels[tested]
    for words, *figures in (
        ("on one half", slope, offset, None),
        ("in use", CALIBRATION_SLOPE, CALIBRATION_OFFSET_LOG10, CALIBRATION_CAP_LOG10),
    ):
        yield {"calibration": words} | dict(zip(("slope", "offset", "cap"), figures, strict=True))
    yield {"Cllr on the other half": cllr(log10[known > 0], log10[known < 1])}
    for low, high in pairwise(BINS):
        inside = (log10 >= low) & ((log10 < high) | (high == BINS[-1]))
        good, bad = int(known[inside].sum()), int((1 - known[inside]).sum())
        if good + bad:
            share = good / known.sum() / (good / known.sum() + bad / (1 - known).sum())
            found = {"calibrated log10 odds": f"{low:g} to {high:g}", "true": good, "forged": bad}
            expected = 1 / (1 + 10 ** -float(np.mean(log10[inside])))
            yield found | {"true, as many of each": float(share), "expected": expected}


COLUMNS = {
    "parts of films: true": ">20",
    "deviation": "<12",
    "films": ">6",
    "mean": ">8.2f",
    "sd": ">7.2f",
    "most": ">7.2f",
    "mean in use": ">12.2f",
}
COLUMNS |= {"sd in use": ">9.2f", "calibration": "<12", "slope": ">6.2f", "offset": ">7.2f", "cap": ">4g"}
COLUMNS |= {"Cllr on the other half": ">22.3f", "calibrated log10 odds": "<24", "true": ">6", "forged": ">8"}
COLUMNS |= {"true, as many of each": ">24.3f", "expected": ">10.3f"}
OPTIONS = {"--table": {"type": Path, "default": FILMS, "metavar": "FILE", "help": "of films; default: the project's"}}
BENCH = Bench(rows, COLUMNS, options=OPTIONS)
