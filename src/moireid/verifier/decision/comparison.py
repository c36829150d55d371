"""The table of explanations of one grating: the law with what an honest film adds, and each rival's odds and share.

1. Fit the law with bounded nuisances (`explanations.honest`).
2. Odds of the law over each rival, by the residuals that both leave (`explanations.rivals`).  Those that are the
   law plus something pay for their freedom (`residuals.own_motion_odds`, `rivals.worst_spell`).
3. How often would a rival that knows nothing of the law look as law-like as this film does? (`explanations.rivals`,
   `explanations.strength`)

Convention: odds are decadic logarithms of the law's over the rival's, above 0 where the law is likelier.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits
from moireid.verifier.decision.figures import Figures, figures_of, law_error_share
from moireid.verifier.decision.sheet_gain import SheetGain
from moireid.verifier.explanations.honest import HonestModel, PhaseSeries, Room, phase_series
from moireid.verifier.explanations.residuals import (
    credible_error_rad,
    deviation_rad,
    independent_samples,
    own_motion_odds,
    residual_limit_rad,
)
from moireid.verifier.explanations.rivals import RIVALS, lookalike_shares, rival_odds, worst_spell
from moireid.verifier.explanations.strength import LookalikeShare
from moireid.verifier.explanations.table import LAW, LAW_PLUS, Explanation
from moireid.verifier.fringes.grating_signal import GratingSignal

Array = NDArray[np.float64]
#: Time in which a film leaves the law most, s: as the worst second of the code's rows.
WORST_S = 1.0


@dataclass(frozen=True)
class GratingComparison:
    """One grating's figures, what the law leaves, and its table of rivals.

    deviation_rad: by how much the film leaves the law and its nuisances (`residuals.deviation_rad`); limit_rad,
    possible_rad, noiseless_rad: what an honest film may leave to be accepted, what it can leave at all, and what it can
    if noise excuses nothing; doubted: whether the camera may have changed within the film; reach: gains that an honest
    badge may then have; usual: whether the gain is one of a build of usual parts before the camera that was solved,
    without which the film is not accepted;
    nuisances_rad: by name; rivals: the table without the law's row; allowed_share: what an acceptance allows of rivals
    that would look alike.
    """

    figures: Figures
    moved: bool
    deviation_rad: float = 0.0
    limit_rad: float = math.inf
    possible_rad: float = math.inf
    noiseless_rad: float = math.inf
    doubted: bool = False
    reach: Room = (0.0, math.inf)
    usual: bool = True
    nuisances_rad: dict[str, float] | None = None
    rivals: tuple[Explanation, ...] = ()
    allowed_share: float = 1 / limits.LEAST_STRENGTH

    @property
    def fits(self) -> bool:
        """Whether the law explains the grating in absolute terms."""
        return self.deviation_rad <= self.limit_rad

    @property
    def possible(self) -> bool:
        """Whether the law could explain it with errors as large as honest films ever have."""
        return self.deviation_rad <= self.possible_rad

    @property
    def score(self) -> float:
        """Decadic logarithm of the odds of the law over the evenly weighted rivals.

        Rivals that are the law plus something count only where they fit better by more than chance.
        """
        known = {rival.name: rival.log10_odds for rival in self.rivals if rival.log10_odds is not None}
        apart = [odds for name, odds in known.items() if name not in LAW_PLUS]
        if not apart:
            return 0.0
        weighed = [odds + math.log10(len(apart)) for odds in apart]
        weighed += [odds for name, odds in known.items() if name in LAW_PLUS and odds < -limits.MAX_RIVAL_LOG10]
        least = min(weighed)
        return least - math.log10(sum(10 ** (least - odds) for odds in weighed))


def enough_motion_rad(expected_error_rad: float) -> float:
    """Least excitation of a film that is judged, rad."""
    return max(limits.MIN_EXCITATION_RAD, limits.MIN_EXCITATION_TO_ERROR_RATIO * expected_error_rad)


def compare(
    signal: GratingSignal,
    sheet: SheetGain,
    *,
    doubted: bool = False,
    constant_room_rad: float | None = None,
    shares: bool = True,
    allowed_share: float = 1 / limits.LEAST_STRENGTH,
) -> GratingComparison:
    """The comparison of one grating.

    Parameters
    ----------
    signal : GratingSignal
        Under the gain that `sheet` expects.
    sheet : SheetGain
        Gains that the badge may have.
    doubted : bool
        Whether the camera may have changed within the film (`Doubts`), which widens the room of gain and residual.
    constant_room_rad : float, optional
        As `lookalike_shares`, rad.
    shares : bool
        Whether to ask how often rivals would look alike, which takes most of the time.
    allowed_share : float
        Largest share of look-alikes that an acceptance allows.

    Returns
    -------
    GratingComparison
        Without rivals if the grating hardly moved, or no frame can be read.
    """
    figures = figures_of(signal)
    series = phase_series(signal)
    if figures.excitation_rad < enough_motion_rad(figures.expected_error_rad) or series is None:
        return GratingComparison(figures, moved=False)
    reach = sheet.reach if not doubted else (sheet.reach[0] / limits.MOST_ZOOM, sheet.reach[1] * limits.MOST_ZOOM)
    # A gain that is uncertain leaves as much of the phase uncertain.
    vague = limits.GAIN_REJECTED_SDS * figures.tangent_sd * abs(figures.gain_ratio)
    reach = (reach[0] - vague, reach[1] + vague)
    model = shape = HonestModel(series, reach)
    fit = model.fit(series.measured_rad[:, None])
    residual, excitation = fit.residual_rad[:, 0], figures.excitation_rad
    usual = reach[0] <= figures.gain_ratio <= reach[1]
    if not usual:
        # With such a gain it is not accepted; whether it is rejected is asked of the law's shape, with any gain that
        # some build and some camera can give.
        least, most = sheet.possible(signal.lens_room)
        least = -most if signal.parallel else least
        shape = HonestModel(series, (min(reach[0], least - vague), max(reach[1], most + vague)))
    shaped = shape.fit(series.measured_rad[:, None]).residual_rad[:, 0]
    deviation = deviation_rad(shaped, series.step_s, series.within_rad)
    # What poses and fringes err by, and what lasts all film long: lens and sheet.
    error = math.hypot(figures.expected_error_rad, signal.shape_sd_rad, law_error_share(signal) * excitation)
    limit = residual_limit_rad(credible_error_rad(excitation, error))
    # A doubt is about poses, not about noise.
    noiseless, possible = (
        math.hypot(
            residual_limit_rad(math.hypot(signal.doubt * error, noise), limits.PROOF_SDS),
            limits.CAMERA_MOTION_SHARE * excitation if doubted else 0.0,
        )
        for noise in (0.0, figures.noise_rad)
    )
    # Where the law does not explain the film, or not with a gain that is accepted, nothing needs to look like it.
    asked = {}
    if shares and usual and deviation <= limit:
        room = model.seen(sheet.room_for(figures.gain_sd))
        asked = lookalike_shares(model, residual, room, allowed=allowed_share, constant_room_rad=constant_room_rad)
    rows = []
    first_s = float(signal.times_s[np.isfinite(signal.phase_sd_rad)][0])
    left = shape.robust_residual_rad()
    own, samples = float(series.weight @ residual**2), independent_samples(residual)
    for rival in RIVALS:
        odds, parameters = rival_odds(rival, series, own, samples, model.room) or (None, {})
        if rival.variants is None:
            odds = own_motion_odds(deviation, excitation, credible_error_rad(excitation, signal.doubt * error))
            parameters = {"motion_share": deviation / excitation} | _worst_span(series, left, first_s)
        as_good = rival.name == "drift" and odds is not None and odds < limits.MAX_RIVAL_LOG10
        rows.append(_row(rival.name, odds, parameters, asked.get(rival.name), allowed_share, as_good=as_good))
    if (spell := worst_spell(series, left)) is not None:
        rest = left[(series.times_s < spell.start_s) | (series.times_s > spell.end_s)]
        at = {"gain": spell.gain, "start_s": first_s + spell.start_s, "end_s": first_s + spell.end_s}
        at["deviation_rad"] = deviation_rad(rest, series.step_s)
        rows.append(_row("spell", spell.log10_odds, at))
    # A film that could be honest leaves up to this; a rival that leaves more does not explain it.
    bound = {"explains_below_rad": limits.POSSIBLE_RESIDUAL_RATIO * limit}
    rows = [
        replace(row, parameters=row.parameters | bound) if "deviation_rad" in row.parameters else row for row in rows
    ]
    nuisances = {name: float(value) for name, value in zip(model.names, fit.nuisances_rad[:, 0], strict=True)}
    return GratingComparison(
        figures,
        True,
        deviation,
        limit,
        possible,
        noiseless,
        doubted,
        reach,
        usual,
        nuisances,
        tuple(rows),
        allowed_share,
    )


def _worst_span(series: PhaseSeries, left_rad: Array, first_s: float) -> dict[str, float]:
    """When the film leaves the law most; first_s: when the series begins, in the film's time."""
    times = series.times_s
    blocks = min(max(round(WORST_S / series.step_s), 1), len(times))
    middle_s = first_s + float(times[np.argmax(np.convolve(left_rad**2, np.ones(blocks), "same"))])
    start_s = max(middle_s - WORST_S / 2, first_s)
    return {"start_s": start_s, "end_s": min(middle_s + WORST_S / 2, first_s + float(times[-1]))}


