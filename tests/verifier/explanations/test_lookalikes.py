"""How often rivals look as law-like as a film.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.fringe_signals import clock, fringe_signal, lasting_noise, trajectory
from moireid.verifier.explanations.honest import HonestModel, phase_series
from moireid.verifier.explanations.residuals import spread_rad
from moireid.verifier.explanations.rivals import lookalike_shares, resampled
from moireid.verifier.limits import ALIKE_RATIO, DRAWS, FORGED_GAINS, LEAST_STRENGTH, RESAMPLED_SHARE

ROOM = (0.85, 1.15)
ALLOWED = 1 / LEAST_STRENGTH
SWAY = 1.2 * trajectory()
SWEEP = 0.6 * (clock() - clock().mean())
#: Of a drift: the width of the room of gains, over that of all gains of forgers.
WINDOW = (ROOM[1] - ROOM[0]) / (FORGED_GAINS[1] - FORGED_GAINS[0])


def shares(law: np.ndarray, *, reach=ROOM, room=ROOM, constant: float | None = None, seed: int = 0, **how):
    """Shares of a true film on such a trajectory, by the rivals' names."""
    series = phase_series(fringe_signal(law, law + lasting_noise(len(law)), **how))
    assert series is not None
    model = HonestModel(series, reach)
    left = model.fit(series.measured_rad[:, None]).residual_rad[:, 0]
    return lookalike_shares(model, left, room, allowed=ALLOWED, constant_room_rad=constant, seed=seed)


def within(share, wanted: float) -> None:
    """The estimate is within four standard deviations of a closed form, and the bounds enclose it."""
    assert share.share == pytest.approx(wanted, abs=4 * (wanted * (1 - wanted) / DRAWS) ** 0.5)
    assert share.at_least - 1e-12 <= wanted <= share.at_most + 1e-12


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_on_varied_motion_no_rival_looks_like_the_law(seed):
    """Catches: shares of a rival that is never refitted, or that is compared at any gain."""
    found = shares(1.2 * trajectory(seed), place_px=np.column_stack([300 * trajectory(8), 0 * SWAY]))
    assert list(found) == ["still", "drift", "place", "own_motion"]
    assert all(one.share == 0.0 and one.at_most < ALLOWED for one in found.values())


def test_on_one_steady_sweep_a_drift_does_by_the_width_of_the_room():
    """Catches: drifts of the right speed alone.  Closed form."""
    found = shares(SWEEP)
    within(found["drift"], WINDOW)
    assert found["still"].share == found["own_motion"].share == 0.0


def test_the_drift_s_share_goes_with_the_room():
    """Catches: one window for a badge that is known and for one that is being enrolled."""
    wide = (0.5, 1.6)
    within(shares(SWEEP, reach=wide, room=wide)["drift"], 1.1 / 5)
    within(shares(SWEEP, room=(0.96, 1.04))["drift"], 0.08 / 5)


@pytest.mark.parametrize("px", [1.0, -1.0, 0.2])
def test_a_badge_that_only_shifts_can_be_forged_from_its_place(px):
    """Catches: a slope that must be right in pixels; a share that depends on them."""
    place = np.column_stack([640 + 180 * px * SWAY, 360 + 0 * SWAY])
    for place_px in (place, place[:, ::-1]):
        within(shares(SWAY, place_px=place_px)["place"], WINDOW)
    turned = SWAY + 0.7 * trajectory(5)
    assert shares(turned, place_px=place)["place"].share == 0.0
    assert shares(SWAY)["place"].share == 0.0


def test_shares_are_the_same_each_time_and_hardly_depend_on_the_seed():
    """Catches: verdicts that change from one run to the next; draws so few that chance decides."""
    vague = {"phase_sd": 0.05}
    assert shares(SWEEP, **vague) == shares(SWEEP, **vague)
    for seed in range(6):
        within(shares(SWEEP, seed=seed, **vague)["drift"], WINDOW)


