"""False matches and non-matches at symbol level.

Films give the distribution of a cell's phase error; it is resampled as it is, with a stated factor for worse films.
Every decoding is compared with many claims, so that millions of comparisons are made.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.bench.stats import interval
from moireid.idcodes.spacing import CELLS_PER_BYTE, PHASE_LEVELS, decode_phases, word_places
from moireid.idcodes.words import WordCode

#: The films' phase errors times these: the films themselves, and films much worse than any measured.
FACTORS = (1.0, 4.0, 7.0, 10.0)
WORD = WordCode(8, 26)


def matching_figures(errors_rad: NDArray[np.float64], *, quick: bool, seed: int) -> dict[str, Any]:
    """Rates over readings drawn from the error model, and the distances of issued words.

    Parameters: errors_rad: phase errors of cells as films gave them.
    Returns: JSON object; a comparison is one reading against one claim.
    """
    rng = np.random.default_rng(seed)
    readings, claims = (200, 5_000) if quick else (2_000, 10_000)
    claimed = {rng.bytes(WORD.payload_bytes) for _ in range(claims)}
    rows = []
    for factor in FACTORS:
        missed = false = 0
        for _ in range(readings):
            payload = rng.bytes(WORD.payload_bytes)
            places = np.array(word_places(WORD, payload))
            spread = factor * rng.choice(errors_rad, len(places)) * rng.choice([-1.0, 1.0], len(places))
            phase = 2 * np.pi * places / PHASE_LEVELS + spread
            sd = max(float(factor * np.std(errors_rad)), 0.05)
            found = decode_phases(WORD, phase, np.full(len(phase), sd))
            missed += found != payload
            false += found is not None and found != payload and found in claimed
        comparisons = readings * claims
        rows.append({
            "factor": factor, "readings": readings, "comparisons": comparisons,
            "fnmr": missed / readings, "fnmr_interval": interval(missed, readings),
            "fmr": false / comparisons, "fmr_interval": interval(false, comparisons),
        })  # fmt: skip
    return {"rows": rows, "issued": _issued_apart(rng, 1_000 if quick else 10_000)}


def _issued_apart(rng: np.random.Generator, count: int) -> dict[str, int]:
    """Least number of bytes in which two of `count` issued words differ, and what the code promises."""
    words = np.array([list(WORD.encode(rng.bytes(WORD.payload_bytes))) for _ in range(count)], np.uint8)
    least = WORD.word_bytes
    for k in range(count - 1):
        least = min(least, int((words[k + 1 :] != words[k]).sum(axis=1).min()))
    return {"payloads": count, "least_distance_bytes": least, "promised_bytes": WORD.parity_bytes + 1,
            "cells": WORD.word_bytes * CELLS_PER_BYTE}  # fmt: skip
