"""False matches and non-matches, in the terms of ISO/IEC 19795-1.

Films give readings: the phases of a badge's cells.  An error model is fitted to one half of them, and readings drawn
from it are decoded, as in the verifier.  Readings of whole films of the other half show whether the model is right.
Since films are read without errors, both are repeated with larger phase errors, where decoding fails.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from moireid.idcodes.spacing import PHASE_LEVELS, decode_phases, word_places
from moireid.idcodes.words import WordCode
from moireid_lab.evaluation.statistics import interval

Array = NDArray[np.float64]
#: Factors for the films' phase errors: 1, and others for films much worse than any measured.
FACTORS = (1.0, 4.0, 7.0, 10.0)
#: Tails of the error model that are compared with other films.
TAILS = (0.5, 0.1, 0.01, 0.001)
WORD = WordCode(8, 26)


def matching_figures(groups: dict[str, list[dict[str, Any]]], *, quick: bool, seed: int) -> dict[str, Any]:
    """All rates.

    Parameters: groups: rows of clips by condition; those of 64 bits are used, and for the error model 3 m alone.
    Returns: JSON object; a comparison is one reading against one claim.
    """
    # NumPy ignores zeros at the end of a seed; this seed must differ from the clips' seeds, or claims would be theirs.
    rng = np.random.default_rng([seed, 1_000_003])
    rows = [row for name, found in groups.items() if name.startswith("64 bits") for row in found]
    read = [row for row in rows if row["phase_error_rad"]]
    far = [np.array(row["phase_error_rad"]) for row in groups["64 bits, 3 m"] if row["phase_error_rad"]]
    return {
        "failure_to_acquire": {
            "films": len(rows),
            "failed": len(rows) - len(read),
            "interval": interval(len(rows) - len(read), len(rows)),
        },
        "model": _model(far[::2], far[1::2]),
        "decoding": _decoding(far[::2], far[1::2], rng, *((200, 5_000) if quick else (2_000, 10_000))),
    }


def _phases(payload: bytes) -> Array:
    return 2 * np.pi * np.array(word_places(WORD, payload)) / PHASE_LEVELS


def _model(fitted: list[Array], other: list[Array]) -> dict[str, Any]:
    """Student's t of a cell's phase error, and how often other films go beyond its tails."""
    freedom, _, scale = t.fit(np.concatenate(fitted), floc=0.0)
    error = np.abs(np.concatenate(other))
    tails = [
        {"model": tail, "limit_rad": float(limit), "other_films": float((error > limit).mean())}
        for tail in TAILS
        for limit in [t.ppf(1 - tail / 2, freedom) * scale]
    ]
    return {"freedom": float(freedom), "scale_rad": float(scale), "tails": tails}


def _decoding(
    fitted: list[Array], other: list[Array], rng: np.random.Generator, readings: int, claims: int
) -> list[dict[str, Any]]:
    """Rates of decoded readings: drawn from the model, and made of other films."""
    model = _model(fitted, other)
    claimed = {rng.bytes(WORD.payload_bytes) for _ in range(claims)}
    sources: dict[str, Callable[[], Array]] = {
        "model": lambda: t.rvs(model["freedom"], scale=model["scale_rad"], size=4 * WORD.word_bytes, random_state=rng),
        # Whole films, begun at another cell or reversed, keep the correlation of neighbouring cells.
        "other films": lambda: np.roll(other[rng.integers(len(other))], rng.integers(104)) * rng.choice([-1.0, 1.0]),
    }
    found = []
    for factor in FACTORS:
        for source, draw in sources.items():
            missed = false = 0
            for _ in range(readings):
                payload = rng.bytes(WORD.payload_bytes)
                sd = np.full(4 * WORD.word_bytes, max(factor * model["scale_rad"], 0.05))
                decoded = decode_phases(WORD, _phases(payload) + factor * draw(), sd)
                missed += decoded != payload
                false += decoded is not None and decoded != payload and decoded in claimed
            found.append(
                {
                    "factor": factor,
                    "source": source,
                    "readings": readings,
                    "comparisons": readings * claims,
                    "fnmr": missed / readings,
                    "fnmr_interval": interval(missed, readings),
                    "fmr": false / (readings * claims),
                    "fmr_interval": interval(false, readings * claims),
                }
            )
    return found
