"""The honest explanation: the law of optics, with what an honest camera, badge and codec may add to it.

It is fitted to the phase of one grating (`PhaseSeries`): measured, predicted by the law, and what else is known.
The phase is a gain times the law, plus bounded nuisances: each is a known shape whose size is at most what its cause
can do.  A nuisance that explains more than that is cut off at its bound, so it cannot hide another motion.

| nuisance | shape | cause |
|---|---|---|
| `air` | the law of a sheet laid on, less that of a glued one | from aside, air hides a part of each lens |
| `lag` | minus the law's rate | a codec shows faint blocks late; a stamp is off by a frame |
| `bend` | the law's square | a bent page or a lens out of focus |
| `across`, `distance` | the other parallax, one over the distance | the same, seen from elsewhere |
| `zoom` | the law times the time | focus breathes |
| `axis`, `axis_turn` | the time, and its square | a stabilised lens moves the optical axis |

Convention: bounds are root mean squares over the film, rad; of `air` none and all of the shape, a part of which a gain
    takes up, so that gains have more room (`HonestModel.seen`).  A series has one entry per block of frames, (N,);
    phases in rad with weighted mean 0 in each stretch, since the phase constant of a stretch is unknown.  The weight
    of a block is 1 for a typical frame and less for a vague one.
Source: linear least squares on columns made orthogonal in this order (Gram-Schmidt), so that cutting one coefficient
    off leaves the others as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits
from moireid.verifier.camera.smoothing import GAP_S, unbroken
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.measuring import MAX_GAP_S

Array = NDArray[np.float64]
#: Of a film that lacks fewer frames than this share, none is put in.
LEAST_MISSING_SHARE = 0.01


@dataclass(frozen=True)
class PhaseSeries:
    """Measured and predicted phase of one grating, with what rivals are built from.

    Attributes
    ----------
    times_s : array (N,)
        Times of the blocks.
    measured_rad, law_rad : array (N,)
        Fringe phase as filmed, and as predicted by the law.
    air_rad : array (N,)
        As `GratingSignal.air_rad`.
    rate_rad_per_s : array (N,)
        Time derivative of the law's phase, without its mean in each stretch.
    weight : array (N,)
        Of each block, 0 to 1.
    stretch : array (N,) of int
        Number of each block's stretch, 0, 1 and so on.
    place_px : array (N, 2) or None
        Place of the badge's middle in the picture.
    views : array (N, 2) or None
        The camera's parallax along the lines, and one over its distance, 1/mm.
    error_rad : float
        Expected error of one frame, from the error bars of phase and pose.
    within_rad : float
        Spread of the frames' deviation from the law about their block's mean; 0 where a block is a frame.
    """

    times_s: Array
    measured_rad: Array
    law_rad: Array
    air_rad: Array
    rate_rad_per_s: Array
    weight: Array
    stretch: NDArray[np.int64]
    place_px: Array | None
    views: Array | None
    error_rad: float
    within_rad: float = 0.0

    @property
    def excitation_rad(self) -> float:
        """Standard deviation of the law's phase."""
        return float(np.sqrt(np.average(self.law_rad**2, weights=self.weight)))

    @property
    def step_s(self) -> float:
        """Usual time between two blocks, s; one frame at 30 a second where times do not rise."""
        steps = np.diff(self.times_s)
        steps = steps[steps > 0]
        return float(np.median(steps)) if len(steps) else 1 / 30

    def centred(self, columns: Array) -> Array:
        """Columns (N, K) without their weighted mean in each stretch."""
        if self.stretch[-1] == 0:
            return np.asarray(columns - (self.weight @ columns) / self.weight.sum())
        starts = np.flatnonzero(np.diff(self.stretch, prepend=-1))
        sums = np.add.reduceat(self.weight[:, None] * columns, starts, axis=0)
        total = np.add.reduceat(self.weight, starts)
        return np.asarray(columns - (sums / total[:, None])[self.stretch])

    def weighted(self, weight: Array) -> PhaseSeries:
        """The same with other weights (N,) of the blocks."""
        other = replace(self, weight=weight)
        phases = other.centred(np.column_stack([self.measured_rad, self.law_rad, self.air_rad, self.rate_rad_per_s]))
        measured, law, air, rate = phases.T
        return replace(other, measured_rad=measured, law_rad=law, air_rad=air, rate_rad_per_s=rate)


