"""The likelihood ratio.  Beside each test: what it would catch."""

from __future__ import annotations

import math

import pytest

from moireid.verifier.explanations.likelihood import log10_ratio, scale_rad
from moireid.verifier.limits import (
    ACCEPTED_LOG10,
    EXPECTED,
    FORGED_GAIN_MAX_RATIO,
    FORGED_GAIN_MIN_RATIO,
    GAIN_SD_RATIO,
    MAX_CERTAINTY_LOG10,
    REJECTED_LOG10,
)

MOTION, ERROR = 0.8, 0.02


def usual(motion: float = MOTION, error: float = ERROR) -> dict[str, float]:
    """What true badges show on average."""
    return {name: math.exp(one.mean_log) * scale_rad(one, error, motion) for name, one in EXPECTED.items()}


def test_a_usual_true_badge_is_accepted_and_its_ratio_is_the_gain_s():
    """Catches: a kind's share or density left out; natural logarithms.  All other kinds lie far off here."""
    found, _ = log10_ratio(1.0, 0.0, usual(), MOTION, ERROR)
    density = 1 / (GAIN_SD_RATIO * math.sqrt(2 * math.pi))
    assert found == pytest.approx(
        math.log10((1 + len(EXPECTED)) * (FORGED_GAIN_MAX_RATIO - FORGED_GAIN_MIN_RATIO) * density), abs=0.02
    )
    assert found > ACCEPTED_LOG10


@pytest.mark.parametrize("name", list(EXPECTED))
def test_each_figure_speaks_alone(name):
    """Catches: a figure that is not looked at; kinds multiplied, so that one forged thing is outvoted by four true."""
    found, suspected = log10_ratio(1.0, 0.0, usual() | {name: 0.4 * MOTION}, MOTION, ERROR)
    assert suspected == name and found < REJECTED_LOG10


@pytest.mark.parametrize("gain", [0.5, 1.5, -1.0, 0.0])
def test_a_wrong_gain_speaks_alone_and_a_vague_one_not(gain):
    """Catches: |gain|; an error bar that is not used."""
    found, suspected = log10_ratio(gain, 0.01, usual(), MOTION, ERROR)
    assert suspected == "gain" and found < REJECTED_LOG10
    sure, vague = (log10_ratio(1.0, sd, usual(), MOTION, ERROR)[0] for sd in (0.01, 1.0))
    assert REJECTED_LOG10 < log10_ratio(gain, 1.0, usual(), MOTION, ERROR)[0] <= vague < sure - 0.9
    assert log10_ratio(gain, 10.0, usual(), MOTION, ERROR)[0] < ACCEPTED_LOG10


def test_an_error_bar_beyond_all_gains_tells_neither_way():
    """Catches: forged gains that are not blurred by the error bar, by which the vaguest gain was taken for forged: a
    ratio of 10^-2 from a bar of 1000.
    """
    untold = math.log10(1 + len(EXPECTED))
    for sd in (1e2, 1e4, 1e9):
        for gain in (1.0, -3.0, 300.0):
            assert log10_ratio(gain, sd, usual(), MOTION, ERROR)[0] == pytest.approx(untold, abs=0.03)
    inside = log10_ratio(2.99, 0.0, usual(), MOTION, ERROR)[0]
    assert log10_ratio(9.0, 0.0, usual(), MOTION, ERROR)[0] <= inside + 0.31 < REJECTED_LOG10


@pytest.mark.parametrize("name", ["strips", "places"])
def test_pale_fringes_make_strips_vague_and_not_forged(name):
    """Catches: noise of faint fringes taken for rows that move apart; an error bar that excuses any error."""
    figures = usual() | {name: 0.09}
    assert log10_ratio(1.0, 0.01, figures, MOTION, ERROR)[0] < REJECTED_LOG10
    assert log10_ratio(1.0, 0.01, figures, MOTION, ERROR, strip_sd_rad=0.1)[0] > ACCEPTED_LOG10
    torn = usual() | {name: 0.4}
    assert log10_ratio(1.0, 0.01, torn, MOTION, ERROR, strip_sd_rad=0.1)[0] < REJECTED_LOG10


def test_a_film_that_hardly_moves_tells_nothing():
    """Catches: figures of noise taken for strong evidence, the one way or the other."""
    for scale in (1.0, 2.0):
        figures = {name: scale * size for name, size in usual(0.02).items()}
        assert abs(log10_ratio(1.0, 0.5, figures, 0.02, ERROR)[0]) < ACCEPTED_LOG10


def test_less_than_usual_is_no_sign_of_a_forgery():
    """Catches: a very steady true film that is rejected, as its figures are unlike the usual ones."""
    steady = {name: 0.05 * size for name, size in usual().items()}
    expected = log10_ratio(1.0, 0.0, usual(), MOTION, ERROR)[0]
    assert log10_ratio(1.0, 0.0, steady, MOTION, ERROR)[0] == pytest.approx(expected, abs=1e-9)


def test_extremes_stay_finite():
    """Catches: overflow, NaN, a logarithm of nothing."""
    wild = dict.fromkeys(EXPECTED, 1e9)
    for gain, gain_sd, figures, motion in (
        (1e6, 0.0, wild, 1.0),
        (1.0, math.inf, wild, 0.0),
        (0.0, 0.0, usual(), 1e-9),
    ):
        found, _ = log10_ratio(gain, gain_sd, figures, motion, 0.0)
        assert math.isfinite(found) and abs(found) <= MAX_CERTAINTY_LOG10
    assert math.isfinite(log10_ratio(1.0, 0.0, dict.fromkeys(EXPECTED, 0.0), 1.0, 0.0)[0])
