"""Fringes that leave the law for a while.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.fringe_signals import FRAMES, clock, lasting_noise, series_of, trajectory
from moireid.verifier.explanations.honest import HonestModel
from moireid.verifier.explanations.rivals import Spell, worst_spell
from moireid.verifier.limits import MAX_RIVAL_LOG10

LAW = 1.2 * trajectory()
LENGTH = 16


def spell_of(measured: np.ndarray, law: np.ndarray = LAW, **how) -> Spell | None:
    series = series_of(law, measured, **how)
    return worst_spell(series, HonestModel(series, (0.85, 1.15)).robust_residual_rad())


def with_lie(begin: int, gain: float, law: np.ndarray = LAW, length: int = LENGTH, seed: int = 4) -> np.ndarray:
    """A true film whose fringes meanwhile move that many times as far, and then are where they should be."""
    measured = law + lasting_noise(len(law), seed=seed)
    part = slice(begin, begin + length)
    measured[part] += (gain - 1) * (law[part] - law[begin])
    return measured


def quiet_places(law: np.ndarray = LAW, length: int = LENGTH) -> np.ndarray:
    """First frames of such a length, those first in which the law moves least."""
    return np.argsort([np.ptp(law[k : k + length]) for k in range(len(law) - length)])


@pytest.mark.parametrize("quantile", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("gain", [0.0, -1.0, 0.5, 2.0])
def test_a_lie_of_half_a_second_is_found_where_it_is_and_as_it_is(quantile, gain):
    """Catches: a mean over the film, which thins a lie out; a place or a gain that is another's."""
    places = quiet_places()
    begin = int(places[int(quantile * len(places))])
    found = spell_of(with_lie(begin, gain))
    assert found is not None and found.log10_odds < -3 * MAX_RIVAL_LOG10
    assert found.gain == gain
    middle = (found.start_s + found.end_s) / 2
    assert middle == pytest.approx((begin + LENGTH / 2) / 30, abs=0.25)
    assert 0.25 < found.end_s - found.start_s < 1.0


@pytest.mark.parametrize("seconds", [0.3, 0.8, 1.5, 3.0])
def test_longer_and_shorter_lies_are_found_too(seconds):
    """Catches: windows of one length.  The fringes stay where they are."""
    law = 0.5 * trajectory(frames=900)
    length = round(30 * seconds) + 1
    begin = int(quiet_places(law, length)[400])
    found = spell_of(with_lie(begin, 0.0, law, length), law)
    assert found is not None and found.log10_odds < -3 * MAX_RIVAL_LOG10 and found.gain == 0.0
    assert found.start_s < (begin + length) / 30 and found.end_s > begin / 30


@pytest.mark.parametrize("seed", range(8))
def test_a_true_film_with_poor_poses_shows_none(seed):
    """Catches: a normal distribution of slips, by which three poor poses are a lie; windows that are not counted."""
    rng = np.random.default_rng(seed)
    measured = LAW + lasting_noise(seed=seed)
    measured[rng.choice(FRAMES, 9, replace=False)] += rng.normal(0, 0.15, 9)
    found = spell_of(measured)
    assert found is not None and found.log10_odds > -MAX_RIVAL_LOG10


def test_noise_alone_rarely_looks_like_a_spell():
    """Catches: the best of many windows taken as if it were the only one."""
    found = [spell_of(LAW + lasting_noise(size=0.03, seed=seed, lasting=0.8)) for seed in range(100)]
    assert sum(one.log10_odds < -MAX_RIVAL_LOG10 for one in found if one is not None) <= 1


def test_a_step_between_two_stretches_is_no_lie():
    """Catches: a window across a cut, where the constant changes by any amount."""
    stretch = np.repeat([0, 1], [140, 160])
    found = spell_of(LAW + lasting_noise() + 2.0 * stretch, stretch=stretch)
    assert found is not None and found.log10_odds > 0
    assert not found.start_s < 140 / 30 <= found.end_s


def test_a_missing_frame_or_two_hide_no_lie():
    """Catches: windows that ask for every frame."""
    begin = int(quiet_places()[100])
    kept = np.delete(np.arange(FRAMES), [begin + 3, begin + 9])
    found = spell_of(with_lie(begin, 0.0)[kept], LAW[kept], times_s=clock()[kept])
    assert found is not None and found.log10_odds < -3 * MAX_RIVAL_LOG10 and found.gain == 0.0


def test_vague_frames_make_all_windows_vaguer_and_none_a_lie():
    """Catches: a unit of slips that is not the film's own."""
    clear = spell_of(with_lie(60, 0.0))
    vague = spell_of(with_lie(60, 0.0) + lasting_noise(size=0.4, seed=7))
    assert clear is not None and vague is not None and vague.log10_odds > clear.log10_odds + 2