def without_short_stretches(signal: GratingSignal) -> GratingSignal:
    """The signal, unread in stretches shorter than the shortest forged part that is searched.

    Each stretch has a phase constant of its own, so a picture that stays still between frequent cuts would leave none.
    """
    _, own = np.unique(signal.stretch, return_inverse=True)
    starts = np.flatnonzero(np.diff(own, prepend=-1))
    ends = np.append(starts[1:], len(own)) - 1
    short = (signal.times_s[ends] - signal.times_s[starts] < limits.LEAST_SEEN_S)[own]
    if not short.any():
        return signal
    return replace(signal, phase_sd_rad=np.where(short, np.inf, signal.phase_sd_rad))


def phase_series(signal: GratingSignal) -> PhaseSeries | None:
    """The series of one grating's readable frames, of at most `MOST_BLOCKS` blocks; None where no frame is readable.

    Notes
    -----
    Source: means over blocks of a few frames lose nothing that lasts for 0.2 s or longer, in a film of up to a minute.
    """
    used = np.flatnonzero(np.isfinite(signal.phase_sd_rad))
    if not len(used):
        return None
    stretch = np.unique(signal.stretch[used], return_inverse=True)[1]
    sd = np.hypot(signal.phase_sd_rad[used], signal.pose_sd_rad)
    weight = np.minimum(1.0, (max(float(np.median(sd)), limits.LEAST_SCALE_RAD) / np.maximum(sd, 1e-9)) ** 2)
    predicted = signal.predicted_rad[used]
    columns = [signal.times_s[used] - signal.times_s[used[0]], signal.measured_rad[used], predicted]
    columns += [signal.air_rad[used]]
    columns += [_rate(predicted, signal.times_s[used], stretch), weight]
    if signal.beyond is not None:
        columns += list(signal.beyond.place_px[used].T)
    if signal.covariates is not None:
        columns += list(signal.covariates[used].T)
    table, stretch = _evenly(np.column_stack(columns), stretch)
    starts = _block_starts(stretch, -(-len(table) // limits.MOST_BLOCKS))
    size = np.diff(np.append(starts, len(table)))
    means = np.add.reduceat(table, starts, axis=0) / size[:, None]
    apart = table[:, 1] - table[:, 2] - np.repeat(means[:, 1] - means[:, 2], size)
    times, measured, law, air, rate, weights = means[:, :6].T
    first, last = means[:, 6:8], means[:, -2:]
    raw = PhaseSeries(
        times,
        measured,
        law,
        air,
        rate,
        weights,
        stretch[starts],
        first if signal.beyond is not None else None,
        last if signal.covariates is not None else None,
        float(np.hypot(np.median(signal.phase_sd_rad[used]), signal.pose_sd_rad)),
        float(apart.std()),
    )
    return raw.weighted(weights)


def _evenly(table: Array, stretch: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """A table (T, K), whose first column is the time, with frames put in where some are missing, by interpolation.

    So each second of a film counts alike: a forged part with fewer frames a second would weigh less.
    """
    times = table[:, 0]
    steps = np.where(np.diff(stretch) == 0, np.diff(times), 0.0)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    steps[steps > MAX_GAP_S] = 0.0
    missing = np.maximum(np.round(steps / max(usual, 1e-9)).astype(int) - 1, 0)
    if missing.sum() < LEAST_MISSING_SHARE * len(times):
        return table, stretch
    place = np.arange(len(times)) + np.concatenate([[0], np.cumsum(missing)])
    every = np.arange(place[-1] + 1)
    filled = np.column_stack([np.interp(every, place, column) for column in table.T])
    return filled, stretch[np.searchsorted(place, every, side="right") - 1]


def _block_starts(stretch: NDArray[np.int64], frames: int) -> NDArray[np.int64]:
    """First frame of each block of so many frames; a block ends with its stretch."""
    begins = np.flatnonzero(np.diff(stretch, prepend=-1))
    ends = np.append(begins[1:], len(stretch))
    return np.concatenate([np.arange(begin, end, frames) for begin, end in zip(begins, ends, strict=True)])


def _rate(law_rad: Array, times_s: Array, stretch: NDArray[np.int64]) -> Array:
    """Time derivative of the law, rad/s; 0 in runs of fewer than three frames."""
    rate = np.zeros_like(law_rad)
    for run in unbroken(times_s, GAP_S, stretch):
        clock, kept = np.unique(times_s[run], return_index=True)
        if len(clock) > 2:
            rate[run[kept]] = np.gradient(law_rad[run[kept]], clock)
    return rate


#: A column of which less than this share is new, compared with the columns before it, adds nothing.
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
        self.series, self._badges = series, room
        self._root = np.sqrt(series.weight / series.weight.sum())
        self._excitation = max(series.excitation_rad, 1e-12)
        time = series.times_s - series.times_s.mean()
        time = time / max(float(np.abs(time).max()), 1e-9)
        law, excitation = series.law_rad, series.excitation_rad
        swing = float(np.sqrt(np.average(series.rate_rad_per_s**2, weights=series.weight)))
        shape = limits.MAX_SHAPE_SHARE * excitation
        power = float(series.weight @ law**2)
        self._air_gain = float(series.weight @ (series.air_rad * law)) / max(power, 1e-18)
        air = float(np.linalg.norm(self._root * (series.air_rad - self._air_gain * law)))
        self.room = self.seen(room)
        wanted = [
            ("air", series.air_rad, air),
            ("lag", -series.rate_rad_per_s, limits.MAX_LAG_S * swing),
            ("bend", law**2, shape),
            *([] if series.views is None else [("across", series.views[:, 0], shape)]),
            *([] if series.views is None else [("distance", series.views[:, 1], shape)]),
            ("zoom", law * time, limits.MAX_ZOOM_DRIFT_SHARE * excitation),
            ("axis", time, limits.MAX_AXIS_DRIFT_RAD),
            ("axis_turn", time**2, limits.MAX_AXIS_DRIFT_RAD),
        ]
        columns = [self._root * law / self._excitation]
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
        if "air" in self.names:
            self._lower[self.names.index("air")] = 0.0
        if "lag" in self.names:
            self._lower[self.names.index("lag")] *= limits.MAX_LEAD_S / limits.MAX_LAG_S

    def seen(self, room: Room) -> Room:
        """Gains as the phases show them (`gain`) of badges whose gains are in the room, with air or without."""
        return room[0] + min(self._air_gain, 0.0), room[1] + max(self._air_gain, 0.0)

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
        again = HonestModel(self.series.weighted(weight), self._badges)
        return again.fit(again.series.measured_rad[:, None]).residual_rad[:, 0]

    def gain(self, phases_rad: Array) -> Array:
        """Gains (D,) of series of phases (N, D), each with mean 0 in each stretch."""
        return np.asarray(self._columns[:, 0] @ (self._root[:, None] * phases_rad) / self._excitation)

    def fit(self, phases_rad: Array) -> LawFit:
        """Fit series of phases (N, D), each with mean 0 in each stretch."""
        along, gain = self._columns.T @ (self._root[:, None] * phases_rad), self.gain(phases_rad)
        along[0] = self._excitation * np.clip(gain, *self.room)
        along[1:] = np.clip(along[1:], self._lower[:, None], self._upper[:, None])
        explained = (self._columns @ along) / np.maximum(self._root, 1e-12)[:, None]
        return LawFit(gain, phases_rad - explained, along[1:])
