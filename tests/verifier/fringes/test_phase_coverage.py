"""How much of the fringes' way a film shows.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.phase_coverage import SeenWay, seen_way
from moireid.verifier.limits import MAX_UNSEEN_WAY_SHARE

RNG = np.random.default_rng(3)
TIMES = np.arange(120) / 12.0


def shown(places_rad: list[float], frames: int = 120, noise_rad: float = 0.01) -> np.ndarray:
    """Phases of photographs shown in turn."""
    return np.resize(places_rad, frames) + noise_rad * RNG.standard_normal(frames)


@pytest.mark.parametrize("count", [2, 3, 5, 9])
@pytest.mark.parametrize("apart_rad", [0.3, 3.0])
def test_nine_photographs_show_a_few_places(count, apart_rad):
    """Catches: a limit in radians, and not in shares of the way; one for the widest gap over the whole range."""
    assert seen_way(shown(list(apart_rad * np.arange(count)))).unseen_share > 0.75


def test_fourteen_places_at_even_distances_are_a_way():
    """Catches: another limit than the one that is derived."""
    assert seen_way(shown(list(0.5 * np.arange(14)), 1400, 0.0)).unseen_share == 0.0


def test_the_shares_are_those_of_gini_s_difference():
    """Catches: F in place of F (1 - F); frames counted in place of views."""
    few = seen_way(np.repeat([0.0, 1.0, 5.0], [50, 3, 1]))
    assert few.whole == pytest.approx(3 * (2 / 9 + 4 * 2 / 9))
    assert few.unseen == pytest.approx(few.whole)


@pytest.mark.parametrize("rate_hz", [0.3, 0.9])
@pytest.mark.parametrize("size_rad", [0.4, 2.0, 20.0])
def test_a_hand_s_motion_at_twelve_frames_a_second_is_seen_all_along(rate_hz, size_rad):
    """Catches: gaps between neighbours in time, which are wide where a hand is quick; a limit in radians."""
    phase = size_rad * np.sin(2 * np.pi * rate_hz * TIMES + 0.7 * np.sin(1.3 * TIMES))
    assert seen_way(phase + 0.01 * RNG.standard_normal(120)).unseen_share < 0.1


def test_a_badge_that_rests_between_two_moves_is_seen_all_along():
    """Catches: views weighted by the time for which they are seen, by which all but the rest would be unseen."""
    time = np.arange(900) / 30.0
    away = [np.clip((time - start) / 0.9, 0, 1) for start in (3.02, 4.0, 20.04, 21.3)]
    one, back, two, again = (10 * t**3 - 15 * t**4 + 6 * t**5 for t in away)
    assert seen_way(1.5 * (one - back) - 0.9 * (two - again) + 0.01 * RNG.standard_normal(900)).unseen_share < 0.1


def test_a_stray_phase_takes_little_from_a_film():
    """Catches: the whole range as the way, which one wrong frame makes long."""
    phase = np.append(2.0 * np.sin(2.1 * TIMES), 6.0)
    assert seen_way(phase).unseen_share < MAX_UNSEEN_WAY_SHARE


def test_chapters_count_by_what_they_show():
    """Catches: a mean of shares, by which an hour of rest would excuse photographs."""
    two, rest = seen_way(shown([0.0, 1.0])), seen_way(shown([0.0], 4000, 0.001))
    assert (two + rest).unseen_share > 0.9
    assert SeenWay().unseen_share == seen_way(np.zeros(0)).unseen_share == seen_way(np.zeros(5)).unseen_share == 0.0
