"""A steady sweep of a badge that is known as built.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

from dataclasses import replace

import pytest

from kit.fringe_signals import clock, fringe_signal, lasting_noise, trajectory
from moireid.asbuilt import AsBuilt
from moireid.designer import Order, design_badge
from moireid.verifier.decision.judge import Invariant, judge
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import BUILT_GAIN_ROOM_SHARE, FORGED_GAINS

BADGE = design_badge(Order("Bench", lens="75lpi"), bytes.fromhex("0f5ac3962d784be1"))
UNKNOWN = designed(BADGE)
KNOWN = as_built(BADGE, AsBuilt(str(BADGE.id), -0.05, 1e-5, 0.0, 0.01, 0.0, 1e-4, 1.0, 0.007))
#: How far the phase constant may be from that at enrolment, rad.
CONSTANT_RAD = 0.1
TIMES = clock(240)


def sweep(rad_per_s: float) -> GratingSignal:
    """A true badge on one steady sweep."""
    law = rad_per_s * (TIMES - TIMES.mean())
    return fringe_signal(law, law + lasting_noise(240))


def shares(outcome: Invariant) -> dict[str, float | None]:
    return {one.name: one.share for one in outcome.explanations}


def judged(film: GratingSignal, sheet: SheetGain = KNOWN, constant: float | None = CONSTANT_RAD) -> Invariant:
    return judge([film], sheet, constant_room_rad=constant)


def undecided(outcome: Invariant) -> list[str]:
    return [reason.code for reason in outcome.reasons if reason.level not in ("pass", "note")]


def test_a_known_gain_narrows_the_share_of_drifts():
    """Catches: the room of any sheet for a badge whose own was measured.  Closed form: the room over all gains."""
    width = FORGED_GAINS[1] - FORGED_GAINS[0]
    wide, narrow = (shares(judged(sweep(0.6), sheet, None))["drift"] for sheet in (UNKNOWN, KNOWN))
    assert wide == pytest.approx(0.3 / width, abs=0.04)
    assert narrow == pytest.approx(2 * BUILT_GAIN_ROOM_SHARE / width, abs=0.0075)


def test_a_steady_sweep_is_inconclusive_however_much_is_known():
    """Catches: a film accepted on which a drift at the best-fitting speed fits as well as the law, as few drifts have
    that speed: such a film is one of a drift."""
    for sheet, constant in ((UNKNOWN, None), (KNOWN, None), (UNKNOWN, CONSTANT_RAD), (KNOWN, CONSTANT_RAD)):
        outcome = judged(sweep(0.9), sheet, constant)
        assert outcome.verdict == "inconclusive" and undecided(outcome) == ["drift"]


def test_what_is_known_as_built_excuses_nothing_else():
    """Catches: other findings let through; a forged sweep that is accepted, as its badge is known."""
    strayed = judged(replace(sweep(0.9), stray_share=0.2))
    assert strayed.verdict == "inconclusive" and undecided(strayed) == ["pose_outliers", "drift"]
    slow = sweep(0.9)
    assert judged(replace(slow, measured_rad=0.5 * slow.measured_rad)).verdict == "reject"
    late = 0.9 * trajectory(frames=240, late_s=0.4)
    assert judged(fringe_signal(0.9 * trajectory(frames=240), late + lasting_noise(240))).verdict == "reject"
