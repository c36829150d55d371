"""The motion invariant: does the law explain this film, and does any rival explain it as well?

1. Is there enough to judge: fringes, motion, badge uncovered, one camera?
2. The gain: is it one that this badge's sheet may have? (`sheet_gain`)
3. The law: does it explain the phase in absolute terms, nuisances allowed? (`comparison`)
4. Rivals: does any fit better, and would any look as law-like as this film does?
5. Photographs: do the fringes' spacing and shape follow the law, too? (`photographs`)

A film is accepted if all of that holds.  It is rejected if the law does not explain it with every nuisance allowed, and
a rival does far better.  Else it is inconclusive, and the findings name the rival that remains.

Step 5 adds these rows to the table of explanations, and these findings:

| row | the fringes are those of | finding |
|---|---|---|
| `photographs_at_one_distance` | photographs from one distance, moved by the law | `spacing` |
| `photographs_in_turn` | two to four photographs, in turn or cross-faded | `cross_fade` |
| `photographs_laid_over` | photographs, all superposed | `third_harmonic` |

A zoom within the film, a shadow that moves, or air under the sheet can do the same to a true badge, so none of them
rejects a film.

`judge_segments` gives the verdict for each few seconds.  A segment is judged by the same limits as a film; one with
little motion is inconclusive, which does not count against the film.

Convention: as `comparison`; each grating that moved enough must hold by itself; a row's figure is that of the grating
    that looks most like photographs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits
from moireid.verifier.decision import findings
from moireid.verifier.decision.comparison import (
    CONTAINING,
    Explanation,
    GratingComparison,
    compare,
    film_table,
    law_row,
    merge_chapters,
)
from moireid.verifier.decision.figures import Figures, calibrated_log10, figures_of
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain, gain_reason, lens_reason
from moireid.verifier.explanations.honest import without_short_stretches
from moireid.verifier.explanations.photographs.cross_fade import CrossFade, cross_fade_of
from moireid.verifier.explanations.photographs.fringe_spacing import Spacing, spacing_of
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic, third_harmonic_of
from moireid.verifier.explanations.strength import one_in
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.cell_slip import TOGETHER, RowsApart
from moireid.verifier.reasons import Level, Reason, Verdict, json_number, worst

#: A row of the table, if there is one, and its finding.
RowAndReason = tuple[Explanation | None, Reason]


def photographs(
    spacing: Spacing | None, moved: Sequence[GratingSignal], sheet: SheetGain = DESIGNED
) -> tuple[tuple[Explanation, ...], list[Reason]]:
    """The rows and findings on photographs.

    Parameters: spacing: of all gratings, None where the distance does not change; moved: signals that moved enough;
        sheet: how sharp the fringes must be.
    """
    rows = [] if spacing is None else [_at_one_distance(spacing)]
    fades = [fade for signal in moved if (fade := cross_fade_of(signal)) is not None]
    if fades:
        rows.append(_in_turn(max(fades, key=lambda one: one.certain)))
    sharp = sheet.least_overtone / limits.MIN_OVERTONE_CONTRASTS
    harmonics = [one.asked(sharp) for signal in moved if (one := third_harmonic_of(signal)) is not None]
    if harmonics:
        rows.append(_superposed(min(harmonics, key=lambda one: one.surplus / one.limit)))
    return tuple(row for row, _ in rows if row is not None), [reason for _, reason in rows]


def _at_one_distance(spacing: Spacing) -> RowAndReason:
    level: Level = "undecided" if spacing.wrong else "pass" if spacing.tested else "note"
    seen = "As the badge comes nearer or goes away, the spacing of its fringes"
    text = {
        "undecided": f"{seen} does not follow, as on photographs over a film, or under a zoom. Film without zoom.",
        "pass": f"{seen} follows, which that of photographs from one distance does not.",
        "note": "The distance hardly changed, so the film does not show whether the fringes' spacing follows it.",
    }[level]
    reason = Reason(
        "spacing", level, None if level == "note" else spacing.gain, limits.MAX_SPACING_ERROR_RATIO, "ratio", text
    )
    if level == "note":
        return None, reason
    parameters = {"spacing_gain": spacing.gain}
    return Explanation("photographs_at_one_distance", spacing.log10_odds, parameters, None, spacing.wrong), reason


def _in_turn(fade: CrossFade) -> RowAndReason:
    level: Level = "undecided" if fade.seen else "pass"
    text = "The fringes keep their shape all along their way."
    if fade.seen:
        text = f"The fringes change their shape as those of {fade.photographs} photographs do that are shown in turn, "
        text += "or one faded into the other. Film in even light, and keep the badge moving."
    parameters = {"photographs": float(fade.photographs), "form_share": fade.share}
    row = Explanation("photographs_in_turn", fade.log10_odds, parameters, None, fade.seen)
    return row, Reason("cross_fade", level, fade.certain, limits.MAX_CROSS_FADE_SHARE, "share", text)


def _superposed(harmonic: ThirdHarmonic) -> RowAndReason:
    level: Level = "pass" if harmonic.seen else "undecided"
    text = "The fringes have sharp edges, as lenses make them."
    if not harmonic.seen:
        text = "The fringes lack the sharp edges that lenses make, as in a blurred picture, in superposed "
        text += "photographs, or under a sheet with air beneath it. "
        text += "Film from nearer, in focus, with the sheet pressed flat."
    parameters = {"third_harmonic": harmonic.surplus, "let_through": harmonic.let_through}
    row = Explanation("photographs_laid_over", harmonic.log10_odds, parameters, None, not harmonic.seen)
    return row, Reason("third_harmonic", level, harmonic.surplus, harmonic.limit, "contrasts", text)


Array = NDArray[np.float64]


@dataclass(frozen=True)
class Invariant:
    """Outcome of the motion test; figures are None if nothing could be measured.

    gain_ratio: of measured over predicted phase; gain_expected: by which the prediction was multiplied, as the badge is
    known as built, 1 for one as designed; score: log10 odds of the law over its weighted rivals; calibrated_log10: the
    same, calibrated on honest and forged films; explanations: the table, the law first; photographs: rows on the
    fringes' spacing and shape; compared: of each grating.
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
    calibrated_log10: float | None = None
    gratings: tuple[dict[str, Any], ...] = ()
    gain_expected: float = 1.0
    explanations: tuple[Explanation, ...] = ()
    photographs: tuple[Explanation, ...] = ()
    compared: tuple[GratingComparison, ...] = ()

    @property
    def strength(self) -> int | None:
        """Of forgeries that know nothing of the law, at most 1 in so many looks as this film does; None where the law
        does not explain the film, so that nothing needs to look like it.
        """
        bounds = [one.share_at_most for one in self.explanations if one.share_at_most is not None]
        return one_in(max(bounds)) if bounds else None

    @property
    def table(self) -> tuple[Explanation, ...]:
        """All explanations: the law, its rivals, and photographs."""
        return (*self.explanations, *self.photographs)

    @property
    def law_fits(self) -> bool:
        """Whether the law explains the fringes, and no rival does so better."""
        return bool(self.explanations) and self.explanations[0].fits and not any(e.better for e in self.explanations)

    def gain_apart_from(self, whole: Invariant) -> Reason | None:
        """The finding on the gain of a part of a film, where that is not accepted and surely another one than the
        whole's; else None.
        """
        apart = abs((self.gain_ratio or 0.0) - (whole.gain_ratio or 0.0))
        if apart <= limits.GAIN_REJECTED_SDS * math.hypot(self.gain_sd or 0.0, whole.gain_sd or 0.0):
            return None
        return next((reason for reason in self.reasons if reason.code == "gain" and reason.level != "pass"), None)

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
            "calibrated_log10",
        )
        figures = {name: json_number(getattr(self, name)) for name in names}
        return {"verdict": self.verdict, **figures, "gratings": list(self.gratings)}


