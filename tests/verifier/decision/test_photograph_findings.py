"""Findings on photographs.  At each test: the wrong implementation it catches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kit.photographed import LAW, TYPICAL, noise_of, signal
from moireid.asbuilt import AsBuilt, as_built_from_json, merge
from moireid.designer import Order, design_badge
from moireid.verifier.decision.photographs import photographs, softest
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed, to_measure
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MIN_OVERTONE_CONTRASTS


def test_what_cannot_be_told_has_no_finding() -> None:
    """Catches: a film without harmonics counted against photographs."""
    for film in (replace(signal(), beyond=None), replace(signal(), phase_sd_rad=np.full(len(LAW), np.inf))):
        assert photographs(None, [film], softest([film])) == []


def test_a_soft_sheet_is_enrolled_and_then_owes_a_third_of_what_it_showed() -> None:
    """Catches: sheets for flip pictures that no capture takes; an enrolment that superposed photographs pass."""
    built = AsBuilt("0f", -0.05, 1e-5, 0.0, 0.01, 0.0, 1e-4, 1.0, 0.007, third_harmonic=0.024)
    badge = design_badge(Order("Bench", lens="50lpi"), bytes.fromhex("0f5ac3962d784be1"))
    soft, photographed = (signal(size + noise_of(0.001, 4)) for size in (0.024 * TYPICAL / abs(TYPICAL), 0.002))

    def passes(film: GratingSignal, sheet: SheetGain) -> bool:
        found = {reason.code: reason.level for reason in photographs(None, [film], softest([film], sheet))}
        return found["third_harmonic"] == "pass"

    assert not passes(soft, designed(badge)) and not passes(soft, as_built(badge, replace(built, third_harmonic=None)))
    assert passes(soft, to_measure()) and passes(soft, as_built(badge, built))
    for sheet in (to_measure(), as_built(badge, built), as_built(badge, replace(built, third_harmonic=1e-4))):
        assert not passes(photographed, sheet)
    # A sharp sheet is asked for no more than one as designed.
    assert as_built(badge, replace(built, third_harmonic=0.3)).least_overtone == MIN_OVERTONE_CONTRASTS
    merged = merge([built, replace(built, third_harmonic=0.02), replace(built, third_harmonic=None)])
    assert merged.third_harmonic == 0.02 and as_built_from_json(merged.to_json()).third_harmonic == 0.02
