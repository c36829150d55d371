"""The law with what honest films may add to it.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.fringe_signals import FRAMES, clock, lasting_noise, series_of, trajectory
from moireid.verifier.explanations.honest import HonestModel, LawFit
from moireid.verifier.limits import MAX_AXIS_DRIFT_RAD, MAX_LAG_S, MAX_LEAD_S, MAX_SHAPE_SHARE, MAX_ZOOM_DRIFT_SHARE

ROOM = (0.85, 1.15)
EXCITATION = 1.2
LAW = EXCITATION * trajectory()
#: From -1 to 1 over the film.
TIME = (clock() - clock().mean()) / (clock()[-1] - clock().mean())
#: The camera's parallax along the lines, and one over its distance, each with a trajectory of its own.
VIEWS = np.column_stack([0.1 * trajectory(21), 1e-3 * (1 + 0.03 * trajectory(22))])
NAMES = ["lag", "bend", "across", "distance", "zoom", "axis", "axis_turn"]


def model(law: np.ndarray = LAW, **how) -> HonestModel:
    return HonestModel(series_of(law, covariates=VIEWS, **how), ROOM)


def fitted(measured: np.ndarray, of: HonestModel | None = None) -> LawFit:
    of = of or model()
    return of.fit(of.series.centred(measured[:, None]))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def unit(values: np.ndarray) -> np.ndarray:
    """The shape with mean 0 and root mean square 1."""
    return (values - values.mean()) / values.std()


#: Each nuisance as its cause makes it, with root mean square 1 rad, and its bound.
SHAPES = {
    "bend": (unit(LAW**2), MAX_SHAPE_SHARE * EXCITATION),
    "across": (unit(VIEWS[:, 0]), MAX_SHAPE_SHARE * EXCITATION),
    "distance": (unit(VIEWS[:, 1]), MAX_SHAPE_SHARE * EXCITATION),
    "zoom": (unit(LAW * TIME), MAX_ZOOM_DRIFT_SHARE * EXCITATION),
    "axis": (unit(TIME), MAX_AXIS_DRIFT_RAD),
    "axis_turn": (unit(TIME**2), MAX_AXIS_DRIFT_RAD),
}


@pytest.mark.parametrize("gain", [0.85, 0.93, 1.0, 1.13])
def test_a_gain_alone_is_recovered(gain):
    """Catches: one over the gain; nuisances that take a part of it away."""
    found = fitted(gain * LAW)
    assert found.gain == pytest.approx([gain], abs=1e-9)
    assert found.nuisances_rad == pytest.approx(np.zeros((7, 1)), abs=1e-9)
    assert found.residual_rad == pytest.approx(np.zeros((FRAMES, 1)), abs=1e-9)


def test_a_gain_outside_of_the_room_is_reported_and_not_explained():
    """Catches: fringes that go twice as far explained by a gain of 2; a reported gain that is cut off."""
    for gain, nearest in ((2.0, ROOM[1]), (0.3, ROOM[0]), (-1.0, ROOM[0])):
        found = fitted(gain * LAW)
        assert found.gain == pytest.approx([gain], abs=1e-9)
        assert found.residual_rad[:, 0] == pytest.approx((gain - nearest) * LAW, abs=1e-9)


@pytest.mark.parametrize("name", list(SHAPES))
def test_each_nuisance_is_absorbed_up_to_its_bound_and_not_beyond(name):
    """Catches: a cause that is left out; one that hides any motion of its shape."""
    shape, bound = SHAPES[name]
    small = fitted(LAW + 0.8 * bound * shape)
    assert rms(small.residual_rad) < 0.1 * bound
    assert np.abs(small.nuisances_rad[NAMES.index(name), 0]) <= bound
    large = fitted(LAW + 10 * bound * shape)
    # What is beyond the bound remains, but for what gain and other causes take of a shape that resembles theirs.
    assert 3 * bound < rms(large.residual_rad) < 9.5 * bound
    assert np.abs(large.nuisances_rad[NAMES.index(name), 0]) == pytest.approx(bound)


@pytest.mark.parametrize(("late_s", "explained"), [(0.02, True), (0.045, True), (0.2, False), (-0.04, False)])
def test_a_lag_of_a_frame_is_absorbed_and_no_longer_one_and_no_lead(late_s, explained):
    """Catches: any delay put down to a codec; fringes ahead of the badge, which no codec makes."""
    measured = EXCITATION * trajectory(late_s=late_s)
    made = model()
    swing = rms(made.series.rate_rad_per_s)
    found = fitted(measured, made)
    lag_rad = found.nuisances_rad[NAMES.index("lag"), 0]
    assert -1.000001 * MAX_LEAD_S * swing <= lag_rad <= 1.000001 * MAX_LAG_S * swing
    assert (rms(found.residual_rad) < 0.1 * rms(measured - LAW)) == explained
    assert explained or rms(found.residual_rad) > 0.5 * rms(measured - LAW)


def test_a_shape_that_resembles_the_law_is_left_out():
    """Catches: rounding errors of a column blown up until they explain any wander.

    On a steady sweep the rate is constant and the axis moves as the law does; a camera at rest has no other view.
    """
    sweep = HonestModel(series_of(0.3 * clock(), covariates=np.full((FRAMES, 2), 0.25)), ROOM)
    assert "lag" not in sweep.names and "axis" not in sweep.names
    assert "across" not in sweep.names and "distance" not in sweep.names
    # The law's square and the law times the time are one shape there.
    assert sweep.names == ["bend"]


def test_many_series_at_once_are_fitted_as_each_alone(rng):
    """Catches: bounds that hold for the first series alone."""
    made = model()
    phases = made.series.centred(LAW[:, None] * rng.uniform(0, 2, 5) + rng.normal(0, 0.2, (FRAMES, 5)))
    both = made.fit(phases)
    for k in range(5):
        alone = made.fit(phases[:, k : k + 1])
        assert both.gain[k] == pytest.approx(alone.gain[0])
        assert both.residual_rad[:, k] == pytest.approx(alone.residual_rad[:, 0], abs=1e-12)
        assert both.nuisances_rad[:, k] == pytest.approx(alone.nuisances_rad[:, 0], abs=1e-12)


def test_vague_frames_hardly_pull_the_fit():
    """Catches: a fit without weights."""
    largest = np.argsort(np.abs(LAW))[-10:]
    measured = LAW.copy()
    measured[largest] = 0.0
    sd = np.full(FRAMES, 0.02)
    sd[largest] = 2.0
    made = model(phase_sd=sd)
    assert fitted(measured, made).gain == pytest.approx([1.0], abs=0.001)
    assert abs(fitted(measured).gain[0] - 1.0) > 0.02


def test_the_robust_residual_shows_a_lie_where_it_is():
    """Catches: a lie of a second that is spread over the film, by which its own place shows less."""
    lie = slice(130, 160)
    measured = LAW + lasting_noise(size=0.01)
    measured[lie] = measured[130]
    made = HonestModel(series_of(LAW, measured), ROOM)
    robust, plain = made.robust_residual_rad(), made.fit(made.series.measured_rad[:, None]).residual_rad[:, 0]
    outside = np.ones(FRAMES, bool)
    outside[lie] = False
    lied = (measured - LAW)[lie]
    assert rms(robust[outside]) < 0.3 * rms(plain[outside])
    apart = robust[lie] - robust[lie].mean() - (lied - lied.mean())
    assert rms(apart) < 0.1 * rms(lied - lied.mean())
