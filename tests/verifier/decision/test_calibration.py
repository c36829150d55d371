"""From a score to calibrated odds and words.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.explanations.table import in_words
from moireid.verifier.limits import CALIBRATION_CAP_LOG10


def test_calibrated_odds_rise_with_the_score_and_end_at_the_cap():
    """Catches: a sign; odds beyond what the set of films supports."""
    scores = np.linspace(-400, 400, 801)
    found = np.array([calibrated_log10(float(score)) for score in scores])
    assert (np.diff(found) >= 0).all() and np.ptp(found) > 0
    assert found.max() == CALIBRATION_CAP_LOG10 and found.min() == -CALIBRATION_CAP_LOG10
    assert calibrated_log10(math.inf) == CALIBRATION_CAP_LOG10


def test_a_film_that_hardly_tests_the_law_supports_nothing():
    """Catches: a true sweep whose low odds for the law are calibrated into odds against it."""
    assert calibrated_log10(1.4) == 0.0 and calibrated_log10(0.0) == 0.0


@pytest.mark.parametrize(
    ("log10", "words"),
    [
        (4.5, "very strong"),
        (4.0, "very strong"),
        (3.2, "strong"),
        (2.0, "moderately strong"),
        (1.99, "moderate"),
        (0.4, "weak"),
    ],
)
def test_words_go_by_the_scale_on_both_sides(log10, words):
    """Catches: a limit that belongs to the class below; strong support for the law in a forged film."""
    assert in_words(log10) == f"{words} support for the law"
    assert in_words(-log10) == f"{words} support for another explanation"
