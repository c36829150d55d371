"""Figures of one grating.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.fringe_signals import FRAMES, apart_from, fringe_signal, lasting_noise, trajectory
from moireid.verifier.decision.figures import figures_of, pearson, window_correlation_mean
from moireid.verifier.limits import LAW_MOTION_SHARE

LAW = 1.2 * trajectory()


def test_the_window_mean_is_the_plain_mean_over_thirty_frames():
    """Catches: a stride, a median, a signed mean, a missing last window.  Against a loop with numpy's own."""
    measured = LAW + 0.7 * apart_from(LAW) - 0.01 * np.arange(FRAMES)
    loop = [abs(np.corrcoef(measured[k : k + 30], LAW[k : k + 30])[0, 1]) for k in range(FRAMES - 30 + 1)]
    assert len(loop) == 271 and min(loop) < 0.5
    assert window_correlation_mean(measured, LAW) == pytest.approx(np.mean(loop), abs=1e-9)
    found = figures_of(fringe_signal(LAW, measured))
    assert found.window_correlation_mean == pytest.approx(np.mean(loop), abs=1e-9)


def test_the_gain_is_regressed_on_the_predicted_phase():
    """Catches: regression the wrong way round, which reads 1 / gain and grows with the noise."""
    found = figures_of(fringe_signal(LAW, 0.9 * LAW + 0.3 * apart_from(LAW)))
    assert found.gain_ratio == pytest.approx(0.9, abs=1e-9)
    assert found.phase_residual_rad == pytest.approx(0.3) and found.excitation_rad == pytest.approx(1.2)
    assert found.correlation == pytest.approx(1.08 / math.hypot(1.08, 0.3))


def test_the_gain_s_error_bar_grows_with_residuals_that_last():
    """Catches: residuals taken as independent: a slow error informs less than white noise of its size."""
    quick = figures_of(fringe_signal(LAW, LAW + lasting_noise(size=0.1, lasting=0.0))).gain_sd
    lasting = figures_of(fringe_signal(LAW, LAW + 0.1 * apart_from(LAW))).gain_sd
    assert quick == pytest.approx(0.1 / math.sqrt(FRAMES) / 1.2, rel=0.35)
    assert lasting > 4 * quick


def test_an_uncertain_focal_length_widens_the_gain_s_error_bar():
    """Catches: an error bar of the fit alone, of a prediction that is itself a guess.  Closed form."""
    found = figures_of(fringe_signal(LAW, 0.5 * LAW, tangent_sd=0.2))
    assert found.gain_sd == pytest.approx(0.1)


def test_a_view_from_aside_widens_the_gain_s_error_bar():
    """Catches: gains of true badges that are four error bars off, as the law of another sheet is.  Closed form."""
    found = figures_of(fringe_signal(LAW, 0.5 * LAW, aside_share=0.5))
    assert found.gain_sd == pytest.approx(0.5 * 0.5 * LAW_MOTION_SHARE)


def test_pearson_is_numpy_s_and_zero_where_nothing_moves():
    """Catches: series that are not centred; NaN for a constant."""
    a, b = trajectory(2) + 7.0, apart_from(trajectory(2)) + 0.4 * trajectory(2) - 3.0
    assert pearson(a, b) == pytest.approx(np.corrcoef(a, b)[0, 1])
    assert pearson(a, -b) == -pearson(a, b) and pearson(a, np.full(FRAMES, 3.0)) == 0.0
