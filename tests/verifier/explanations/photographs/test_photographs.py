"""Could a film be a table of photographs?  Beside each test: what it would catch."""

from __future__ import annotations

import re

import pytest

from kit.photographed import (
    LAW,
    depth_of,
    faded,
    found_in,
    noise_of,
    signal,
)
from moireid.verifier.decision.judge import judge
from moireid.verifier.decision.sheet_gain import SheetGain

# Findings.

FEW = signal(faded(4, 0.3 * LAW) + noise_of(0.002, 1), law=0.3 * LAW)
OPEN = {"spacing": signal(depth=depth_of(0.0, change_rad=0.02)), "cross_fade": FEW}


@pytest.mark.parametrize("code", ["spacing", "cross_fade"])
def test_photographs_leave_a_film_open_and_say_what_to_do(code):
    """Catches: a finding that is not acted upon, one that names the other cause, a text without a next step."""
    found = found_in(OPEN[code])
    levels = {name: reason.level for name, reason in found.items()}
    assert levels.pop(code) == "undecided" and set(levels.values()) <= {"pass", "note"}
    assert "photographs" in found[code].text and re.search(r"Film (without|in) ", found[code].text)
    outcome = judge([OPEN[code]])
    assert outcome.verdict == "inconclusive"
    assert [reason.code for reason in outcome.reasons if reason.level == "undecided"] == [code]


@pytest.mark.parametrize(("gain", "size"), [(-1e3, 0.1), (0.0, 1e3), (1e3, 0.1), (1e3, 1e3)])
def test_neither_ever_rejects_a_film(gain, size):
    """Catches: a zoom, or a shadow that moves, called a forgery."""
    wild = signal(size * faded(4), depth=depth_of(gain, change_rad=0.02))
    found = found_in(wild)
    assert {found["spacing"].level, found["cross_fade"].level} == {"undecided"}
    assert judge([wild]).verdict == "inconclusive"


@pytest.mark.parametrize(("gain", "verdict"), [(0.7, "inconclusive"), (0.4, "reject"), (-0.8, "reject")])
def test_fringes_that_tell_of_a_zoom_excuse_a_gain_that_a_zoom_makes(gain, verdict):
    """Catches: a film that was zoomed slowly called a forgery; photographs that stand or turn round excused by it."""
    course = LAW - LAW.mean()
    zoomed, built = signal(depth=depth_of(0.0, change_rad=0.02), measured=gain * course), SheetGain(built=True)
    assert judge([zoomed], built).verdict == verdict
    assert judge([signal(measured=gain * course)], built).verdict == "reject"