def judge_signals(
    signals: Sequence[GratingSignal],
    sheet: SheetGain = DESIGNED,
    *,
    constant_room_rad: float | None = None,
    code_apart: RowsApart = TOGETHER,
    page_off: bool = False,
    whole: bool = True,
    least_strength: int = limits.LEAST_STRENGTH,
    chapters: Sequence[Sequence[GratingComparison]] = (),
) -> Invariant:
    """Compare explanations of one signal per grating.

    Parameters
    ----------
    signals : sequence of GratingSignal
        Under the gain that `sheet` expects, one for each grating.
    sheet : SheetGain
        Gains that the badge may have.
    constant_room_rad : float, optional
        How far the phase constant may be from that at enrolment, rad; None where none is known.
    code_apart : RowsApart
        As `findings.rows_agree`.
    page_off : bool
        As `Identity.page_off`: the fringes then prove nothing against the film.
    whole : bool
        False leaves out what a few seconds do not need, the rivals' shares and photographs.
    least_strength : int
        Strength that an acceptance needs, 1 in so many.
    chapters : sequence of sequences of GratingComparison
        Comparisons of the film's chapters, of which the signals are the whole.

    Returns
    -------
    Invariant
        Gratings are combined by their Fisher information.

    Notes
    -----
    Source: module docstring.
    """
    signals = [without_short_stretches(signal) for signal in signals]
    # Fringes whose spacing does not follow the distance may be seen through a zoom.
    spacing = spacing_of(signals)
    if chapters:
        grouped = zip(*chapters, strict=True)
        compared = [merge_chapters(parts, figures_of(s)) for parts, s in zip(grouped, signals, strict=True)]
    else:
        options: dict[str, Any] = {"constant_room_rad": constant_room_rad, "shares": whole}
        options["allowed_share"] = 1 / least_strength
        options["doubted"] = spacing is not None and spacing.wrong
        compared = [compare(signal, sheet, **options) for signal in signals]
    information = np.array([one.figures.information for one in compared])
    if not information.sum() > 0:
        return Invariant("inconclusive", (findings.no_fringes(),))
    mean = _mean_figures([one.figures for one in compared], information / information.sum())
    moving = [(signal, one) for signal, one in zip(signals, compared, strict=True) if one.moved]
    moved = [one for _, one in moving]
    reasons = list(findings.evidence(signals, mean, enough=bool(moved)))
    table: tuple[Explanation, ...] = ()
    of_photographs: tuple[Explanation, ...] = ()
    score = 0.0
    if moved:
        table = film_table(compared)
        score = min(one.score for one in moved)
        wrong = max((one.figures for one in moved), key=lambda one: abs(one.gain_ratio - 1))
        lens_room = min(s.lens_room[0] for s in signals), max(s.lens_room[1] for s in signals)
        gain = gain_reason(wrong.gain_ratio, wrong.gain_sd, sheet, lens_room)
        if (
            gain.level == "undecided"
            and (lens := lens_reason(wrong.gain_ratio, wrong.gain_sd, sheet, lens_room)) is not None
        ):
            reasons.append(lens)
        laws = findings.law_fits(compared)
        reasons += findings.with_nuisances([gain, *laws, findings.rows_agree(compared, code_apart)], signals, compared)
        fits = all(one.fits for one in moved)
        # Where only the gain is unusual, its own finding says so; what is left to ask is whether parts move apart.
        only_gain = gain.level != "pass" and fits and not all(one.usual for one in moved)
        asked = [one for one in table if one.name in CONTAINING and one.fits] if only_gain else table
        # Where page or sheet is off, fringes and photographs of the design say nothing.
        if asked and not page_off:
            allowed = moved[0].allowed_share
            reasons += findings.rivals(asked, mean.excitation_rad, law_fits=fits, allowed_share=allowed)
        if whole and not page_off:
            of_photographs, photograph_reasons = photographs(spacing, [signal for signal, _ in moving], sheet)
            reasons += photograph_reasons
        steep_share = _steep_share([signal for signal, _ in moving], sheet, reasons)
        reasons = findings.of_any_build(reasons, steep_share, page_off=page_off)
    return Invariant(
        worst(reasons),
        tuple(reasons),
        mean.correlation,
        mean.window_correlation_mean,
        mean.gain_ratio,
        mean.gain_sd,
        mean.phase_residual_rad,
        mean.excitation_rad,
        score,
        calibrated_log10(score),
        tuple(one.figures.to_json() | {"score": json_number(one.score)} for one in compared),
        sheet.expected,
        (law_row(compared), *table) if table else (),
        of_photographs,
        tuple(compared),
    )


