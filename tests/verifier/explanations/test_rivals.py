"""Rivals of the law over a whole film.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.fringe_signals import FRAMES, apart_from, clock, lasting_noise, series_of, trajectory
from moireid.verifier.explanations.honest import HonestModel, PhaseSeries
from moireid.verifier.explanations.residuals import independent_samples
from moireid.verifier.explanations.rivals import RIVALS, delayed, rival_odds
from moireid.verifier.limits import DELAYS_S, MAX_LAG_S, MAX_RIVAL_LOG10

ROOM = (0.85, 1.15)
EXCITATION = 1.2
LAW = EXCITATION * trajectory()
#: The badge shifts in the picture along a trajectory of its own, and trembles up and down.
PLACE_PX = np.column_stack([640 + 180 * trajectory(5), 360 + 3 * apart_from(LAW, 6)])
BY_NAME = {rival.name: rival for rival in RIVALS}
#: What each whole-film rival makes of the fringes, rad.
MADE = {
    "still": 0 * LAW,
    "drift": 0.4 * (clock() - clock().mean()),
    "late": EXCITATION * trajectory(late_s=0.4),
    "place": (PLACE_PX[:, 0] - 640) / 200,
    "another_gain": 1.7 * LAW,
}


def one_delayed(series: PhaseSeries, delay_s: float) -> np.ndarray:
    """The law later by one delay, (N,)."""
    return delayed(series, np.array([delay_s]))[:, 0]


def filmed(measured: np.ndarray, **how) -> PhaseSeries:
    return series_of(LAW, measured + lasting_noise(size=0.02), place_px=PLACE_PX, **how)


def odds_on(series: PhaseSeries, room=ROOM) -> dict[str, float]:
    """Logarithm of the odds of the law over each rival that has them."""
    return {name: found[0] for name, found in found_on(series, room).items()}


def found_on(series: PhaseSeries, room=ROOM) -> dict[str, tuple[float, dict[str, float]]]:
    left = HonestModel(series, room).fit(series.measured_rad[:, None]).residual_rad[:, 0]
    own, samples = float(series.weight @ left**2), independent_samples(left)
    found = {rival.name: rival_odds(rival, series, own, samples, room) for rival in RIVALS}
    return {name: one for name, one in found.items() if one is not None}


def drawn(name: str, series: PhaseSeries, count: int = 200) -> np.ndarray:
    return BY_NAME[name].draws(series, np.random.default_rng(1), count)


# The law, later.


@pytest.mark.parametrize("delay_s", [0.2, 0.5, 1.3, -0.2, -0.75])
def test_the_law_so_much_later_is_the_law_at_an_earlier_time(delay_s):
    """Catches: a lead taken for a delay; a delay in frames.  Closed form: the wave itself, within the film."""
    series = series_of(LAW)
    times = clock()
    inside = (times - delay_s >= 0) & (times - delay_s <= times[-1])
    wanted = EXCITATION * trajectory(late_s=delay_s)
    assert one_delayed(series, delay_s)[inside] == pytest.approx(wanted[inside], abs=0.02)


@pytest.mark.parametrize("delay_s", [0.2, 2.0, -2.0, 4.9])
def test_a_steady_sweep_goes_on_beyond_its_ends(delay_s):
    """Catches: fringes that rest before the film begins, which no delayed film shows.  Closed form: -rate x delay."""
    stretch = np.repeat([0, 1], [150, 150])
    rate = np.where(stretch == 0, 0.6, -0.3)
    series = series_of(rate * clock(), stretch=stretch)
    assert one_delayed(series, delay_s) == pytest.approx(series.law_rad - rate * delay_s, abs=1e-9)


def test_beyond_an_end_the_law_goes_on_at_its_speed_there():
    """Catches: a speed from two noisy frames; the mean speed of the whole film."""
    times = clock()
    kinked = np.where(times < 5, 0.8 * times, 4.0)
    series = series_of(kinked)
    shift = series.law_rad - one_delayed(series, 1.0)
    assert shift[times < 5] == pytest.approx(np.full(150, 0.8), abs=1e-9)
    assert shift[times > 6.1] == pytest.approx(np.zeros(116), abs=1e-9)


# Odds.


@pytest.mark.parametrize("name", list(MADE))
def test_each_rival_beats_the_law_on_what_it_made_and_no_other_beats_it(name):
    """Catches: a shape that is not its rival's; a best variant that is the first one.

    A rival that contains this one fits as well, as a drift of speed 0 does where fringes stay still.
    """
    odds = odds_on(filmed(MADE[name]))
    assert odds[name] < -3 * MAX_RIVAL_LOG10
    assert odds[name] < min(odds.values()) + 0.5


def test_the_law_beats_each_rival_on_a_true_film():
    """Catches: odds of the rival over the law; a rival so free that it fits any film."""
    odds = odds_on(filmed(LAW))
    assert odds.keys() == MADE.keys()
    assert min(odds.values()) > 50


def test_a_film_between_law_and_rival_is_decided_by_the_nearer():
    """Catches: a rival that is not fitted, but compared at its usual size."""
    drifting = filmed(LAW + 0.2 * MADE["drift"])
    assert odds_on(drifting)["drift"] > 0
    assert odds_on(filmed(0.05 * LAW + 3.0 * MADE["drift"]))["drift"] < -3 * MAX_RIVAL_LOG10


def test_fitted_delays_begin_where_a_codec_s_lag_ends():
    """Catches: an honest lag called a rival."""
    assert min(DELAYS_S) > MAX_LAG_S


@pytest.mark.parametrize(
    ("gain", "found"), [(1.0, ROOM), (1.1, ROOM[1:]), (0.88, ROOM[:1]), (1.7, (1.7,)), (-1, (-1,))]
)
def test_another_gain_is_one_outside_of_what_honest_badges_have(gain, found):
    """Catches: the law's own gain as a rival, which fits any true film as well as the law."""
    odds, parameters = found_on(filmed(gain * LAW))["another_gain"]
    assert min(abs(parameters["gain"] - one) for one in found) < 0.01
    assert (odds > 3) == (ROOM[0] < gain < ROOM[1])


