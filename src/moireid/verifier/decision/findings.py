"""Findings of the motion test, as sentences with measured value, limit and unit.

Evidence comes first (is there enough to judge?), then the law, then one finding for each rival that remains.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from moireid.verifier import limits
from moireid.verifier.decision.comparison import GratingComparison, enough_motion_rad
from moireid.verifier.decision.figures import Figures
from moireid.verifier.decision.sheet_gain import SheetGain, gain_reason, lens_reason
from moireid.verifier.explanations.residuals import credible_error_rad, residual_limit_rad
from moireid.verifier.explanations.strength import one_in
from moireid.verifier.explanations.table import LAW_PLUS, Explanation, cause_of
from moireid.verifier.explanations.words import WORDS, does
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.reasons import Level, Reason


def no_fringes() -> Reason:
    """The finding that nothing can be read."""
    return Reason("fringes", "undecided", 0.0, None, "", "No fringes could be read on the badge.")


def evidence(signals: Sequence[GratingSignal], mean: Figures, *, enough: bool) -> list[Reason]:
    """Is there enough to judge?

    Parameters: mean: figures of all gratings; enough: whether one of them moved enough.
    """
    reasons = [_motion(mean, enough=enough)]
    if not enough:
        reasons += _motion_gaps(signals, reasons[0])
    reasons += _pose_outliers(max(signal.stray_share for signal in signals))
    reasons += _covered(*(max(getattr(one, name) for one in signals) for name in ("covered_share", "held_share")))
    if any(signal.focal_at_limit for signal in signals):
        text = (
            "No camera's focal length fits this film: its picture looks stretched, or cut out of a larger one. Give "
            "the film as it was taken, or the focal length of its camera."
        )
        reasons.append(Reason("focal", "undecided", None, None, "", text))
    return reasons


def _motion(mean: Figures, *, enough: bool) -> Reason:
    limit = enough_motion_rad(mean.expected_error_rad)
    if enough:
        text = "The badge moved enough: its fringes had to move far."
        return Reason("motion", "pass", mean.excitation_rad, limit, "rad", text)
    text = (
        "The badge hardly moved, so its fringes had no way to show what they do. Film again, and move the badge or the "
        "camera sideways by 20 cm or more, several times."
    )
    return Reason("motion", "undecided", mean.excitation_rad, limit, "rad", text)


def _motion_gaps(signals: Sequence[GratingSignal], motion: Reason) -> list[Reason]:
    """Whether the badge moved enough where the film does not show it; nothing where it did not."""
    paths = [s.beyond.law_rad[np.isfinite(s.phase_sd_rad)] for s in signals if s.beyond is not None]
    apart = max((float(path.std()) for path in paths if len(path)), default=0.0)
    if not (isinstance(motion.limit, float) and apart >= motion.limit):
        return []
    text = (
        "The badge moved, but the film is cut, or pictures are missing, where it did, and fringes that are not seen to "
        "move prove nothing. Film again in one piece, or use a faster connection."
    )
    return [Reason("motion_gaps", "undecided", apart, motion.limit, "rad", text)]


def _pose_outliers(share: float) -> list[Reason]:
    """Whether few enough poses were left out as outliers; nothing where none was."""
    if share == 0:
        return []
    level: Level = "note" if share <= limits.MAX_STRAY_SHARE else "undecided"
    text = f"In {100 * share:.0f} % of the frames the markers are not where a flat page has them; these are not judged"
    text += "." if level == "note" else f", and at most {100 * limits.MAX_STRAY_SHARE:.0f} % may be so."
    return [Reason("pose_outliers", level, share, limits.MAX_STRAY_SHARE, "share", text)]


def _covered(share: float, held: float) -> list[Reason]:
    """Whether enough of the rows and markers can be seen; nothing where all of them can.

    Parameters: held: share of frames in which something covers a marker.
    """
    if share < limits.MIN_ROWS_COVERED and held < limits.MIN_HELD_SHARE:
        return []
    if share < limits.MIN_ROWS_COVERED:
        text = f"Something covers an edge of the badge (a hand, a caption, glare) in {100 * held:.0f} % of the frames."
        return [Reason("covered", "note", held, None, "share", text)]
    level: Level = "note" if share <= limits.MAX_COVERED_SHARE else "undecided"
    text = f"Something covers the badge (a hand, a caption, glare): {100 * share:.0f} % of its rows are not judged"
    text += (
        "." if level == "note" else f"; at most {100 * limits.MAX_COVERED_SHARE:.0f} % are allowed. Film it uncovered."
    )
    return [Reason("covered", level, share, limits.MAX_COVERED_SHARE, "share", text)]


def gain(moving: Sequence[tuple[GratingSignal, GratingComparison]], sheet: SheetGain, *, prove: bool) -> list[Reason]:
    """Whether the gain that differs most from the expected one is one of this badge's sheet; and where another lens
    would explain it, that finding.

    Parameters: moving: gratings that moved enough; prove: as `residual`.
    """
    wrong = max((law.figures for _, law in moving), key=lambda one: abs(one.gain_ratio - 1))
    lens_room = min(s.lens_room[0] for s, _ in moving), max(s.lens_room[1] for s, _ in moving)
    possible = sheet.possible(lens_room)
    if any(law.doubted for _, law in moving):
        low, high = max(law.reach[0] for _, law in moving), min(law.reach[1] for _, law in moving)
        possible = min(low, possible[0]), max(high, possible[1])
    if not prove:
        possible = (-math.inf, math.inf)
    either_way = any(signal.parallel for signal, _ in moving)
    found = gain_reason(wrong.gain_ratio, wrong.gain_sd, sheet, possible, wrong.air_sd, either_way=either_way)
    lens = lens_reason(wrong.gain_ratio, wrong.gain_sd, sheet, lens_room) if found.level == "undecided" else None
    return [found] if lens is None else [found, lens]


def residual(compared: Sequence[GratingComparison], *, prove: bool) -> Reason:
    """Whether the law explains the phase in absolute terms, of the grating that it explains worst.

    Parameters: prove: whether a forgery may be proven (`Doubts`); else a true badge's film may leave the law so far.
    """
    moved = [one for one in compared if one.moved]
    worst = max(moved, key=lambda one: one.deviation_rad / one.limit_rad)
    rested = [_at_rest(one, moved, prove=prove) for one in compared if not one.moved and one.figures.information > 0]
    level: Level = "pass" if worst.fits else "undecided"
    more = "" if all(one.usual for one in moved) else "their gain and "
    text = f"The law of optics explains the fringes, but for {more}errors that every film has."
    if not worst.fits:
        text = "The fringes leave the law, and it is not clear whether errors of the film explain that. "
        text += "Film again from nearer, or with more motion."
    if prove and not worst.possible:
        level, text = "fail", "The fringes leave the law, further than any error of a film explains."
    limit = worst.possible_rad if level == "fail" else worst.limit_rad
    found = Reason("residual", level, worst.deviation_rad, limit, "rad", text)
    order: dict[Level, int] = {"note": 0, "pass": 0, "undecided": 1, "fail": 2}
    return max([found, *rested], key=lambda reason: order[reason.level])


def _at_rest(grating: GratingComparison, moved: Sequence[GratingComparison], *, prove: bool) -> Reason:
    """A grating that should hardly move by the law must hardly move.

    Its gain means nothing, so the measured phase is compared with the prediction itself, or with that times the gain of
    the gratings that moved.  The tolerance of the gain is allowed.
    """
    own, most = grating.figures, max(one.figures.excitation_rad for one in moved)
    if own.excitation_rad >= limits.MIN_EXCITATION_RAD:
        text = "One field of the badge moved, but its fringes are too unclear to say how. Film from nearer."
        limit = enough_motion_rad(own.expected_error_rad)
        return Reason("residual", "undecided", own.excitation_rad, limit, "rad", text)
    same = max(moved, key=lambda one: one.figures.information).figures.gain_ratio
    nearest = float(np.clip(own.gain_ratio, min(1.0, same), max(1.0, same)))
    deviation = float(np.hypot((own.gain_ratio - nearest) * own.excitation_rad, own.phase_residual_rad))
    room = (limits.GAIN_TOLERANCE_SHARE + limits.GAIN_REJECTED_SDS * own.tangent_sd) * own.excitation_rad
    error = credible_error_rad(min(most, limits.RESTING_MOTION_RAD), own.expected_error_rad)
    limit, proof = (room + residual_limit_rad(error, sds) for sds in (limits.USUAL_SDS, limits.PROOF_SDS))
    good, possible = deviation <= limit, not prove or deviation <= proof
    text = "Fringes that should hardly move do so."
    if not good:
        text = "Fringes that should hardly move by the law do move, as if they were those of another grating."
    if not possible:
        return Reason("residual", "fail", deviation, proof, "rad", text)
    return Reason("residual", "pass" if good else "undecided", deviation, limit, "rad", text)


def rivals(
    table: Sequence[Explanation], moving: Sequence[tuple[GratingSignal, GratingComparison]], gain: Reason
) -> list[Reason]:
    """One finding for each rival that remains; where none does, one that says by how much the law is ahead.

    Where the law does not explain the film, only what the fringes do instead is named; where only the gain is unusual,
    its own finding says so, and only rivals that are the law plus something are asked for.

    Parameters: moving: gratings that moved enough; gain: its finding.
    """
    laws = [law for _, law in moving]
    allowed_share = laws[0].allowed_share
    if not all(law.fits for law in laws):
        cause = cause_of(table)
        return [] if cause is None else [_remains(cause, allowed_share)]
    if gain.level != "pass" and not all(law.usual for law in laws):
        return [_remains(one, allowed_share) for one in table if one.name in LAW_PLUS and one.better_than_law]
    remaining = [one for one in table if one.fits]
    if remaining:
        return [_remains(one, allowed_share) for one in remaining]
    known = [one for one in table if one.log10_odds is not None and one.share is not None and one.name not in LAW_PLUS]
    if not known:
        return [Reason("explanations", "pass", None, None, "log10", "No other explanation fits as well as the law.")]
    best = min(known, key=lambda one: one.log10_odds or 0.0)
    odds = float(best.log10_odds or 0.0)
    text = f"The law explains this film better than fringes that {WORDS[best.name].does}, the closest "
    text += "rival without the law in it" + (f": by a factor of 10^{odds:.0f}." if odds >= 1 else ".")
    return [Reason("explanations", "pass", odds, -limits.MAX_RIVAL_LOG10, "log10", text)]


def _remains(one: Explanation, allowed_share: float) -> Reason:
    """The finding on one rival that remains."""
    words = WORDS[one.name]
    remedy = f"To exclude that, {words.remedy}."
    if one.better_than_law:
        odds = float(one.log10_odds or 0.0)
        text = f"Fringes that {does(one.name, one.parameters)} explain this film 10^{-odds:.0f} times better than the "
        text += f"law does. {remedy}"
        return Reason(one.name, "undecided", odds, -limits.MAX_RIVAL_LOG10, "log10", text)
    if one.share_at_most is None or one.share_at_most <= allowed_share:
        text = f"Fringes that {does(one.name, one.parameters)} explain this film as well as the law does. {remedy}"
        return Reason(one.name, "undecided", one.log10_odds, limits.MAX_RIVAL_LOG10, "log10", text)
    often = one_in(one.share_at_most)
    text = f"On this motion, as many as 1 in {often} films whose fringes {words.does} would look as this one does. "
    text += remedy
    return Reason(one.name, "undecided", one.share_at_most, allowed_share, "share", text)
