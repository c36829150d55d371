"""The honest explanation: the law of optics, with what an honest camera, badge and codec may add to it.

The phase is a gain times the law, plus bounded nuisances: each is a known shape whose size is at most what its cause
can do.  A nuisance that explains more than that is cut off at its bound, so it cannot hide another motion.

| nuisance | shape | cause |
|---|---|---|
| `lag` | minus the law's rate | a codec shows faint blocks late; a stamp is off by a frame |
| `bend` | the law's square | a bent page or a lens out of focus |
| `across`, `distance` | the other parallax, one over the distance | the same, seen from elsewhere |
| `zoom` | the law times the time | focus breathes |
| `axis`, `axis_turn` | the time, and its square | a stabilised lens moves the optical axis |

Convention: bounds are root mean squares over the film, rad.
Source: linear least squares on columns made orthogonal in this order (Gram-Schmidt), so that cutting one coefficient
    off leaves the others as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.series import PhaseSeries
from moireid.verifier.limits import MAX_AXIS_DRIFT_RAD, MAX_LAG_S, MAX_LEAD_S, MAX_SHAPE_SHARE, MAX_ZOOM_DRIFT_SHARE

Array = NDArray[np.float64]
#: A column that keeps less than this share of itself beside the others before it adds nothing.
LEAST_NEW_SHARE = 1e-3


#: Deviations of so many standard deviations weigh half.
CAUCHY_SDS = 2.385
#: Least and greatest gain that an honest badge may have.
Room = tuple[float, float]


@dataclass(frozen=True)
class LawFit:
    """The law fitted to one or more series of phases: gain (D,), residual (N, D) rad, nuisances (K, D) rad.

    gain: as the phases show it; the residual is that of the nearest gain which an honest badge may have.
    """

    gain: Array
    residual_rad: Array
    nuisances_rad: Array


class HonestModel:
    """The law and its bounded nuisances over one series; fits many series of phases at once."""

    def __init__(self, series: PhaseSeries, room: Room) -> None:
        """Parameters: series: its law's phase must change; room: gains that an honest badge may have."""
        self.series, self.room = series, room
        self._root = np.sqrt(series.weight / series.weight.sum())
        time = series.times_s - series.times_s.mean()
        time = time / max(float(np.abs(time).max()), 1e-9)
        law, excitation = series.law_rad, series.excitation_rad
        swing = float(np.sqrt(np.average(series.rate_rad_per_s**2, weights=series.weight)))
        shape = MAX_SHAPE_SHARE * excitation
        wanted = [
            ("lag", -series.rate_rad_per_s, MAX_LAG_S * swing),
            ("bend", law**2, shape),
            *([] if series.views is None else [("across", series.views[:, 0], shape)]),
            *([] if series.views is None else [("distance", series.views[:, 1], shape)]),
            ("zoom", law * time, MAX_ZOOM_DRIFT_SHARE * excitation),
            ("axis", time, MAX_AXIS_DRIFT_RAD),
            ("axis_turn", time**2, MAX_AXIS_DRIFT_RAD),
        ]
        columns = [self._root * law / max(excitation, 1e-12)]
        self.names: list[str] = []
        bounds = []
        for name, column, bound in wanted:
            fresh = self._root * series.centred(column[:, None])[:, 0]
            size = float(np.linalg.norm(fresh))
            for _ in range(2):
                for known in columns:
                    fresh = fresh - known * float(known @ fresh)
            left = float(np.linalg.norm(fresh))
            if left > LEAST_NEW_SHARE * size and left > 1e-12:
                columns.append(fresh / left)
                self.names.append(name)
                bounds.append(bound)
        self._columns, self._upper = np.array(columns).T, np.array(bounds)
        self._lower = -self._upper
        if "lag" in self.names:
            self._lower[self.names.index("lag")] *= MAX_LEAD_S / MAX_LAG_S

    def robust_residual_rad(self) -> Array:
        """What the law leaves of the film, (N,), where blocks that deviate far hardly weigh.

        Notes
        -----
        Source: one step of iteratively reweighted least squares with Cauchy's weights (Holland and Welsch 1977); a lie
        for a while then shows where it is, and is not spread over the film.
        """
        first = self.fit(self.series.measured_rad[:, None]).residual_rad[:, 0]
        usual = 1.4826 * float(np.median(np.abs(first - np.median(first))))
        weight = self.series.weight / (1 + (first / max(CAUCHY_SDS * usual, 1e-9)) ** 2)
        again = HonestModel(self.series.weighted(weight), self.room)
        return again.fit(again.series.measured_rad[:, None]).residual_rad[:, 0]

    def fit(self, phases_rad: Array) -> LawFit:
        """Fit series of phases (N, D), each with mean 0 in each stretch."""
        along = self._columns.T @ (self._root[:, None] * phases_rad)
        excitation = max(self.series.excitation_rad, 1e-12)
        gain = along[0] / excitation
        along[0] = excitation * np.clip(gain, *self.room)
        along[1:] = np.clip(along[1:], self._lower[:, None], self._upper[:, None])
        explained = (self._columns @ along) / np.maximum(self._root, 1e-12)[:, None]
        return LawFit(gain, phases_rad - explained, along[1:])