def _steep_share(moving: Sequence[GratingSignal], sheet: SheetGain, reasons: Sequence[Reason]) -> float:
    """Share of the frames that are seen from aside, where a failure may rest on those: 0 where the frames from the
    front fail by what their fringes do.
    """
    steep = np.any([signal.steep for signal in moving], axis=0)
    front = np.flatnonzero(~steep)
    share = float(np.mean(steep))
    failing = any(reason.level == "fail" for reason in reasons)
    if share <= limits.MAX_STEEP_SHARE or len(front) < limits.WINDOW_FRAMES or not failing:
        return share
    judged = judge_signals([signal.part(front) for signal in moving], sheet, whole=False)
    failed = {reason.code for reason in judged.reasons if reason.level == "fail"}
    return 0.0 if failed & {"gain", "residual"} else share


def gain_of(signals: Sequence[GratingSignal]) -> tuple[float, float] | None:
    """Gain of all gratings over what is expected, and its standard deviation; None where nothing can be read."""
    figures = [figures_of(signal) for signal in signals]
    information = np.array([one.information for one in figures])
    if not information.sum() > 0:
        return None
    mean = _mean_figures(figures, information / information.sum())
    return mean.gain_ratio, mean.gain_sd


def _mean_figures(figures: Sequence[Figures], share: Array) -> Figures:
    """Mean figures of all gratings, weighted by their information."""
    known = [(w, vars(one)) for w, one in zip(share, figures, strict=True) if w > 0]
    return Figures(**{field.name: float(sum(w * one[field.name] for w, one in known)) for field in fields(Figures)})


