"""Splines over frames: closed form, then against SciPy's.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_smoothing_spline

from moireid.verifier.series import slopes, smoothed


@pytest.fixture(params=[5, 8, 300])
def places(request: pytest.FixtureRequest, rng: np.random.Generator) -> np.ndarray:
    """Times of unevenly spaced frames, s."""
    return rng.uniform(0.5, 1.5, request.param).cumsum() / 60


@pytest.mark.parametrize("weighed", [False, True])
@pytest.mark.parametrize("stiffness", [0.0, 1e-7, 1e-4, 1e-1])
def test_smoothing_is_that_of_the_penalised_spline(
    places: np.ndarray, stiffness: float, weighed: bool, rng: np.random.Generator
) -> None:
    """Catches: weights that are squared or divided by, a penalty per frame and not per second, wrong ends."""
    values = rng.normal(size=len(places)).cumsum() + 100
    weights = rng.uniform(0.1, 3, len(places)) if weighed else None
    expected = make_smoothing_spline(places, values, w=weights, lam=stiffness)(places)
    assert smoothed(places, values, stiffness, weights) == pytest.approx(expected, abs=1e-7)


def test_times_that_hardly_rise_are_borne(rng: np.random.Generator) -> None:
    """Catches: a factor without pivots that loses its digits where a file gives each time three times.

    Frames of one time count as one of the mean: the smoothing of the means, three times as heavy, is the other route.
    """
    clock, values = np.arange(80) / 20, rng.normal(size=240)
    times = np.repeat(clock, 3) + 1e-7 * np.arange(240)
    means = smoothed(times[1::3], values.reshape(-1, 3).mean(axis=1), 1e-4, np.full(80, 3.0))
    assert smoothed(times, values, 1e-4).reshape(-1, 3) == pytest.approx(np.repeat(means, 3).reshape(-1, 3), abs=1e-4)


@pytest.mark.parametrize("count", [4, 5, 400])
def test_slopes_are_those_of_the_spline_through_all_values(count: int, rng: np.random.Generator) -> None:
    """Catches: ends that are taken for straight, a derivative by frames, places that are mixed up between knots."""
    places = rng.uniform(0.5, 1.5, count).cumsum()
    values = rng.normal(size=(count, 3, 2)).cumsum(axis=0)
    at = np.sort([*rng.uniform(places[0], places[-1], 50), *places])
    expected = CubicSpline(places, values)(at, 1)
    assert slopes(places, values, at) == pytest.approx(expected, abs=1e-10)
    assert slopes(places, places**3, at) == pytest.approx(3 * at**2, rel=1e-9)
