"""From a score to calibrated odds, and to words.

A score is as sharp as its noise model; on films it is overconfident.  So it is calibrated: the logarithm of the odds
that films with this score are honest, where as many are honest as forged, capped at what the set of films supports.
Odds are no probability: how many films are forged in the first place is not known here.

Source: logistic regression of honest against forged films on the score (Platt 1999), by `benchmarks/priors.py`; the
    verbal scale is that of the ENFSI guideline for evaluative reporting (2015).
"""

from __future__ import annotations

from moireid.verifier.limits import CALIBRATION_CAP_LOG10, CALIBRATION_OFFSET_LOG10, CALIBRATION_SLOPE

#: Least calibrated logarithm of the odds, and its words; the same words serve below 0, for the forged explanation.
SCALE = (
    (4.0, "very strong"),
    (3.0, "strong"),
    (2.0, "moderately strong"),
    (1.0, "moderate"),
    (0.3, "weak"),
)


def calibrated_log10(score: float) -> float:
    """Calibrated decadic logarithm of the odds of the honest explanation, capped on both sides.

    Convention: it never has another sign than the score.  A film that hardly tests the law, such as a single sweep, has
    a low score and no support either way; the films of the calibration all test it.
    """
    value = CALIBRATION_SLOPE * score
    if score > 0:
        value = max(value + CALIBRATION_OFFSET_LOG10, 0.0)
    return min(max(value, -CALIBRATION_CAP_LOG10), CALIBRATION_CAP_LOG10)


def in_words(log10: float) -> str:
    """The support that calibrated odds give, as a sentence's end."""
    for least, words in SCALE:
        if abs(log10) >= least:
            return f"{words} support for {'the law' if log10 > 0 else 'another explanation'}"
    return "no support either way"
