"""Tone, halos and exposure on pictures made up.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.takes import SIZE, a_take
from moireid.simulate.effects.effect import Step
from moireid.simulate.effects.table import effect_named


def step_of(name: str) -> Step:
    begin = effect_named(name).begin
    assert begin is not None
    return begin(a_take())[0]


def test_exposure_follows_what_it_meters_in_steps():
    """Catches: exposure that runs away or goes with the light; one without steps; a share that is not used."""
    shown = {}
    for strength in ("light", "strong"):
        step = step_of(f"exposure:{strength}")
        shown[strength] = [step(k, np.full(SIZE[::-1], 120 if k < 10 else 60, np.uint8)).mean() for k in range(60)]
    assert shown["strong"][9] == pytest.approx(120) and shown["strong"][10] == pytest.approx(60)
    assert shown["strong"][-1] == pytest.approx(120, rel=0.05)
    assert shown["light"][-1] == pytest.approx(60 * np.sqrt(2**0.5), rel=0.05)
    assert len(set(np.round(shown["strong"][10:]))) < 20
