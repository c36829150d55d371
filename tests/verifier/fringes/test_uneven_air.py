"""Rows over more air than others.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.uneven_air import less_uneven_air

MOTION = 0.7 * np.sin(np.linspace(0, 9, 200)) + 0.3
GAINS = np.array([[0.06], [-0.02], [-0.04]])
WEIGHT = np.ones((3, 200))


def test_gains_of_their_own_are_taken_away_up_to_a_bound():
    """Catches: a gain that is taken away whole, however large; a mean of the motion that counts as a gain."""
    centred = MOTION - MOTION.mean()
    assert less_uneven_air(GAINS * centred, WEIGHT, MOTION) == pytest.approx(0.0, abs=1e-12)
    left = less_uneven_air(10 * GAINS * centred, WEIGHT, MOTION)
    assert left == pytest.approx(np.array([[0.5], [-0.1], [-0.3]]) * centred)


def test_other_motion_and_frames_without_weight_are_left_alone(rng):
    """Catches: a motion of rows by themselves that is fitted away; frames of no weight that decide on the gain."""
    own = rng.standard_normal((3, 200))
    moved = MOTION - MOTION.mean()
    own -= own.mean(axis=1, keepdims=True) + (own @ moved / (moved @ moved))[:, None] * moved
    assert less_uneven_air(own, WEIGHT, MOTION) == pytest.approx(own)
    wild, weight = own.copy(), WEIGHT.copy()
    wild[:, :9], weight[:, :9] = 1e6, 0.0
    kept = less_uneven_air(wild, weight, MOTION)[:, 9:]
    assert np.abs(kept - own[:, 9:]).max() < 0.2
