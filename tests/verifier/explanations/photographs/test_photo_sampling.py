"""What would photographs show?  Beside each test: what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.photographed import (
    FRAMES,
    LAW,
)
from moireid.verifier.explanations.photographs.fringe_spacing import cross_faded


@pytest.mark.parametrize("count", [2, 3, 7, 30])
def test_cross_faded_is_the_sum_of_two_waves_of_real_cosines(count):
    """Catches: shares exchanged, neighbours by parallax taken in time, a harmonic that turns as the first."""
    first, third = cross_faded(LAW, np.linspace(LAW.min(), LAW.max(), count))
    turn = 2 * np.pi * np.arange(64) / 64
    nodes = LAW.min() + np.arange(count) * np.ptp(LAW) / (count - 1)
    for k in range(0, FRAMES, 7):
        shares = np.maximum(0, 1 - np.abs(LAW[k] - nodes) * (count - 1) / np.ptp(LAW))
        assert shares.sum() == pytest.approx(1) and (shares > 0).sum() <= 2
        # Each photograph shows its own wave of harmonics 1 and 3, of contrast 2 and 0.5.
        seen = sum(
            s * (2 * np.cos(turn + at) + 0.5 * np.cos(3 * turn + 3 * at)) for s, at in zip(shares, nodes, strict=True)
        )
        for h, size, told in ((1, 2.0, first[k]), (3, 0.5, third[k])):
            cosine, sine = (seen * np.cos(h * turn)).mean() * 2, (seen * np.sin(h * turn)).mean() * 2
            assert (cosine / size, -sine / size) == pytest.approx((told.real, told.imag), abs=1e-9)


def test_at_a_photograph_s_own_place_it_is_shown_alone():
    """Catches: a cross-fade that never is one photograph; ends of the course beyond the last one."""
    law = np.linspace(-2, 2, 9)
    first, third = cross_faded(law, np.linspace(law.min(), law.max(), 9))
    assert first == pytest.approx(np.exp(1j * law)) and third == pytest.approx(np.exp(3j * law))
    between, dipped = cross_faded(law, np.linspace(law.min(), law.max(), 5))
    assert np.abs(between[1]) == pytest.approx(math.cos(0.5)) and np.abs(dipped[1]) == pytest.approx(abs(math.cos(1.5)))