def merge_chapters(parts: Sequence[GratingComparison], figures: Figures) -> GratingComparison:
    """The comparison of one grating over several chapters of a film.

    Parameters: parts: of each chapter; figures: of all of them together.

    Notes
    -----
    Convention: evidence adds up.  Odds of a rival are the sum over chapters, each with the rival's own best parameters;
    a spell's are those of its chapter, for as many more windows that were tried; a rival's share is the least, as it
    must look law-like in each chapter.
    """
    moved = [part for part in parts if part.moved]
    if not moved:
        return GratingComparison(figures, moved=False)

    def total(name: str, odds: Sequence[float]) -> float:
        return sum(odds) if name != "spell" else min(odds) + math.log10(len(moved))

    rows = _merged(moved, total, moved[0].allowed_share)
    residual, limit, possible, noiseless = (
        math.sqrt(sum(getattr(part, name) ** 2 for part in moved) / len(moved))
        for name in ("deviation_rad", "limit_rad", "possible_rad", "noiseless_rad")
    )
    doubted = any(part.doubted for part in moved)
    reach = min(part.reach[0] for part in moved), max(part.reach[1] for part in moved)
    most, usual = max(moved, key=lambda part: part.figures.information), all(part.usual for part in moved)
    return GratingComparison(
        figures,
        True,
        residual,
        limit,
        possible,
        noiseless,
        doubted,
        reach,
        usual,
        most.nuisances_rad,
        rows,
        moved[0].allowed_share,
    )


