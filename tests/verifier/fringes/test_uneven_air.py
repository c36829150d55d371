"""Rows over more air than others.  Beside each test: what it would catch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kit.numeric_films import Building, course, filmed, lines_seen
from moireid.question import Question
from moireid.verifier.fringes.uneven_air import less_uneven_air
from moireid.verifier.session.chapters import judge_chapter

MOTION = 0.7 * np.sin(np.linspace(0, 9, 200)) + 0.3
GAINS = np.array([[0.06], [-0.02], [-0.04]])
WEIGHT, NONE = np.ones((3, 200)), np.zeros(200)


def test_gains_of_their_own_are_taken_away_up_to_a_bound():
    """Catches: a gain that is taken away whole, however large; a mean of the motion that counts as a gain; a part of a
    gain that air cannot explain taken away."""
    centred = MOTION - MOTION.mean()
    assert less_uneven_air(GAINS * centred, WEIGHT, MOTION, NONE) == pytest.approx(0.0, abs=1e-12)
    far = np.array([[0.1], [0.15], [-0.15], [0.175], [-0.2], [0.6]])
    left = less_uneven_air(far * centred, np.ones((6, 200)), MOTION, NONE)
    assert left == pytest.approx(np.array([[0.0], [0.05], [-0.05], [0.125], [-0.2], [0.6]]) * centred, abs=1e-12)
    # From aside, a part that is glued and one that is laid on differ by what air adds, and by no more.
    aside = less_uneven_air(far * centred, np.ones((6, 200)), MOTION, -0.3 * MOTION)
    assert aside == pytest.approx(np.array([[0.0], [0.0], [0.0], [0.0], [0.0], [0.6]]) * centred, abs=1e-12)


@pytest.mark.parametrize(("share", "verdict"), [(0.08, "accept"), (0.5, "reject")])
def test_places_are_excused_for_what_air_explains_and_for_no_more(ada, share, verdict):
    """Catches: uneven air that excuses a part of what it cannot explain; air of the usual size that rejects a badge."""
    track, camera, built = filmed(ada), course(ada), Building()
    profiles = []
    for strip, own in zip(track.strips, track.profiles, strict=True):
        turn = lines_seen(ada, strip, camera, built)
        motion = (turn - turn.mean(axis=0)).mean(axis=1, keepdims=True)
        further = turn + share * motion * np.cos(2 * np.pi * strip.along_mm / 60)
        profiles.append((own + waves(further) - waves(turn)).astype(np.float32))
    judged = judge_chapter(replace(track, profiles=tuple(profiles)), Question(ada)).invariant
    assert judged.verdict == verdict, [reason for reason in judged.reasons if reason.level != "pass"]


def waves(turn):
    """Brightness of fringes."""
    return -40.0 * (np.cos(turn) + 0.25 * np.cos(2 * turn) - 0.15 * np.cos(3 * turn))


def test_other_motion_and_frames_without_weight_are_left_alone(rng):
    """Catches: a motion of rows by themselves that is fitted away; frames of no weight that decide on the gain."""
    own = rng.standard_normal((3, 200))
    moved = MOTION - MOTION.mean()
    own -= own.mean(axis=1, keepdims=True) + (own @ moved / (moved @ moved))[:, None] * moved
    assert less_uneven_air(own, WEIGHT, MOTION, NONE) == pytest.approx(own)
    wild, weight = own.copy(), WEIGHT.copy()
    wild[:, :9], weight[:, :9] = 1e6, 0.0
    kept = less_uneven_air(wild, weight, MOTION, NONE)[:, 9:]
    assert np.abs(kept - own[:, 9:]).max() < 0.2
