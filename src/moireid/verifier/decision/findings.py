"""Findings of the motion test, as sentences with measured value, limit and unit.

Evidence comes first (is there enough to judge?), then the law, then one finding for each rival that remains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from moireid.verifier import limits
from moireid.verifier.decision.comparison import (
    CONTAINING,
    PARTS,
    Explanation,
    GratingComparison,
    cause_of,
    enough_motion_rad,
    simplest,
)
from moireid.verifier.decision.figures import Figures
from moireid.verifier.explanations.strength import one_in
from moireid.verifier.explanations.words import WORDS, does
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.identity.cell_slip import RowsApart
from moireid.verifier.reasons import Level, Reason

#: Parts that move apart reject no film of which another motion leaves at most this share of the law's.
OTHER_MOTION_SHARE = 0.35


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
    if share < 0.005 and held < limits.MIN_HELD_SHARE:
        return []
    if share < 0.005:
        text = f"Something covers an edge of the badge (a hand, a caption, glare) in {100 * held:.0f} % of the frames."
        return [Reason("covered", "note", held, None, "share", text)]
    level: Level = "note" if share <= limits.MAX_COVERED_SHARE else "undecided"
    text = f"Something covers the badge (a hand, a caption, glare): {100 * share:.0f} % of its rows are not judged"
    text += (
        "." if level == "note" else f"; at most {100 * limits.MAX_COVERED_SHARE:.0f} % are allowed. Film it uncovered."
    )
    return [Reason("covered", level, share, limits.MAX_COVERED_SHARE, "share", text)]


def law_fits(compared: Sequence[GratingComparison]) -> list[Reason]:
    """Whether the law explains the phase in absolute terms, of the grating that it explains worst."""
    moved = [one for one in compared if one.moved]
    worst = max(moved, key=lambda one: one.residual_rad / one.limit_rad)
    rested = [_at_rest(one, moved) for one in compared if not one.moved and one.figures.information > 0]
    level: Level = "pass" if worst.fits else "undecided"
    text = "The law of optics explains the fringes, but for errors that every film has."
    if not worst.fits:
        text = "The fringes leave the law, and it is not clear whether errors of the film explain that. "
        text += "Film again from nearer, or with more motion."
    if not worst.possible and worst.beaten:
        level, text = "fail", "The fringes leave the law, further than any error of a film explains."
    found = Reason("residual", level, worst.residual_rad, worst.limit_rad, "rad", text)
    order: dict[Level, int] = {"note": 0, "pass": 0, "undecided": 1, "fail": 2}
    return [max([found, *rested], key=lambda reason: order[reason.level])]


def _at_rest(grating: GratingComparison, moved: Sequence[GratingComparison]) -> Reason:
    """A grating that should hardly move by the law must hardly move.

    Its gain means nothing, so the measured phase is compared with the prediction itself, or with that times the gain of
    the gratings that moved.  The tolerance of the gain is allowed, and a share of the largest motion of any grating, as
    the camera's pose may turn the badge.
    """
    own, most = grating.figures, max(one.figures.excitation_rad for one in moved)
    if own.excitation_rad >= limits.MIN_EXCITATION_RAD:
        text = "One field of the badge moved, but its fringes are too unclear to say how. Film from nearer."
        limit = enough_motion_rad(own.expected_error_rad)
        return Reason("residual", "undecided", own.excitation_rad, limit, "rad", text)
    same = max(moved, key=lambda one: one.figures.information).figures.gain_ratio
    nearest = float(np.clip(own.gain_ratio, min(1.0, same), max(1.0, same)))
    deviation = float(np.hypot((own.gain_ratio - nearest) * own.excitation_rad, own.phase_residual_rad))
    fixed = limits.RESIDUAL_FLOOR_RAD * limits.POSSIBLE_RESIDUAL_RATIO + 0.03 * most
    fixed += (limits.GAIN_TOLERANCE_SHARE + limits.GAIN_REJECTED_SDS * own.tangent_sd) * own.excitation_rad
    limit = float(np.hypot(fixed, limits.EXPLAINED_SDS * min(own.expected_error_rad, limits.MAX_STRIP_WANDER_RAD)))
    good, possible = deviation <= limit, deviation <= limits.POSSIBLE_RESIDUAL_RATIO * limit
    text = "Fringes that should hardly move do so."
    if not good:
        text = "Fringes that should hardly move by the law do move, as if they were those of another grating."
    return Reason("residual", "pass" if good else "undecided" if possible else "fail", deviation, limit, "rad", text)


def rows_agree(compared: Sequence[GratingComparison], code_apart: RowsApart) -> Reason:
    """Whether the rows of the badge move together: the plain ones, and those of the code with them.

    Notes
    -----
    Convention: a film whose code's rows move apart is not accepted, whatever the cause.  It is rejected only if two
        halves of a row share that motion: small cells far away are noisy, and noise is no motion.
    """
    worst = max((one.figures for one in compared), key=lambda one: one.strip_wander_rad)
    limit = float(np.hypot(limits.MAX_STRIP_WANDER_RAD, 3 * worst.expected_error_rad))
    if worst.strip_wander_rad > limit:
        text = "The fringes of different rows of the badge move apart, as on a badge put together from pictures."
        return Reason("agreement", "fail", worst.strip_wander_rad, limit, "rad", text)
    excitation = max(one.figures.excitation_rad for one in compared)
    rooms = [floor + share * excitation for floor, share in limits.MAX_CODE_WANDER]
    figures = zip((code_apart.film, code_apart.second), rooms, strict=True)
    apart, limit = max(figures, key=lambda one: one[0] / one[1])
    broken = apart > limits.POSSIBLE_RESIDUAL_RATIO * limit and code_apart.coherent > rooms[0]
    level: Level = "pass" if apart <= limit else "fail" if broken else "undecided"
    text = "The fringes of all rows of the badge move together."
    if level == "fail":
        text = "The fringes of the code's rows do not move as those of the plain rows do."
    elif level != "pass":
        text = "Whether the fringes of the code's rows move as those of the plain rows do cannot be seen well enough. "
        text += "Film from nearer, in even light, without effects that mix frames."
    return Reason("agreement", level, apart, limit, "rad", text)


def with_nuisances(
    reasons: list[Reason], signals: Sequence[GratingSignal], compared: Sequence[GratingComparison]
) -> list[Reason]:
    """The findings on gain, law and rows, with the honest cause where one may have made them: camera, mixed frames, a
    tiny badge, a hand.

    A cause lets nothing pass: it keeps what it can do from being a failure, as forgers can make it, too.
    """
    gain, laws, rows = reasons
    troubled = any(reason.level in ("fail", "undecided") for reason in (gain, laws))
    if not troubled and rows.level == "pass":
        return reasons
    moved = [(s, one) for s, one in zip(signals, compared, strict=True) if one.moved]
    if any(signal.covered_share >= 0.005 for signal in signals):
        laws, rows = softened(laws), softened(rows)
    small = _small(moved)
    if any(one.doubted for _, one in moved) and troubled:
        if all(one.reach[0] < one.figures.gain_ratio < one.reach[1] for _, one in moved):
            gain = softened(gain)
        return [gain, laws, rows, _camera([signal for signal, _ in moved])]
    if small is not None and troubled:
        # Errors of poses lower a gain by their power over that of the motion; they take none away.
        room = (
            limits.GAIN_TOLERANCE_SHARE + (limits.SMALL_MARKER_DOUBT_RATIO / limits.MIN_EXCITATION_TO_ERROR_RATIO) ** 2
        )
        if any(abs(one.figures.gain_ratio - 1) > room for _, one in moved):
            return [gain, laws, rows]
        return [softened(gain), softened(laws), rows, small]
    return [gain, laws, rows]


def of_any_build(reasons: list[Reason], steep_share: float, *, page_off: bool) -> list[Reason]:
    """The findings without failures, where page or sheet is off, or air beneath it may hide parts of its lenses.

    Parameters: steep_share: of frames from aside, 0 where those from the front fail by themselves; page_off: as
        `Identity.page_off`, which has a finding of its own.
    """
    steep = steep_share > limits.MAX_STEEP_SHARE and any(reason.level == "fail" for reason in reasons)
    if not steep and not page_off:
        return reasons
    text = (
        f"In {100 * steep_share:.0f} % of the frames the badge is seen from so far aside that a little air beneath its "
        "sheet hides a part of each lens, so its fringes prove nothing against it. Film it from the front."
    )
    aside = Reason("steep", "undecided", steep_share, limits.MAX_STEEP_SHARE, "share", text)
    return [softened(reason) for reason in reasons] + ([aside] if steep else [])


def softened(reason: Reason) -> Reason:
    """A failure as undecided, where something else than a forgery may have made it."""
    return replace(reason, level="undecided") if reason.level == "fail" else reason


def _small(moved: Sequence[tuple[GratingSignal, GratingComparison]]) -> Reason | None:
    """The finding that markers are so small that the motion might not be enough."""
    for signal, one in moved:
        needed = limits.SMALL_MARKER_DOUBT_RATIO * enough_motion_rad(one.figures.expected_error_rad)
        if signal.doubt > 1 and one.figures.excitation_rad < needed:
            text = (
                "The badge is so small in the picture that how it turned is uncertain, and the fringes prove nothing "
                "against it. Film from nearer, or move more."
            )
            return Reason("small", "undecided", one.figures.excitation_rad, needed, "rad", text)
    return None


def _camera(signals: Sequence[GratingSignal]) -> Reason:
    mixed, lasting = max(s.mixed_share for s in signals), max(s.lasting_px for s in signals)
    if mixed > limits.MAX_MIXED_SHARE:
        text = (
            "The fringes fade where they move, as in frames that are mixed with their neighbours by noise reduction or "
            "a changed frame rate. Film again with such functions off, or from nearer."
        )
        return Reason("mixed_frames", "undecided", mixed, limits.MAX_MIXED_SHARE, "share", text)
    text = (
        "No single camera explains how the badge appears in the picture, so it may have been zoomed, reframed or "
        "stabilised. Give the film as the camera took it, or film again with such functions off."
    )
    return Reason("camera", "undecided", lasting, limits.MAX_LASTING_PX, "px", text)


def rivals(
    table: Sequence[Explanation], excitation_rad: float, *, law_fits: bool, allowed_share: float
) -> list[Reason]:
    """One finding for each rival that remains; where none does, one that says by how much the law is ahead.

    Where the law does not explain the film, only what the fringes do instead is named.
    """
    if not law_fits:
        cause, better = cause_of(table), [one for one in table if one.better]
        most = OTHER_MOTION_SHARE * excitation_rad
        other = [
            one for one in better if one.name not in CONTAINING and one.parameters.get("residual_rad", 0.0) <= most
        ]
        may_fail = not other and cause is simplest(better)
        return [] if cause is None else [_remains(cause, allowed_share, may_fail=may_fail)]
    remaining = [one for one in table if one.fits]
    if remaining:
        return [_remains(one, allowed_share, may_fail=True) for one in remaining]
    known = [one for one in table if one.log10_odds is not None and one.share is not None]
    if not known:
        return [Reason("explanations", "pass", None, None, "log10", "No other explanation fits as well as the law.")]
    best = min(known, key=lambda one: one.log10_odds or 0.0)
    odds = float(best.log10_odds or 0.0)
    text = f"The law explains this film better than fringes that {WORDS[best.name].does}, the best of {len(table)} "
    text += f"rivals: by a factor of 10^{odds:.0f}." if odds >= 1 else "rivals."
    return [Reason("explanations", "pass", odds, -limits.MAX_RIVAL_LOG10, "log10", text)]


def _remains(one: Explanation, allowed_share: float, *, may_fail: bool) -> Reason:
    """The finding on one rival; may_fail: whether parts that move apart for sure reject the film."""
    words = WORDS[one.name]
    remedy = f"To exclude that, {words.remedy}."
    if one.better:
        odds = float(one.log10_odds or 0.0)
        text = f"Fringes that {does(one.name, one.parameters)} explain this film 10^{-odds:.0f} times better than the "
        text += f"law does. {remedy}"
        level: Level = "fail" if may_fail and one.name in PARTS and one.beats else "undecided"
        return Reason(one.name, level, odds, -limits.MAX_RIVAL_LOG10, "log10", text)
    if one.share_at_most is None or one.share_at_most <= allowed_share:
        text = f"Fringes that {does(one.name, one.parameters)} explain this film as well as the law does. {remedy}"
        return Reason(one.name, "undecided", one.log10_odds, limits.MAX_RIVAL_LOG10, "log10", text)
    often = one_in(one.share_at_most)
    text = f"On this motion, as many as 1 in {often} films whose fringes {words.does} would look as this one does. "
    text += remedy
    return Reason(one.name, "undecided", one.share_at_most, allowed_share, "share", text)
