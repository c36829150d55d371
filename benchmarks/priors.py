"""Fits the priors of the decision and calibrates its score: run `moireid lab bench priors`.

Films are parts of those of natural motion, true and forged, in `tests/data/explanations/films.csv`.  A film's half is
drawn from its name: one half fits, the other is judged.

Figures are: mean and standard deviation of what the law leaves, and of rows and places, on true films
(`limits.OWN_MOTION`, `PARTS`); slope and offset of the calibrated odds (`CALIBRATION_SLOPE`); on the other half, the
cost of the log likelihood ratio, Cllr (Bruemmer and du Preez 2006): 0 for perfect odds, 1 for a score without worth.
"""

from __future__ import annotations

import csv
import hashlib
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.limits import OWN_MOTION, PARTS
from moireid_lab.bench.part import Asked, Part, Row
from moireid_lab.evaluation.statistics import cllr

FILMS = Path(__file__).parents[1] / "tests/data/explanations/films.csv"
COLUMNS_OF = {"own_motion": "residual_rad", "rows": "strip_wander_rad", "places": "place_wander_rad"}
OF_A_SHEET = ("gain_0.8", "gain_1.25", "filmed_gain_0.8", "filmed_gain_1.25")
#: Calibrated odds, powers of ten, that speak for neither side.
UNCLEAR = 0.5
Film = dict[str, str]
Array = NDArray[np.float64]


def half(film: Film) -> int:
    """0: used for fitting, 1: used for testing."""
    return hashlib.sha256(film["film"].encode()).digest()[0] & 1


def priors(films: list[Film]) -> Row:
    """Mean and standard deviation of the logarithm of each deviation over its unit, on true films."""
    found: Row = {}
    for name, column in COLUMNS_OF.items():
        one = OWN_MOTION if name == "own_motion" else PARTS[name]
        logs = []
        for film in films:
            error, motion, strip = (float(film[c]) for c in ("expected_error_rad", "excitation_rad", "strip_sd_rad"))
            deviation = float(film[column])
            logs.append(math.log(max(deviation, 1e-6) / one.unit_rad(motion, error, strip)))
        found |= {f"{name} mean": float(np.mean(logs)), f"{name} sd": float(np.std(logs, ddof=1))}
    return found


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


def judged(table: Path, folder: Path) -> Row:
    """The fit to one half of the films, and the odds of the other half."""
    with table.open(encoding="utf-8", newline="") as stream:
        every = [film for film in csv.DictReader(stream) if film["score"] and film["residual_rad"]]
    # A gain that a sheet as sold may have is not what the score is about; `sheet_gain` judges it.
    films = [film for film in every if film["kind"] not in OF_A_SHEET]
    scores = np.clip([float(film["score"]) for film in films], -20.0, 20.0)
    labels = np.array([film["kind"] == "true" for film in films], float)
    tested = np.array([half(film) == 1 for film in films])
    slope, offset = logistic(scores[~tested], labels[~tested])
    log10, known = np.array([calibrated_log10(score) for score in scores[tested]]), labels[tested]
    for_truth = np.where(known > 0, log10, -log10)
    answer = [int(np.sum(one)) for one in (for_truth > UNCLEAR, abs(for_truth) <= UNCLEAR, for_truth < -UNCLEAR)]
    row: Row = {"kind": "true and forged parts", "answers": {"odds": answer}, "slope": slope, "offset": offset}
    row |= priors([film for film in films if film["kind"] == "true" and half(film) == 0])
    return row | {"Cllr": cllr(log10[known > 0], log10[known < 1])}


def cases(asked: Asked) -> dict[str, Path]:
    """The project's table."""
    return {"films.csv": FILMS}


QUESTIONS = {"odds": "Do the calibrated odds of a film speak for what it is, by a factor of three?"}
PART = Part(
    QUESTIONS, "benchmarks/outside, forged by numbers", cases, judged, 1, ("tests/data/explanations/films.csv",)
)