def test_a_place_has_two_directions_and_any_slope():
    """Catches: x alone; a slope of the page's own millimetres; a constant that a cut may not change."""
    stretch = np.repeat([0, 1], [150, 150])
    for px in (PLACE_PX, PLACE_PX[:, ::-1], 1e-3 * PLACE_PX, PLACE_PX + 300.0 * stretch[:, None]):
        series = series_of(LAW, MADE["place"] + lasting_noise(), place_px=px, stretch=stretch)
        assert odds_on(series)["place"] < -3 * MAX_RIVAL_LOG10


# Priors.


def test_own_motions_are_as_wide_as_the_law_smooth_and_unlike_it():
    """Catches: forgeries too small to be taken for the badge; ones that jitter, or that follow the law."""
    series = series_of(LAW, stretch=np.repeat([0, 1], [120, 180]))
    motions = drawn("own_motion", series)
    assert np.sqrt(np.mean(motions**2, axis=0)) == pytest.approx(np.full(200, series.excitation_rad))
    assert series.centred(motions) == pytest.approx(motions, abs=1e-9)
    whole = drawn("own_motion", series_of(LAW))
    power = np.abs(np.fft.rfft(whole * np.hanning(FRAMES)[:, None], axis=0)) ** 2
    fast = np.fft.rfftfreq(FRAMES, 1 / 30) > 2
    assert (power[fast].sum(axis=0) / power.sum(axis=0)).max() < 0.01
    alike = [np.corrcoef(whole[:, k], LAW)[0, 1] for k in range(200)]
    assert abs(np.mean(alike)) < 0.1 and np.max(alike) < 0.9