@pytest.mark.parametrize("room", [(0.96, 1.04), (0.9, 1.1)])
def test_a_share_is_that_of_forgeries_drawn_from_the_whole_prior(room, rng):
    """Catches: a chance of the wrong width or sign, and draws that are not of the prior.  By plain draws, place only
    partly right, so that some of a fitting gain leave too much."""
    shift = SWAY + 0.009 * trajectory(5)
    series = phase_series(fringe_signal(SWAY, SWAY + lasting_noise(), place_px=np.column_stack([shift, 0 * shift])))
    assert series is not None
    model = HonestModel(series, ROOM)
    left = model.fit(series.measured_rad[:, None]).residual_rad[:, 0]
    found = lookalike_shares(model, left, room, allowed=ALLOWED)["place"]
    column = series.centred(series.place_px)[:, :1]
    near = column * (series.weight @ (column[:, 0] * series.law_rad)) / (series.weight @ column[:, 0] ** 2)
    noise = series.centred(RESAMPLED_SHARE * resampled(left, series.step_s, rng, 20000))
    fit = model.fit(near * rng.uniform(*FORGED_GAINS, 20000) + noise)
    alike = (room[0] <= fit.gain) & (fit.gain <= room[1])
    alike &= spread_rad(fit.residual_rad) <= ALIKE_RATIO * spread_rad(left[:, None])[0]
    plain = float(alike.mean())
    assert 0.002 < plain < 0.9 * (room[1] - room[0]) / 5
    assert found.share == pytest.approx(plain, abs=4 * (plain / 20000) ** 0.5 + 0.1 * plain)
    assert found.at_least <= plain + 0.003 and plain - 0.003 <= found.at_most


def test_a_badge_known_as_built_that_only_shifts_is_surely_below_one_in_fifty():
    """Catches: a share that stays undecided though it is known in closed form."""
    found = shares(SWAY, room=(0.96, 1.04), place_px=np.column_stack([640 + 180 * SWAY, 0 * SWAY]))["place"]
    assert found.at_most == pytest.approx(0.08 / 5, rel=0.01)
    assert found.at_most < ALLOWED


def test_a_known_constant_lowers_a_share_by_chance():
    """Catches: a room counted on one side of two; a chance of more than 1 where the room is the whole turn."""
    free, known = shares(SWEEP)["drift"], shares(SWEEP, constant=0.1)["drift"]
    assert known.at_most < ALLOWED < free.at_least
    within(shares(SWEEP, constant=1.0)["drift"], WINDOW / np.pi)
    assert shares(SWEEP, constant=50.0)["drift"] == free


def test_little_motion_leaves_rivals_a_share():
    """Catches: residuals compared with the motion and not with the film's own."""
    series_noise = lasting_noise(size=0.3)
    series = phase_series(fringe_signal(0.3 * SWAY, 0.3 * SWAY + series_noise))
    assert series is not None
    model = HonestModel(series, (0.0, 2.0))
    left = model.fit(series.measured_rad[:, None]).residual_rad[:, 0]
    found = lookalike_shares(model, left, (0.0, 2.0), allowed=ALLOWED)
    assert max(one.at_least for one in found.values()) > ALLOWED


# The film's own residual, drawn anew.


def test_a_resampled_residual_keeps_its_size_and_its_memory(rng):
    """Catches: frames drawn one by one, which are whiter than any film's residual; blocks that are all alike."""
    residual = lasting_noise(900, 0.03, lasting=0.8)
    drawn = resampled(residual, 1 / 30, rng, 100)
    assert drawn.shape == (900, 100)
    assert drawn.std() == pytest.approx(residual.std(), rel=0.05)
    lag = [np.corrcoef(one[1:], one[:-1])[0, 1] for one in drawn.T]
    # A block of 15 frames keeps 14 of 15 neighbours.
    assert np.mean(lag) == pytest.approx(0.8 * 14 / 15, abs=0.05)
    assert abs(np.corrcoef(drawn[:, 0], drawn[:, 1])[0, 1]) < 0.3
    assert abs(drawn.mean()) < 0.003