def _merged(
    parts: Sequence[GratingComparison], total: Callable[[str, Sequence[float]], float], allowed_share: float
) -> tuple[Explanation, ...]:
    """The tables of several parts as one: of each rival the total odds, and the parameters of where it does best.

    Convention: a rival must look law-like in every part, so its share is the least of them, and it fits as well only
        where it does so in each.
    """
    by_name: dict[str, list[Explanation]] = {}
    for rival in (rival for part in parts for rival in part.rivals):
        by_name.setdefault(rival.name, []).append(rival)
    rows = []
    for name, own in by_name.items():
        best = min(own, key=lambda rival: math.inf if rival.log10_odds is None else rival.log10_odds)
        odds = [rival.log10_odds for rival in own if rival.log10_odds is not None]
        shares = [
            LookalikeShare(one.share, 0.0, one.share_at_most)
            for one in own
            if one.share is not None and one.share_at_most is not None
        ]
        least = min(shares, key=lambda share: share.at_most, default=None)
        summed, as_good = total(name, odds) if odds else None, all(one.as_good for one in own)
        rows.append(_row(name, summed, best.parameters, least, allowed_share, as_good=as_good))
    return tuple(rows)


def _row(
    name: str,
    odds: float | None,
    parameters: dict[str, float],
    share: LookalikeShare | None = None,
    allowed_share: float = 1.0,
    *,
    as_good: bool = False,
) -> Explanation:
    """A rival's row; it remains if it fits better by more than chance, or may look alike too often.

    A drift also remains if at its best-fitting speed it explains each part of the film as well as the law (`as_good`):
    such a film may be one of a drift, however few drifts have that speed.
    """
    remains = odds is not None and odds < -limits.MAX_RIVAL_LOG10
    if share is None:
        return Explanation(name, odds, parameters, None, remains, as_good=as_good)
    remains |= share.at_most > allowed_share or as_good
    return Explanation(name, odds, parameters, share.share, remains, share.at_most, as_good)


def film_table(gratings: list[GratingComparison]) -> tuple[Explanation, ...]:
    """The table of a film: each rival in the grating that moved in which its odds are best."""
    moved = [one for one in gratings if one.moved]
    return _merged(moved, lambda _, odds: min(odds), moved[0].allowed_share) if moved else ()


def law_row(gratings: list[GratingComparison]) -> Explanation:
    """The law's own row of the table, of the most informative grating."""
    most = max(gratings, key=lambda one: one.figures.information)
    parameters = {"gain": most.figures.gain_ratio, "deviation_rad": most.deviation_rad} | {
        f"{name}_rad": value for name, value in (most.nuisances_rad or {}).items()
    }
    moved = [one for one in gratings if one.moved]
    fits = bool(moved) and all(one.fits and one.usual for one in moved)
    return Explanation(LAW, 0.0, parameters, None, fits)
