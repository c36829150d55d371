"""The motion invariant: does the law explain this film, and does any rival explain it as well?

1. Is there enough to judge: fringes, motion, badge uncovered, one camera?
2. The gain: is it one that this badge's sheet may have? (`sheet_gain`)
3. The law: does it explain the phase in absolute terms, nuisances allowed? (`comparison`)
4. Rivals: does any fit better, and would any look as law-like as this film does?
5. Photographs: do the fringes' spacing and shape follow the law, too? (`photographs`)

A film is accepted if all of that holds.  It is rejected if the law does not explain it with every nuisance allowed, and
a rival does far better.  Else it is inconclusive, and the findings name the rival that remains.

Convention: as `comparison`; each grating that moved enough must hold by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision import findings
from moireid.verifier.decision.calibration import calibrated_log10
from moireid.verifier.decision.comparison import (
    Explanation,
    GratingComparison,
    compare,
    film_table,
    law_row,
    merge_chapters,
)
from moireid.verifier.decision.figures import Figures, figures_of
from moireid.verifier.decision.photographs import photographs
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain, gain_reason
from moireid.verifier.explanations.photographs.spacing import spacing_of
from moireid.verifier.explanations.series import without_short_stretches
from moireid.verifier.fringes.signals import GratingSignal, Measurement
from moireid.verifier.reasons import Reason, Verdict, json_number, worst

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
    def table(self) -> tuple[Explanation, ...]:
        """All explanations: the law, its rivals, and photographs."""
        return (*self.explanations, *self.photographs)

    @property
    def law_fits(self) -> bool:
        """Whether the law explains the fringes, and no rival does so better."""
        return bool(self.explanations) and self.explanations[0].fits and not any(e.better for e in self.explanations)

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


def judge_invariant(
    measurement: Measurement,
    sheet: SheetGain = DESIGNED,
    *,
    constant_room_rad: float | None = None,
    code_apart_rad: tuple[float, float] = (0.0, 0.0),
) -> Invariant:
    """Compare explanations of a whole measurement; parameters as `judge_signals`."""
    return judge_signals(
        measurement.gratings, sheet, constant_room_rad=constant_room_rad, code_apart_rad=code_apart_rad
    )


def judge_signals(
    signals: Sequence[GratingSignal],
    sheet: SheetGain = DESIGNED,
    *,
    constant_room_rad: float | None = None,
    code_apart_rad: tuple[float, float] = (0.0, 0.0),
    whole: bool = True,
    chapters: Sequence[Sequence[GratingComparison]] = (),
) -> Invariant:
    """Compare explanations of one signal per grating.

    Parameters: signals: under the gain that `sheet` expects; constant_room_rad: how far the phase constant may be from
        that at enrolment, None where none is known; code_apart_rad: as `findings.rows_agree`; whole: False leaves out
        what a few seconds do not need, the rivals' shares and photographs; chapters: comparisons of the film's
        chapters, of which the signals are the whole.
    Source: module docstring; gratings are combined by their Fisher information.
    """
    signals = [without_short_stretches(signal) for signal in signals]
    # Fringes whose spacing does not follow the distance may be seen through a zoom.
    spacing = spacing_of(signals)
    if chapters:
        grouped = zip(*chapters, strict=True)
        compared = [merge_chapters(parts, figures_of(s)) for parts, s in zip(grouped, signals, strict=True)]
    else:
        options: dict[str, Any] = {"constant_room_rad": constant_room_rad, "shares": whole}
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
        gain = gain_reason(wrong.gain_ratio, wrong.gain_sd, sheet)
        laws = findings.law_fits(compared)
        reasons += findings.with_nuisances(
            [gain, *laws, findings.rows_agree(compared, code_apart_rad)], signals, compared
        )
        reasons += findings.rivals(table, mean.excitation_rad, law_fits=all(one.fits for one in moved))
        if whole:
            of_photographs, told = photographs(spacing, [signal for signal, _ in moving])
            reasons += told
            reasons += findings.phase_gaps([signal for signal, _ in moving])
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
    names = [field.name for field in fields(Figures)]

    def mean(name: str) -> float:
        return float(sum(w * getattr(f, name) for w, f in zip(share, figures, strict=True) if w > 0))

    return replace(Figures(), **{name: mean(name) for name in names})
