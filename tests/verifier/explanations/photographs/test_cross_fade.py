"""Does the waveform change as that of a few photographs does?  Beside each test: what it would catch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kit.photographed import FRAMES, LAW, TIMES, TYPICAL, found_in, noise_of, signal
from moireid.verifier.decision.judge import judge
from moireid.verifier.explanations.photographs.cross_fade import MOST_SHARE, CrossFade, cross_fade_of
from moireid.verifier.explanations.photographs.fringe_spacing import cross_faded
from moireid.verifier.limits import MAX_CROSS_FADE_SHARE

#: A calm course, as wide as some ten degrees turn the badge of the tests.
CALM = 0.2 * LAW


def shown_by(places: np.ndarray | list[float], law: np.ndarray) -> np.ndarray:
    """The overtone of photographs taken at these places, cross-faded along a course."""
    first, third = cross_faded(law, np.asarray(places))
    return TYPICAL * third * np.exp(-3j * np.angle(first)) / np.abs(first)


def fade_of(overtone: np.ndarray, law: np.ndarray = CALM, **how) -> CrossFade:
    found = cross_fade_of(signal(overtone, law=law, **how))
    assert found is not None
    return found


def at(*shares: float, law: np.ndarray = CALM) -> np.ndarray:
    """Places on the course, by their share of its way."""
    return law.min() + np.array(shares) * np.ptp(law)


@pytest.mark.claim("A few cross-faded photographs are found")
@pytest.mark.parametrize("shares", [(0, 1), (0, 0.5, 1), (0, 0.3, 1), (0, 0.2, 0.6, 1)])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_few_photographs_are_seen_wherever_they_were_taken(shares, noise):
    """Catches: places at even distances alone; the form of two alone; a smooth course that takes it all up."""
    law = (0.2 if len(shares) < 4 else 0.4) * LAW
    found = fade_of(shown_by(at(*shares, law=law), law) + noise_of(noise, 1), law)
    assert 0.5 < found.share < MOST_SHARE and found.seen
    assert found.certain < found.share


@pytest.mark.parametrize("wide", [0.15, 0.2, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("noise", [0.001, 0.01, 0.05])
def test_a_badge_is_not_taken_for_photographs(wide, noise):
    """Catches: noise fitted by the best of many forms; a way of several turns, whose forms are wild."""
    found = [fade_of(TYPICAL + noise_of(noise, seed, 0.6), wide * LAW) for seed in range(10)]
    assert not any(one.seen for one in found)


@pytest.mark.parametrize("bend", ["place", "distance", "uneven"])
def test_what_a_lens_does_is_left_out(bend):
    """Catches: a badge whose fringes are less sharp on one side, or farther away, or not quite alike."""
    near = 1e-3 * (1 + 0.03 * np.sin(2 * np.pi * 0.23 * TIMES + 0.4))
    series = {"place": CALM, "distance": near, "uneven": np.cos(2 * np.pi * CALM / np.ptp(CALM))}[bend]
    size = 0.02 if bend == "uneven" else 0.3
    standard = (series - series.mean()) / series.std()
    assert fade_of(TYPICAL * (1 + size * standard), near=near).certain < 0.1


def test_a_quick_badge_in_low_light_is_none():
    """Catches: the blur of a long exposure, deepest where the badge is quickest, as in the middle of its way."""
    way = 400 * np.sin(2 * np.pi * 0.31 * TIMES) + 20 * np.sin(2 * np.pi * 1.1 * TIMES)
    law = 0.6 * np.sin(2 * np.pi * 0.31 * TIMES)
    step = np.gradient(way)
    blurred = TYPICAL * (1 - 0.95 * (step / np.abs(step).max()) ** 2)
    moving = signal(blurred, law=law)
    seen = replace(moving, beyond=replace(moving.beyond, place_px=np.column_stack([way, 0 * way])))
    assert cross_fade_of(seen).certain < 0.1
    # The same change of a badge that rests in the picture is none of a camera's.
    assert cross_fade_of(moving).certain > MAX_CROSS_FADE_SHARE


@pytest.mark.parametrize("rest", [10, 40])
def test_rests_hide_no_photographs(rest):
    """Catches: a mean over frames, in which one mixed frame of forty counts for nothing."""
    share = np.random.default_rng(1).uniform(0.05, 0.95, FRAMES)
    law = np.concatenate([np.r_[np.full(rest, -0.4), -0.4 + 0.8 * one, np.full(rest, 0.4)] for one in share])
    law = np.tile(law, 1)[: FRAMES * (2 * rest + 1)]
    picked = np.sort(np.random.default_rng(2).choice(len(law), FRAMES, replace=False))
    course = law[picked]
    assert fade_of(shown_by([-0.4, 0.4], course), course).seen


def test_the_finding_leaves_a_film_open_and_a_badge_alone():
    """Catches: a finding that rejects, that says nothing of what to do, or that is not acted upon."""
    told = found_in(signal(TYPICAL + noise_of(0.001, 1), law=CALM))["cross_fade"]
    assert told.level == "pass" and told.measured < 0 < told.limit
    photographs = signal(shown_by(at(0, 1), CALM), law=CALM)
    told = found_in(photographs)["cross_fade"]
    assert told.level == "undecided" and told.measured > told.limit == MAX_CROSS_FADE_SHARE
    assert "photographs" in told.text and "Film in even light" in told.text
    outcome = judge([photographs])
    assert outcome.verdict != "reject" and "cross_fade" in [
        one.code for one in outcome.reasons if one.level == "undecided"
    ]
