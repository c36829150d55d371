"""Rows of the table on photographs.  At each test: the wrong implementation it catches."""

from __future__ import annotations

from dataclasses import replace

from kit.photographed import LAW, TYPICAL, depth_of, faded, laid_over, noise_of, signal
from moireid.asbuilt import AsBuilt, as_built_from_json, merge
from moireid.designer import Order, design_badge
from moireid.verifier.decision.comparison import Explanation
from moireid.verifier.decision.judge import photographs
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed, to_measure
from moireid.verifier.explanations.photographs.fringe_spacing import spacing_of
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MIN_OVERTONE_CONTRASTS


def rows_of(film: GratingSignal) -> dict[str, Explanation]:
    """The rows, by name; each must say the same as its finding."""
    rows, reasons = photographs(spacing_of([film]), [film])
    remains = [reason.level == "undecided" for reason in reasons]
    assert [row.fits for row in rows] == remains[-len(rows) :]
    return {row.name.removeprefix("photographs_"): row for row in rows}


def test_a_badge_has_odds_over_all_kinds_of_photographs() -> None:
    """Catches: the sign of the odds turned around; odds without bound from error bars that are too small."""
    found = rows_of(signal(TYPICAL + noise_of(0.003, 4), depth=depth_of(1.0, change_rad=0.02)))
    assert set(found) == {"at_one_distance", "in_turn", "laid_over"}
    assert not any(row.fits for row in found.values())
    assert all(row.log10_odds is not None and 0 < row.log10_odds < 100 for row in found.values())


def test_photographs_have_odds_over_a_badge() -> None:
    """Catches: rows of a fixed table; odds of one kind given for another."""
    noise = noise_of(0.002, 4)
    short = 0.2 * LAW
    in_turn = rows_of(signal(faded(3, short) + noise, law=short))["in_turn"]
    assert in_turn.fits and in_turn.better and in_turn.parameters["photographs"] in (2, 3, 4)
    over = rows_of(signal(laid_over(6, 1.0, LAW) + noise))
    assert over["laid_over"].fits and over["laid_over"].better
    flat = rows_of(signal(depth=depth_of(0.0, change_rad=0.02)))["at_one_distance"]
    assert flat.fits and flat.better


def test_a_soft_sheet_is_enrolled_and_then_owes_a_third_of_what_it_showed() -> None:
    """Catches: sheets for flip pictures that no capture takes; an enrolment that superposed photographs pass."""
    built = AsBuilt("0f", -0.05, 1e-5, 0.0, 0.01, 0.0, 1e-4, 1.0, 0.007, third_harmonic=0.024)
    badge = design_badge(Order("Bench", lens="50lpi"), bytes.fromhex("0f5ac3962d784be1"))
    soft, photographed = (signal(size + noise_of(0.001, 4)) for size in (0.024 * TYPICAL / abs(TYPICAL), 0.002))

    def passes(film: GratingSignal, sheet: SheetGain) -> bool:
        found = {reason.code: reason.level for reason in photographs(spacing_of([film]), [film], sheet)[1]}
        return found["third_harmonic"] == "pass"

    assert not passes(soft, designed(badge)) and not passes(soft, as_built(badge, replace(built, third_harmonic=None)))
    assert passes(soft, to_measure()) and passes(soft, as_built(badge, built))
    for sheet in (to_measure(), as_built(badge, built), as_built(badge, replace(built, third_harmonic=1e-4))):
        assert not passes(photographed, sheet)
    # A sharp sheet is asked for no more than one as designed.
    assert as_built(badge, replace(built, third_harmonic=0.3)).least_overtone == MIN_OVERTONE_CONTRASTS
    merged = merge([built, replace(built, third_harmonic=0.02), replace(built, third_harmonic=None)])
    assert merged.third_harmonic == 0.02 and as_built_from_json(merged.to_json()).third_harmonic == 0.02
