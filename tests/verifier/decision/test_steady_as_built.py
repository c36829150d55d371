"""A steady sweep of a badge that is known as built.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.fringe_signals import clock, fringe_signal, lasting_noise, trajectory
from moireid.asbuilt import AsBuilt
from moireid.designer import Request, design_badge
from moireid.verifier.decision.judge import Invariant, judge_signals
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import BUILT_GAIN_ROOM_SHARE, FORGED_GAINS, MAX_RIVAL_SHARE

BADGE = design_badge(Request("Bench", lens="75lpi"), bytes.fromhex("0f5ac3962d784be1"))
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
    return judge_signals([film], sheet, constant_room_rad=constant)


def undecided(outcome: Invariant) -> list[str]:
    return [reason.code for reason in outcome.reasons if reason.level not in ("pass", "note")]


def test_a_known_gain_narrows_the_share_of_drifts():
    """Catches: the room of any sheet for a badge whose own was measured.  Closed form: the room over all gains."""
    width = FORGED_GAINS[1] - FORGED_GAINS[0]
    wide, narrow = (shares(judged(sweep(0.6), sheet, None))["drift"] for sheet in (UNKNOWN, KNOWN))
    assert wide == pytest.approx(0.3 / width, abs=0.0075)
    assert narrow == pytest.approx(2 * BUILT_GAIN_ROOM_SHARE / width, abs=0.0075)


def test_a_known_constant_lowers_a_drift_by_chance():
    """Catches: a constant that counts for nothing, or a room counted on one side of two.  Closed form."""
    free, known = (shares(judged(sweep(0.6), UNKNOWN, constant))["drift"] for constant in (None, CONSTANT_RAD))
    assert free is not None and known == pytest.approx(free * CONSTANT_RAD / math.pi)


@pytest.mark.parametrize("rad_per_s", [0.6, 0.3, 0.15])
def test_a_delay_shows_in_the_constant_where_the_sweep_is_fast(rad_per_s):
    """Catches: a delay's shift that is centred away; a slow sweep, on which a delay hardly shifts, taken for proof.
    Closed form: delays up to the room over the speed, of those from 0.2 to 2 s.
    """
    found = shares(judged(sweep(rad_per_s), UNKNOWN))["late"]
    wanted = min(max((CONSTANT_RAD / rad_per_s - 0.2) / 1.8, 0.0), 1.0)
    assert found == pytest.approx(wanted, abs=0.02)
    assert shares(judged(sweep(rad_per_s), UNKNOWN, None))["late"] > 0.95


def test_the_badge_as_built_decides_a_fast_sweep():
    """Catches: a film accepted without what is known; one that stays inconclusive for all that is known."""
    assert undecided(judged(sweep(0.9), UNKNOWN, None)) == ["drift", "late"]
    assert undecided(judged(sweep(0.9), KNOWN, None)) == ["late"]
    assert undecided(judged(sweep(0.9), UNKNOWN)) == []
    outcome = judged(sweep(0.9))
    assert outcome.verdict == "accept" and outcome.law_fits
    assert max(share for share in shares(outcome).values() if share is not None) <= MAX_RIVAL_SHARE


def test_a_slow_sweep_stays_inconclusive():
    """Catches: a constant that excludes delays which hardly move it."""
    outcome = judged(sweep(0.15))
    assert outcome.verdict == "inconclusive" and undecided(outcome) == ["late"]


def test_what_is_known_as_built_excuses_nothing_else():
    """Catches: other findings let through; a forged sweep that is accepted, as its badge is known."""
    strayed = judged(replace(sweep(0.9), stray_share=0.2))
    assert strayed.verdict == "inconclusive" and undecided(strayed) == ["pose_outliers"]
    slow = sweep(0.9)
    assert judged(replace(slow, measured_rad=0.5 * slow.measured_rad)).verdict == "reject"
    late = 0.9 * trajectory(frames=240, late_s=0.4)
    assert judged(fringe_signal(0.9 * trajectory(frames=240), late + lasting_noise(240))).verdict == "reject"


def test_varied_motion_needs_nothing_known():
    """Catches: a badge that must be enrolled as built to be accepted."""
    law = 0.9 * trajectory(frames=240)
    film = fringe_signal(law, law + lasting_noise(240))
    for sheet in (UNKNOWN, KNOWN):
        for constant in (None, CONSTANT_RAD, np.inf):
            assert judged(film, sheet, constant).verdict == "accept"