@dataclass(frozen=True)
class Segment:
    """Some seconds of a film: start and end, frames that show the badge, and their verdict."""

    start_s: float
    end_s: float
    tracked: int
    verdict: Verdict
    correlation: float | None = None
    gain_ratio: float | None = None
    excitation_rad: float | None = None

    def to_json(self) -> dict[str, Any]:
        """As an entry of `segments` of `verify --json`."""
        names = ("start_s", "end_s", "tracked", "verdict", "correlation", "gain_ratio", "excitation_rad")
        return {name: json_number(getattr(self, name)) for name in names}


def judge_segments(measurement: Measurement, first: int = 0, sheet: SheetGain = DESIGNED) -> tuple[Segment, ...]:
    """Segments of `SEGMENT_S`, one after another from tracked frame `first` on; sheet: as `judge.judge_signals`.

    Returns: segments with at least one tracked frame; those with less than a window of frames are inconclusive.
    """
    times = measurement.times_s
    number = np.floor((times - times[first]) / limits.SEGMENT_S).astype(int)
    found = []
    for k in np.unique(number[first:]):
        frames = np.flatnonzero(number == k)
        start = float(times[first] + k * limits.SEGMENT_S)
        end = float(min(start + limits.SEGMENT_S, times[-1]))
        if len(frames) < limits.WINDOW_FRAMES:
            found.append(Segment(start, end, len(frames), "inconclusive"))
            continue
        judged = judge_signals(tuple(signal.part(frames) for signal in measurement.gratings), sheet, whole=False)
        found.append(
            Segment(
                start, end, len(frames), judged.verdict, judged.correlation, judged.gain_ratio, judged.excitation_rad
            )
        )
    return tuple(found)
