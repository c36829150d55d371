"""The motion invariant: does the fringe phase follow the camera as the optics say?

Correlation alone does not test how *much* the fringes move.  So four things must hold together: enough motion,
correlation, gain, and a residual that known errors explain.  Each limit has its reason (`limits`); none was fitted to
this project's own simulator.  The limits are wide, as every genuine film must pass them.  Within them a likelihood
ratio weighs all figures together.

A gain that is not the expected one may come from another sheet (`sheet_gain`).  Such a film is judged under its own
gain, and must hold in all else; it is then open, or measured where a badge is being enrolled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.fringes.signals import GratingSignal, Measurement
from moireid.verifier.limits import (
    ACCEPTED_LOG10,
    EXPLAINED_SDS,
    GAIN_REJECTED_SDS,
    GAIN_TOLERANCE_SHARE,
    MAX_COVERED_SHARE,
    MAX_STRAY_SHARE,
    MAX_STRIP_WANDER_RAD,
    MAX_UNSEEN_CHANCE,
    MAX_UNSEEN_WAY_SHARE,
    MIN_CORRELATION,
    MIN_EXCITATION_RAD,
    MIN_EXCITATION_TO_ERROR_RATIO,
    MIN_HELD_SHARE,
    POSSIBLE_ERROR_RATIO,
    POSSIBLE_RESIDUAL_RATIO,
    REJECTED_LOG10,
    RESIDUAL_FLOOR_RAD,
    RESIDUAL_MOTION_SHARE,
)
from moireid.verifier.motion.excuses import without_camera_s_blame, without_hand_s_blame
from moireid.verifier.motion.figures import Figures, figures_of, pearson
from moireid.verifier.motion.likelihood import KINDS
from moireid.verifier.motion.photographs import no_photographs
from moireid.verifier.motion.sheet_gain import DESIGNED, SheetGain, gain_reason
from moireid.verifier.motion.spacing import spacing_of
from moireid.verifier.motion.steady_course import KnownBuilt, chance_of_delay, chance_of_drift, chance_of_place
from moireid.verifier.reasons import Level, Reason, Verdict, json_number, worst

Array = NDArray[np.float64]
FOCAL_AT_LIMIT = (
    "No camera's focal length fits this film: its picture looks stretched, or cut out of a larger one. Give the film "
    "as it was taken, or the focal length of its camera."
)
#: If there are several findings of one kind, the worst is reported.
ORDER: dict[Level, int] = {"note": 0, "pass": 0, "undecided": 1, "fail": 2}


@dataclass(frozen=True)
class Invariant:
    """Outcome of the motion test; figures are None if nothing could be measured.

    gain_ratio: of measured over predicted phase; gain_expected: by which the prediction was multiplied, as the badge is
    known as built, 1 for one as designed.
    """

    verdict: Verdict
    reasons: tuple[Reason, ...]
    correlation: float | None = None
    window_correlation_mean: float | None = None
    gain_ratio: float | None = None
    gain_sd: float | None = None
    phase_residual_rad: float | None = None
    excitation_rad: float | None = None
    score: float | None = None
    gratings: tuple[dict[str, Any], ...] = ()
    gain_expected: float = 1.0

    def to_json(self) -> dict[str, Any]:
        """As the `invariant` object of `verify --json`."""
        names = (
            "correlation",
            "window_correlation_mean",
            "gain_ratio",
            "gain_sd",
            "gain_expected",
            "phase_residual_rad",
            "excitation_rad",
            "score",
        )
        figures = {name: json_number(getattr(self, name)) for name in names}
        return {"verdict": self.verdict, **figures, "gratings": list(self.gratings)}


def judge_invariant(measurement: Measurement, sheet: SheetGain = DESIGNED) -> Invariant:
    """Compare measured and predicted phase of a whole measurement; conventions and source as `judge_signals`."""
    return judge_signals(measurement.gratings, sheet)


def judge_signals(signals: Sequence[GratingSignal], sheet: SheetGain = DESIGNED) -> Invariant:
    """Compare measured and predicted phase, one signal per grating.

    Parameters: signals: under the gain that `sheet` expects.
    Convention: as `figures`; the score is the decadic logarithm of the likelihood ratio, above 0 where a genuine badge
        is likelier (`likelihood`).
    Source: `figures`; gratings are combined by their Fisher information.
    """
    found = _judged(signals, sheet)
    gain, gain_sd = found.gain_ratio, found.gain_sd
    said = next((reason for reason in found.reasons if reason.code == "gain"), None)
    if gain is None or gain_sd is None or said is None or not isinstance(said.measured, float):
        return found
    other = not sheet.accepts(said.measured / sheet.expected, gain_sd) and sheet.explains(gain, gain_sd)
    if not other and not (sheet.measured and sheet.accepts(gain, gain_sd)):
        return found
    again = _judged([signal.under(gain) for signal in signals], sheet.released(gain))
    if other:
        reasons = [said if reason.code == "gain" else reason for reason in again.reasons]
        if not open_codes(again.reasons) & {"camera", "mixed_frames"}:
            reasons = without_camera_s_blame(reasons, signals, sheet)
        again = replace(again, reasons=tuple(reasons), verdict=worst(reasons), score=found.score)
        if again.verdict == "reject" and found.verdict != "reject":
            return found
    return replace(again, gain_ratio=gain, gain_sd=gain_sd, gain_expected=sheet.expected)


def _judged(signals: Sequence[GratingSignal], sheet: SheetGain) -> Invariant:
    """As `judge_signals`, for the expected gain alone."""
    figures = [figures_of(signal, sheet.prior_sd) for signal in signals]
    information = np.array([f.information for f in figures])
    if not information.sum() > 0:
        nothing = Reason("fringes", "undecided", 0.0, None, "", "No fringes could be read on the badge.")
        return Invariant("inconclusive", (nothing,))
    whole = _mean_figures(figures, information / information.sum())
    # Each grating that moved enough must pass by itself; if none did, the most informative one decides.
    moved = [f for f in figures if _enough_motion(f.excitation_rad, f.expected_error_rad).level == "pass"]
    decisive = min(moved, key=lambda f: f.score) if moved else max(figures, key=lambda f: f.information)
    reasons = [_enough_motion(whole.excitation_rad, whole.expected_error_rad)]
    if reasons[0].level != "pass":
        reasons += _leaps(signals, reasons[0].limit)
    reasons += _explained_frames(max(signal.stray_share for signal in signals))
    reasons += _uncovered(*(max(getattr(one, name) for one in signals) for name in ("covered_share", "held_share")))
    if any(signal.focal_at_limit for signal in signals):
        reasons.append(Reason("focal", "undecided", None, None, "", FOCAL_AT_LIMIT))
    if reasons[0].level == "pass":
        reasons += _held_against_law(whole, figures, moved, decisive, [signal.tangent_sd for signal in signals], sheet)
        reasons = without_hand_s_blame(reasons)
        moving = [signal for signal, f in zip(signals, figures, strict=True) if f in moved]
        passes = partial(_would_pass, sheet=sheet)
        reasons += [*_course_tells(signals, moving, sheet), *no_photographs(signals, moving, passes), *_between(moving)]
    reasons = without_camera_s_blame(reasons, signals, sheet)
    return Invariant(
        worst(reasons),
        tuple(reasons),
        whole.correlation,
        whole.window_correlation_mean,
        whole.gain_ratio,
        whole.gain_sd,
        whole.phase_residual_rad,
        whole.excitation_rad,
        decisive.score,
        tuple(f.to_json() for f in figures),
        sheet.expected,
    )


def _mean_figures(figures: Sequence[Figures], share: Array) -> Figures:
    """Mean figures of all gratings, weighted by their information; scores are not averaged."""
    names = [field.name for field in fields(Figures) if field.name not in ("score", "possible_score", "suspected")]

    def mean(name: str) -> float:
        return float(sum(w * getattr(f, name) for w, f in zip(share, figures, strict=True) if w > 0))

    means: dict[str, Any] = {name: mean(name) for name in names}
    return replace(Figures(), **means)


def _held_against_law(
    whole: Figures,
    figures: Sequence[Figures],
    moved: Sequence[Figures],
    decisive: Figures,
    tangent_sds: Sequence[float],
    sheet: SheetGain,
) -> list[Reason]:
    """The finding for each limit, for a film that moved enough.

    whole: mean figures of all gratings; moved: gratings that moved enough by themselves; decisive: the grating of the
    lowest score; tangent_sds: of each grating, as `GratingSignal.tangent_sd`.
    """
    excitation, expected = whole.excitation_rad, whole.expected_error_rad
    wrong = max(moved, key=lambda f: abs(f.gain_ratio - 1), default=decisive)
    most = max(f.excitation_rad for f in figures)
    rested = [
        _at_rest(f, tangent_sd, most)
        for f, tangent_sd in zip(figures, tangent_sds, strict=True)
        if f.information > 0 and f not in moved
    ]
    residuals = [_residual_explained(whole.wandering_rad, excitation, expected), *rested]
    return [
        _correlated(whole.correlation, excitation, expected),
        gain_reason(wrong.gain_ratio, wrong.gain_sd, sheet),
        max(residuals, key=lambda reason: ORDER[reason.level]),
        _strips_agree(max(f.strip_wander_rad for f in figures), expected),
        _likely_true(decisive),
    ]


def _course_tells(
    signals: Sequence[GratingSignal],
    moved: Sequence[GratingSignal],
    sheet: SheetGain,
    known: KnownBuilt | None = None,
) -> list[Reason]:
    """Whether on this course fringes would show that drift, come late, or go with a place; of the best grating.

    Parameters: moved: those of the signals that moved enough; known: of the badge as built.
    Convention: fringes that merely go with a place keep their spacing, so where the spacing speaks against that, their
        chance is as much smaller.
    """
    spacing = spacing_of(signals)
    flat = 1.0 if spacing is None else spacing.of_pictures
    passes = partial(_would_pass, sheet=sheet)
    chances = []
    for signal in moved:
        chances.append(
            max(
                (chance_of_drift(signal, passes, known, sheet.room), "drift at some constant speed"),
                (chance_of_delay(signal, passes, known), "come late by up to a second"),
                (
                    flat * chance_of_place(signal, passes, known, sheet.room),
                    "move with the badge's place in the picture",
                ),
                key=lambda one: one[0],
            )
        )
    if not chances:
        return []
    chance, what = min(chances, key=lambda one: one[0])
    level: Level = "pass" if chance <= MAX_UNSEEN_CHANCE else "undecided"
    text = f"On this motion, fringes that merely {what} would pass in {100 * chance:.0f} of 100 cases"
    if level == "undecided":
        text += ". Film again, move the badge or the camera to and fro, and turn it a little as well."
    else:
        text += "." if known is None else ", as the badge was measured when it was enrolled."
    return [Reason("steady", level, chance, MAX_UNSEEN_CHANCE, "share", text)]


def steady_as_built(
    invariant: Invariant, signals: Sequence[GratingSignal], known: KnownBuilt | None, sheet: SheetGain = DESIGNED
) -> Invariant:
    """The outcome with what is known of the badge as built, where only a steady course leaves the film open."""
    if known is None or open_codes(invariant.reasons) != {"steady"}:
        return invariant
    moved = [signal for signal in signals if _moved_enough(signal)]
    (again,) = _course_tells(signals, moved, sheet, known)
    reasons = tuple(again if reason.code == "steady" else reason for reason in invariant.reasons)
    return replace(invariant, verdict=worst(list(reasons)), reasons=reasons)


def open_codes(reasons: Sequence[Reason]) -> set[str]:
    """Codes of the findings that keep a film from being accepted."""
    return {reason.code for reason in reasons if reason.level in ("undecided", "fail")}


def _moved_enough(signal: GratingSignal) -> bool:
    figures = figures_of(signal)
    return _enough_motion(figures.excitation_rad, figures.expected_error_rad).level == "pass"


def _explained_frames(share: float) -> list[Reason]:
    """Whether few enough poses were left out as outliers; nothing where none was."""
    if share == 0:
        return []
    level: Level = "note" if share <= MAX_STRAY_SHARE else "undecided"
    text = f"In {100 * share:.0f} % of the frames the markers do not lie as on a flat page, so these are not judged"
    text += "." if level == "note" else f"; at most {100 * MAX_STRAY_SHARE:.0f} % are allowed."
    return [Reason("strays", level, share, MAX_STRAY_SHARE, "share", text)]


def _uncovered(share: float, held: float) -> list[Reason]:
    """Whether enough of the rows is to be seen; nothing where all of them are, and all of what tells the pose.

    Parameters: held: share of frames in which something covers a marker.
    """
    if share < 0.005 and held < MIN_HELD_SHARE:
        return []
    if share < 0.005:
        text = f"Something covers an edge of the badge (a hand, a caption, glare) in {100 * held:.0f} % of the frames."
        return [Reason("covered", "note", held, None, "share", text)]
    level: Level = "note" if share <= MAX_COVERED_SHARE else "undecided"
    text = f"Something covers the badge (a hand, a caption, glare): {100 * share:.0f} % of its rows are not judged"
    text += "." if level == "note" else f"; at most {100 * MAX_COVERED_SHARE:.0f} % are allowed. Film it uncovered."
    return [Reason("covered", level, share, MAX_COVERED_SHARE, "share", text)]


def _would_pass(signal: GratingSignal, sheet: SheetGain) -> bool:
    """Whether a grating's fringes would be taken for a real badge's, its course aside."""
    used = np.isfinite(signal.phase_sd_rad)
    measured, predicted = signal.measured_rad[used], signal.predicted_rad[used]
    stretch = signal.stretch[used]
    # Most delays fail by this alone, and all other figures take a hundred times as long.
    if abs(pearson(within_stretches(measured, stretch), within_stretches(predicted, stretch))) < MIN_CORRELATION:
        return False
    found = figures_of(signal, sheet.prior_sd)
    gain = gain_reason(found.gain_ratio, found.gain_sd, sheet)
    if sheet.measured and gain.level == "pass":
        found = figures_of(signal.under(found.gain_ratio), sheet.prior_sd)
    excitation, expected = found.excitation_rad, found.expected_error_rad
    reasons = [
        _correlated(found.correlation, excitation, expected),
        gain,
        _residual_explained(found.wandering_rad, excitation, expected),
        _likely_true(found),
    ]
    return worst(reasons) == "accept"


def _enough_motion(excitation: float, expected: float) -> Reason:
    limit = max(MIN_EXCITATION_RAD, MIN_EXCITATION_TO_ERROR_RATIO * expected)
    if excitation >= limit:
        text = "The badge moved enough: its fringes had to move far."
        return Reason("motion", "pass", excitation, limit, "rad", text)
    text = (
        "The badge hardly moved, so its fringes had no way to show what they do. Film again, and move the badge or the "
        "camera sideways by 20 cm or more, several times."
    )
    return Reason("motion", "undecided", excitation, limit, "rad", text)


def _leaps(signals: Sequence[GratingSignal], limit: object) -> list[Reason]:
    """Whether the badge moved enough where nobody saw it; nothing where it did not."""
    ways = [s.beyond.law_rad[np.isfinite(s.phase_sd_rad)] for s in signals if s.beyond is not None]
    apart = max((float(way.std()) for way in ways if len(way)), default=0.0)
    if not (isinstance(limit, float) and apart >= limit):
        return []
    text = (
        "The badge moved, but by leaps: the film is cut, or pictures are missing, where it did, and fringes that "
        "nobody saw move prove nothing. Film again in one piece, or use a faster connection."
    )
    return [Reason("leaps", "undecided", apart, limit, "rad", text)]


def _between(moved: Sequence[GratingSignal]) -> list[Reason]:
    """Whether the film shows the fringes between its views; nothing where no grating moved enough."""
    if not moved:
        return []
    share = max(signal.way.unseen_share for signal in moved)
    level: Level = "pass" if share <= MAX_UNSEEN_WAY_SHARE else "undecided"
    text = "The fringes were seen all along their way."
    if level == "undecided":
        text = (
            "The fringes were seen at a few places of their way and not between, as in photographs that are shown in "
            "turn. Film again with more moves, slower ones, or more frames a second."
        )
    return [Reason("views", level, share, MAX_UNSEEN_WAY_SHARE, "share", text)]


def _correlated(correlation: float, excitation: float, expected: float) -> Reason:
    """Fail below what a genuine badge can show even if the poses are worse than estimated."""
    possible = min(MIN_CORRELATION, excitation / math.hypot(excitation, POSSIBLE_ERROR_RATIO * expected))
    level: Level = "pass" if correlation >= MIN_CORRELATION else "fail" if correlation < possible else "undecided"
    text = {
        "pass": "The fringes move when the badge moves, and rest when it rests.",
        "undecided": "The fringes do not clearly move together with the badge. Film from nearer, with more motion.",
        "fail": "The fringes do not move together with the badge.",
    }[level]
    return Reason("correlation", level, correlation, MIN_CORRELATION, "", text)


def _residual_explained(residual: float, excitation: float, expected: float) -> Reason:
    fixed = math.hypot(RESIDUAL_FLOOR_RAD, RESIDUAL_MOTION_SHARE * excitation)
    return _explained("The fringes", residual, fixed, expected)


def _explained(what: str, deviation: float, fixed: float, expected: float) -> Reason:
    """Pass what `fixed` and `EXPLAINED_SDS` times the expected error explain; fail what even worse poses cannot."""
    error = EXPLAINED_SDS * expected
    limit, possible = math.hypot(fixed, error), math.hypot(fixed, POSSIBLE_RESIDUAL_RATIO * error)
    level: Level = "pass" if deviation <= limit else "fail" if deviation > possible else "undecided"
    text = {
        "pass": f"{what} stay where the law puts them, but for errors that every film has.",
        "undecided": f"{what} stray from where the law puts them, and it is not clear whether errors of the film "
        "explain that. Film again from nearer, or with more motion.",
        "fail": f"{what} stray from where the law puts them, further than any error of a film explains.",
    }[level]
    return Reason("residual", level, deviation, limit, "rad", text)


def _at_rest(grating: Figures, tangent_sd: float, most_rad: float) -> Reason:
    """A grating that should hardly move by the law must hardly move; the camera cannot cause more.

    Its gain and correlation mean nothing, so the measured phase is compared with the prediction itself.  The tolerance
    of the gain is allowed, and `RESIDUAL_MOTION_SHARE` of the largest motion of any grating, `most_rad`.
    """
    deviation = math.hypot((grating.gain_ratio - 1) * grating.excitation_rad, grating.phase_residual_rad)
    fixed = math.hypot(
        RESIDUAL_FLOOR_RAD,
        RESIDUAL_MOTION_SHARE * most_rad,
        (GAIN_TOLERANCE_SHARE + GAIN_REJECTED_SDS * tangent_sd) * grating.excitation_rad,
    )
    what = "Fringes that should hardly move"
    return _explained(what, deviation, fixed, grating.expected_error_rad)


def _strips_agree(wander: float, expected: float) -> Reason:
    limit = math.hypot(MAX_STRIP_WANDER_RAD, EXPLAINED_SDS * expected)
    good = wander <= limit
    text = "The fringes of all parts of the badge move together."
    if not good:
        text = (
            "The fringes of different parts of the badge move apart, as on a badge that is put together from pictures."
        )
    return Reason("agreement", "pass" if good else "fail", wander, limit, "rad", text)


def _likely_true(grating: Figures) -> Reason:
    level: Level = (
        "pass"
        if grating.score >= ACCEPTED_LOG10
        else "fail"
        if grating.possible_score <= REJECTED_LOG10
        else "undecided"
    )
    size = 10 ** abs(grating.score)
    times = "over a million times" if size > 1e6 else f"{size:,.0f} times" if size >= 10 else f"{size:.1f} times"
    if grating.score >= 0:
        text = f"All in all, what was measured is {times} more likely on a real badge than on a forged one"
    else:
        kind = KINDS[grating.suspected]
        text = f"All in all, what was measured is {times} more likely on a forged badge ({kind}) than on a real one"
    if level == "undecided":
        text += f"; {10**ACCEPTED_LOG10:.2g} times is needed. Film again with more motion, or from nearer"
    return Reason("likelihood", level, grating.score, ACCEPTED_LOG10, "log10", f"{text}.")
