"""A steady course of a badge that is known as built.  Beside each test: what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from moireid.verifier.explanations.steady_course import KnownBuilt, chance_of_delay, chance_of_drift

from moireid.verifier.decision.judge import judge_signals, steady_as_built
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.reasons import worst

TIMES = np.arange(240) / 30.0
KNOWN = KnownBuilt(gain_room=0.03, offset_room_rad=0.1)


def sweep(rad_per_s: float, stretches: int = 1) -> GratingSignal:
    """A true badge on one steady sweep."""
    course = rad_per_s * (TIMES - TIMES.mean())
    number = np.arange(240) * stretches // 240
    return GratingSignal(
        course, course, np.full(240, 0.01), 0.01, np.array([0.005]), TIMES, np.array([0.02]), stretch=number
    )


def always(_: GratingSignal) -> bool:
    """Stands for a judge whom only what is known of the badge as built can help."""
    return True


def test_a_drift_must_meet_gain_and_offset_by_chance():
    """Catches: one of the two left out, or a room counted once where it lies on both sides."""
    expected = (2 * KNOWN.gain_room / 5.0) * (2 * KNOWN.offset_room_rad / (2 * math.pi))
    assert chance_of_drift(sweep(0.9), always, KNOWN) == pytest.approx(expected, rel=1e-3)
    assert chance_of_drift(sweep(0.9), always) > 10 * expected


@pytest.mark.parametrize(("rad_per_s", "passing"), [(0.9, 0), (0.45, 1), (0.3, 2), (0.09, 9)])
def test_a_delay_shows_as_an_offset_where_the_course_is_fast(rad_per_s, passing):
    """Catches: a delay's shift that is centred away; a slow sweep, on which a delay hardly shifts, taken for proof."""
    assert chance_of_delay(sweep(rad_per_s), always, KNOWN) == pytest.approx(passing / 9)
    assert chance_of_delay(sweep(rad_per_s), always) == 1.0


def test_each_stretch_must_keep_the_offset():
    """Catches: shifts of two stretches, one forth and one back, that cancel in the mean over the film."""
    there = sweep(0.9, 2)
    back = replace(there, predicted_rad=np.where(there.stretch == 0, 0.9, -0.9) * (TIMES % 4.0 - 2.0))
    assert chance_of_delay(back, always, KNOWN) == 0.0


def test_the_badge_as_built_opens_a_steady_film_and_nothing_else():
    """Catches: other open findings waved through; a film accepted without what is known."""
    film = judge_signals([sweep(0.9)])
    assert film.verdict == "inconclusive"
    assert steady_as_built(film, [sweep(0.9)], None) is film
    told = steady_as_built(film, [sweep(0.9)], KNOWN)
    assert told.verdict == "accept"
    (steady,) = [reason for reason in told.reasons if reason.code == "steady"]
    assert steady.level == "pass" and "enrolled" in steady.text
    slow = judge_signals([sweep(0.3)])
    assert steady_as_built(slow, [sweep(0.3)], KNOWN).verdict == "inconclusive"
    strayed = [replace(sweep(0.9), stray_share=0.2)]
    open_twice = judge_signals(strayed)
    assert steady_as_built(open_twice, strayed, KNOWN).verdict == worst(list(open_twice.reasons)) == "inconclusive"
