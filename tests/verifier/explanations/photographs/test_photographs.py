"""Could a film be a table of photographs?  Beside each test: what it would catch."""

from __future__ import annotations

import re

import pytest

from kit.photographed import (
    LAW,
    TYPICAL,
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


def test_a_badge_passes_and_its_texts_hold_no_word_of_photographs_found():
    """Catches: a passing film whose findings read as an accusation, or whose figures are the wrong way round."""
    found = found_in(signal(TYPICAL + noise_of(0.003, 4), depth=depth_of(0.97, change_rad=0.02)))
    levels = {code: reason.level for code, reason in found.items()}
    held = ("spacing", "cross_fade", "third_harmonic")
    assert levels == dict.fromkeys(held, "pass")
    for reason in found.values():
        assert not re.search(r"as on photographs|cross-faded|[Ff]ilm (without|in)|Film again", reason.text), reason.text
    assert found["spacing"].measured == pytest.approx(0.97, abs=0.05) and "follows" in found["spacing"].text
    assert found["cross_fade"].measured <= found["cross_fade"].limit and "keep their shape" in found["cross_fade"].text


def test_a_level_course_is_told_of_as_untested_and_without_a_figure():
    """Catches: the gain of noise shown to a holder whose film simply had one distance."""
    vague = found_in(signal(depth=depth_of(-0.6, noise=3.0, change_rad=0.0005)))["spacing"]
    assert vague.level == "note" and vague.measured is None and not re.search(r"\d", vague.text)


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


def test_the_worst_grating_is_told():
    """Catches: a good grating that hides a bad one."""
    good = signal(TYPICAL + noise_of(0.003, 4))
    both = found_in(good, FEW)
    assert both["cross_fade"].level == "undecided"
    assert both["cross_fade"].measured == found_in(FEW)["cross_fade"].measured


@pytest.mark.parametrize(("gain", "verdict"), [(0.7, "inconclusive"), (0.4, "reject"), (-0.8, "reject")])
def test_fringes_that_tell_of_a_zoom_excuse_a_gain_that_a_zoom_makes(gain, verdict):
    """Catches: a film that was zoomed slowly called a forgery; photographs that stand or turn round excused by it."""
    course = LAW - LAW.mean()
    zoomed, built = signal(depth=depth_of(0.0, change_rad=0.02), measured=gain * course), SheetGain(built=True)
    assert judge([zoomed], built).verdict == verdict
    assert judge([signal(measured=gain * course)], built).verdict == "reject"
