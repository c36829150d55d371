"""The motion invariant: does the law explain this film, and does any rival explain it as well?

1. Is there enough to judge: fringes, motion, badge uncovered? (`findings.evidence`)
2. What may make the film of a true badge look forged? (`doubts`)  What it may excuse fails none of steps 3 to 5.
3. The gain: is it one that this badge's sheet may have? (`sheet_gain`)
4. The law: does it explain the phase in absolute terms, nuisances allowed? (`comparison`, `findings.residual`)
5. Do the parts of the badge move as one? (`parts`)
6. Rivals: does any fit better, and would any look as law-like as this film does? (`findings.rivals`)
7. Photographs: do the fringes' spacing and shape follow the law, too? (`photographs`)

A film is accepted if all of that holds.  It is rejected if gain, residual or a part is what no true badge's film shows.
Else it is inconclusive, and the findings name the rival that remains, or the doubt.

`judge_segments` gives the verdict for each few seconds.  A segment is judged by the same limits as a film; one with
little motion is inconclusive, which does not count against the film.

Convention: as `comparison`; each grating that moved enough must hold by itself.
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
from moireid.verifier.decision.comparison import GratingComparison, compare, film_table, law_row, merge_chapters
from moireid.verifier.decision.doubts import camera_doubted, doubts_of
from moireid.verifier.decision.figures import Figures, calibrated_log10, figures_of
from moireid.verifier.decision.parts import parts, parts_of
from moireid.verifier.decision.photographs import photographs, softest
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain
from moireid.verifier.explanations.honest import without_short_stretches
from moireid.verifier.explanations.photographs.fringe_spacing import spacing_of
from moireid.verifier.explanations.strength import one_in
from moireid.verifier.explanations.table import Explanation
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.cell_slip import TOGETHER, RowsApart
from moireid.verifier.reasons import Reason, Verdict, json_number, worst

Array = NDArray[np.float64]
#: Figures of a film that are means over its gratings.
FIGURES = (
    "correlation",
    "window_correlation_mean",
    "gain_ratio",
    "gain_sd",
    "phase_residual_rad",
    "excitation_rad",
)


@dataclass(frozen=True)
class Invariant:
    """Outcome of the motion test; figures are None if nothing could be measured.

    gain_ratio: of measured over predicted phase; gain_expected: by which the prediction was multiplied, as the badge is
    known as built, 1 for one as designed; score: log10 odds of the law over its weighted rivals; calibrated_log10: the
    same, calibrated on honest and forged films; explanations: the table, the law first; third_harmonic: as
    `ThirdHarmonic.from_front`; compared: of each grating; broken_but_for_noise: whether parts or residual
    prove a forgery if noise excuses nothing (`limits.NOISE_EXCUSED_RATIO`), so that no film with such a part is good.
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
    third_harmonic: float | None = None
    compared: tuple[GratingComparison, ...] = ()
    broken_but_for_noise: bool = False

    @property
    def strength(self) -> int | None:
        """Of forgeries that know nothing of the law, at most 1 in so many looks as this film does; None where the law
        does not explain the film, so that nothing needs to look like it.
        """
        bounds = [one.share_at_most for one in self.explanations if one.share_at_most is not None]
        return one_in(max(bounds)) if bounds else None

    @property
    def law_fits(self) -> bool:
        """Whether the law explains the fringes of all parts, and no rival does so better."""
        apart = any(reason.code == "parts" and reason.level != "pass" for reason in self.reasons)
        better = any(one.better_than_law for one in self.explanations)
        return bool(self.explanations) and self.explanations[0].fits and not better and not apart

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
        names = (*FIGURES, "gain_expected", "score", "calibrated_log10")
        figures = {name: json_number(getattr(self, name)) for name in names}
        return {"verdict": self.verdict, **figures, "gratings": list(self.gratings)}


def judge(
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
        How far the code's rows move apart from the plain ones.
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
    zoomed = spacing is not None and spacing.wrong
    if chapters:
        grouped = zip(*chapters, strict=True)
        laws = [merge_chapters(own, figures_of(signal)) for own, signal in zip(grouped, signals, strict=True)]
    else:
        how: dict[str, Any] = {"constant_room_rad": constant_room_rad, "shares": whole}
        how["allowed_share"] = 1 / least_strength
        laws = [compare(signal, sheet, doubted=zoomed or camera_doubted(signal), **how) for signal in signals]
    information = np.array([law.figures.information for law in laws])
    if not information.sum() > 0:
        return Invariant("inconclusive", (findings.no_fringes(),))
    mean = _mean_figures([law.figures for law in laws], information / information.sum())
    moving = [(signal, law) for signal, law in zip(signals, laws, strict=True) if law.moved]
    moved = [signal for signal, _ in moving]
    score = min((law.score for _, law in moving), default=0.0)
    table, harmonic, broken = film_table(laws), None, False
    reasons = findings.evidence(signals, mean, enough=bool(moving))  # Step 1.
    if moving:
        doubts = doubts_of(moving)  # Step 2.
        several = parts_of([law.figures for law in laws], code_apart, covered=doubts.covered)

        prove = doubts.small is None and not page_off
        gains = findings.gain(moving, sheet, prove=prove)  # Step 3.
        residual = findings.residual(laws, prove=prove and not doubts.covered)  # Step 4.
        together = parts(several, prove=prove)  # Step 5.
        tests = [*gains, residual, together]
        left = not doubts.covered and any(law.deviation_rad > law.noiseless_rad for _, law in moving)
        broken = prove and (left or any(one.deviation_rad > one.proof_rad for one in several))
        reasons += tests
        if any(one.level != "pass" for one in tests):
            reasons += [one for one in (doubts.camera, doubts.small) if one is not None]
        if together.level != "pass":
            score = min(score, 0.0)
        # Where page or sheet is off, fringes and photographs of the design say nothing.
        if not page_off:
            reasons += findings.rivals(table, moving, tests[0])  # Step 6.
        if whole and not page_off:
            harmonic = softest(moved)
            reasons += photographs(spacing, moved, harmonic)  # Step 7.
    return Invariant(
        worst(reasons),
        tuple(reasons),
        **{name: getattr(mean, name) for name in FIGURES},
        score=score,
        calibrated_log10=calibrated_log10(score),
        gratings=tuple(law.figures.to_json() | {"score": json_number(law.score)} for law in laws),
        gain_expected=sheet.expected,
        explanations=(law_row(laws), *table) if table else (),
        third_harmonic=None if harmonic is None else harmonic.from_front,
        compared=tuple(laws),
        broken_but_for_noise=broken,
    )


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
    """Segments of `SEGMENT_S`, one after another from tracked frame `first` on; sheet: as `judge`.

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
        judged = judge(tuple(signal.part(frames) for signal in measurement.gratings), sheet, whole=False)
        found.append(
            Segment(
                start, end, len(frames), judged.verdict, judged.correlation, judged.gain_ratio, judged.excitation_rad
            )
        )
    return tuple(found)
