"""False matches and non-matches, in the terms of ISO/IEC 19795-1, by a model of errors.

A cell's phase error is Student's t, as fitted to films; readings drawn from it, and larger by some factors, where
decoding fails, are decoded as in the verifier and held against many claims.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from moireid.idcodes.spacing import PHASE_LEVELS, decode_phases, word_places
from moireid.idcodes.words import WordCode
from moireid_lab.bench.part import Row

#: Factors for the films' phase errors: 1, and others for films much worse than any measured.
FACTORS = (1.0, 4.0, 7.0, 10.0)
#: Readings of each factor, and claims that each is held against.
READINGS, CLAIMS = 500, 10_000
WORD = WordCode(8, 26)


def matching_row(errors_rad: list[NDArray[np.float64]]) -> Row:
    """Readings that are decoded as the right person, not decoded, and decoded as another; rates by factor.

    Parameters: errors_rad: of the cells of each film.  A reading that is decoded as a payload which no claim has is not
        decoded.
    """
    freedom, _, scale = t.fit(np.concatenate(errors_rad), floc=0.0)
    rng = np.random.default_rng(1_000_003)
    claimed = {rng.bytes(WORD.payload_bytes) for _ in range(CLAIMS)}
    row: Row = {"kind": "errors as at 3 m", "answers": {}, "freedom": float(freedom), "scale_rad": float(scale)}
    for factor in FACTORS:
        missed = false = 0
        for _ in range(READINGS):
            payload, count = rng.bytes(WORD.payload_bytes), 4 * WORD.word_bytes
            errors = factor * t.rvs(freedom, scale=scale, size=count, random_state=rng)
            phases = 2 * np.pi * np.array(word_places(WORD, payload)) / PHASE_LEVELS
            decoded = decode_phases(WORD, phases + errors, np.full(count, max(factor * scale, 0.05)))
            false += decoded != payload and decoded in claimed
            missed += decoded != payload and decoded not in claimed
        if factor == 1:
            row["answers"]["matching"] = (READINGS - missed - false, missed, false)
        row |= {f"missed x{factor:g}": missed / READINGS, f"false x{factor:g}": false / (READINGS * CLAIMS)}
    return row
