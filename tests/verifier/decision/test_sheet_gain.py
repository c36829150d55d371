"""The gain as a property of the built badge.  Beside each test: what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from moireid.asbuilt import AsBuilt
from moireid.designer import Order, design_badge
from moireid.verifier.decision.judge import Invariant, judge
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed, to_measure
from moireid.verifier.fringes.grating_signal import DepthLaw, GratingSignal
from moireid.verifier.limits import BUILT_GAIN_ROOM_SHARE, BUILT_GAIN_SDS, ENROLLED_GAINS

TIMES = np.arange(240) / 30.0
BADGE = design_badge(Order("Bench", lens="75lpi"), bytes.fromhex("0f5ac3962d784be1"))
BUILT = AsBuilt(str(BADGE.id), -0.05, 1e-5, 0.0, 0.01, 0.0, 1e-4, 0.72, 0.007)


def filmed(gain: float, *, wobble: float = 0.0, steady: bool = False, tangent_sd: float = 0.005) -> GratingSignal:
    """A hand's film of a badge whose fringes move `gain` times as far as designed, and tremble by `wobble` rad."""
    course = 1.2 * (np.sin(2 * np.pi * 0.31 * TIMES) + 0.6 * np.sin(2 * np.pi * 0.83 * TIMES + 1))
    course = 0.9 * TIMES if steady else course
    course = course - course.mean()
    noise = 0.02 * np.random.default_rng(4).standard_normal(len(TIMES))
    measured = gain * course + noise + wobble * np.sin(2 * np.pi * 1.7 * TIMES)
    sd = np.full(len(TIMES), 0.02)
    strip = np.array([0.005])
    return GratingSignal(measured, course, sd, 0.01, strip, TIMES, np.array([0.02]), tangent_sd=tangent_sd)


def judged(signal: GratingSignal, sheet: SheetGain) -> Invariant:
    return judge([signal.under(sheet.expected)], sheet)


def level(outcome: Invariant, code: str) -> str:
    return next(reason.level for reason in outcome.reasons if reason.code == code)


@pytest.mark.parametrize("gain", [0.4, 0.68, 0.8, 1.2, 1.4, 2.1])
def test_another_sheet_is_open_with_its_cause_and_never_accepted(gain):
    """Catches: a shop's sheet taken for a forgery, by the gain or by the likelihood; one that makes an accept."""
    outcome = judged(filmed(gain), designed(BADGE))
    assert outcome.verdict == "inconclusive"
    assert [reason.code for reason in outcome.reasons if reason.level != "pass"] == ["gain"]
    text = next(reason.text for reason in outcome.reasons if reason.code == "gain")
    assert ("thinner" in text) == (gain < 1) and "Enroll this badge with a film of it" in text
    assert outcome.gain_ratio == pytest.approx(gain, abs=0.01)


@pytest.mark.parametrize("gain", [0.1, -1.0, 0.0])
def test_what_no_build_can_do_is_rejected(gain):
    """Catches: room for every gain."""
    assert judged(filmed(gain), designed(BADGE)).verdict == "reject"


def test_enrolment_measures_the_gain_over_a_finite_range():
    """Catches: a capture refused for its gain; one of any gain; a measured gain given as 1."""
    for gain in (0.55, 0.72, 1.0, 1.55):
        outcome = judged(filmed(gain), to_measure())
        assert outcome.verdict == "accept"
        assert outcome.gain_ratio == pytest.approx(gain, abs=0.01) and outcome.gain_expected == 1.0
    for gain in (ENROLLED_GAINS[0] - 0.1, ENROLLED_GAINS[1] + 0.1):
        outcome = judged(filmed(gain), to_measure())
        (text,) = [reason.text for reason in outcome.reasons if reason.code == "gain"]
        assert outcome.verdict == "inconclusive" and "can be enrolled with 0.5 to 1.6" in text
        # Catches: one who enrolls told to enroll.
        assert "Enroll this badge" not in text


def test_a_free_gain_makes_a_steady_sweep_prove_less():
    """Catches: drifts counted in the narrow room where any gain may be enrolled."""
    sweep = filmed(1.0, steady=True)
    narrow, wide = (judged(sweep, sheet) for sheet in (designed(BADGE), to_measure()))
    assert level(narrow, "drift") == level(wide, "drift") == "undecided"
    shares = [next(one.share for one in found.explanations if one.name == "drift") for found in (narrow, wide)]
    assert shares[1] > 2.5 * shares[0] > 0


def test_a_badge_known_as_built_has_its_own_gain():
    """Catches: the design's gain expected of it; a lie of 7 % that passes; a loose sheet rejected."""
    sheet = as_built(BADGE, BUILT)
    true = judged(filmed(0.72), sheet)
    assert true.verdict == "accept"
    assert true.gain_ratio == pytest.approx(1.0, abs=0.01) and true.gain_expected == 0.72
    for lie in (0.93, 1.07, 1 / 0.72):
        assert judged(filmed(0.72 * lie), sheet).verdict == "inconclusive"
    for lie in (0.5, 2.6):
        assert judged(filmed(0.72 * lie), sheet).verdict == "reject"


def test_the_room_of_a_built_badge_grows_with_error_bars_but_not_beyond_the_design_s():
    """Catches: a far film that no gain passes; a vague one that passes wider than an unknown badge."""
    sheet = as_built(BADGE, BUILT)
    assert sheet.room_for(0.01) == pytest.approx((1 - BUILT_GAIN_ROOM_SHARE, 1 + BUILT_GAIN_ROOM_SHARE))
    half = BUILT_GAIN_SDS * math.hypot(0.06, sheet.sd)
    assert sheet.room_for(0.06) == pytest.approx((1 - half, 1 + half))
    assert sheet.room_for(0.2) == designed(BADGE).room == sheet.room
    assert as_built(BADGE, replace(BUILT, gain_sd=0.072)).room_for(0.01)[1] == pytest.approx(
        1 + BUILT_GAIN_SDS * math.hypot(0.01, 0.072 / BUILT.gain_ratio)
    )


def test_the_spacing_of_a_thin_sheet_is_held_against_its_own_law():
    """Catches: a depth law left at the design's gain; evidence that is not scaled."""
    change = np.random.default_rng(1).normal(0, 0.01, (50, 20))
    left = (0.7 - 1) * change
    score, information = np.sum(left * change, axis=1), np.sum(change**2, axis=1)
    law = DepthLaw(score, information, information * np.mean(change**2, axis=1))
    thin = law.under(0.7)
    assert 1 + law.score.sum() / law.information.sum() == pytest.approx(0.7)
    assert thin.score.sum() / thin.information.sum() == pytest.approx(0.0, abs=1e-12)
    assert thin.power.sum() == pytest.approx(0.7**4 * law.power.sum())
