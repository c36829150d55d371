"""Size of residuals and odds.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.fringe_signals import lasting_noise
from moireid.verifier.explanations.residuals import (
    credible_error_rad,
    deviation_rad,
    independent_samples,
    log10_odds,
    residual_limit_rad,
    spread_rad,
)
from moireid.verifier.limits import (
    LEAST_SAMPLES,
    MIN_EXCITATION_RAD,
    OWN_MOTION,
    POSSIBLE_RESIDUAL_RATIO,
    PROOF_SDS,
    UNMODELLED_RAD,
    USUAL_SDS,
)


def test_the_spread_is_half_robust_and_half_plain():
    """Catches: one of the two alone.  Closed form: of +1 and -1, and of a lie of 3 over a tenth of the film."""
    signs = np.where(np.arange(1000) % 2, 1.0, -1.0)
    lie = np.where(np.arange(1000) < 100, 3.0, 0.0)
    wanted = [0.5 * 1.4826 + 0.5, 0.5 * 3 * math.sqrt(0.1 * 0.9)]
    assert spread_rad(np.column_stack([signs, lie])) == pytest.approx(wanted)
    assert spread_rad(np.full((50, 1), 4.0)) == pytest.approx([0.0])


def test_a_few_bad_poses_hardly_widen_the_spread(rng):
    """Catches: a verdict that rests on three frames of hundreds."""
    clean = rng.normal(0, 0.02, 600)
    spoilt = clean.copy()
    spoilt[[50, 300, 500]] += 0.5
    plain, robust = spoilt.std(), spread_rad(spoilt[:, None])[0]
    assert robust < 0.02 + 0.55 * (plain - 0.02)


@pytest.mark.parametrize("lasting", [0.3, 0.6, 0.9])
def test_samples_of_lasting_noise_are_fewer_by_the_known_factor(lasting):
    """Catches: frames counted as independent.  Closed form: N (1 - a) / (1 + a), the sum cut off below 0.2."""
    noise = lasting_noise(20000, 0.02, lasting=lasting)
    assert independent_samples(noise) == pytest.approx(20000 * (1 - lasting) / (1 + lasting), rel=0.3)


def test_what_lasts_counts_in_full_and_noise_of_single_frames_in_part():
    """Catches: frame noise that is called a wander; a wander that is averaged away; flicker that counts for nothing."""
    clock, rng = np.arange(300) / 30, np.random.default_rng(1)
    wander = 0.1 * math.sqrt(2) * np.sin(2 * np.pi * 0.5 * clock)
    assert deviation_rad(wander, 1 / 30) == pytest.approx(float(spread_rad(wander[:, None])[0]), rel=0.05)
    noise = 0.1 * rng.standard_normal(300)
    assert deviation_rad(noise, 1 / 30) == pytest.approx(0.1 / POSSIBLE_RESIDUAL_RATIO, rel=0.15)
    flicker = 0.1 * (-1.0) ** np.arange(300)
    assert deviation_rad(flicker, 1 / 30) >= 0.1 / POSSIBLE_RESIDUAL_RATIO
    # Blocks of 0.4 s: what changes within one is known as a spread alone.
    assert deviation_rad(np.zeros(50), 0.4, 0.1) == pytest.approx(0.1 / POSSIBLE_RESIDUAL_RATIO)


def test_samples_do_not_depend_on_size_or_mean():
    """Catches: an autocorrelation that is not normalised, or not about the mean."""
    noise = lasting_noise(600, 0.02)
    wanted = independent_samples(noise)
    assert independent_samples(1e3 * noise + 7.0) == pytest.approx(wanted)
    assert LEAST_SAMPLES < wanted < 600


def test_odds_of_large_residuals_are_half_a_power_of_ten_a_sample():
    """Catches: natural logarithms; blocks counted in place of independent samples.  Closed form."""
    assert log10_odds(1e3, 1e4, 300, 80) == pytest.approx(40.0, abs=1e-2)


def test_odds_end_at_the_error_that_no_explanation_models():
    """Catches: boundless odds where one explanation fits to a rounding error.  Closed form of the floor."""
    floor = 300 * UNMODELLED_RAD**2
    assert log10_odds(0.0, 0.0, 300, 80) == 0.0
    assert log10_odds(0.0, floor, 300, 80) == pytest.approx(40 * math.log10(2))
    assert log10_odds(1e-12, floor / 100, 300, 80) < 0.2


def test_the_limit_of_a_residual_is_a_closed_form():
    """Catches: errors that are added where they combine in squares; a limit without the film's own error."""
    for sds in (USUAL_SDS, PROOF_SDS):
        times = math.exp(OWN_MOTION.mean_log + sds * OWN_MOTION.sd_log)
        assert residual_limit_rad(0.0, sds) == pytest.approx(0.010 * times)
        assert residual_limit_rad(0.05, sds) == pytest.approx(times * math.hypot(0.05, 0.010))
    assert residual_limit_rad(0.05) == residual_limit_rad(0.05, USUAL_SDS)


def test_no_error_lets_more_than_a_quarter_of_the_motion_pass():
    """Catches: room that a noisy film buys; the figure is that of THREATS.md."""
    shares = [
        residual_limit_rad(credible_error_rad(motion, 10.0)) / motion for motion in (MIN_EXCITATION_RAD, 1.0, 5.0)
    ]
    assert max(shares) == pytest.approx(0.25, abs=0.01) and min(shares) == pytest.approx(0.23, abs=0.01)
