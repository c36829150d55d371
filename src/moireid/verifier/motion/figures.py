"""The figures of one grating over a film: how well its fringes follow the prediction, and the residuals.

Convention: gain is measured over predicted phase, +1 for a genuine badge; all angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import GAP_S, slow_part, unbroken
from moireid.verifier.camera.stretches import longest_step_s, within_stretches
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import (
    GAIN_SD_RATIO,
    MAX_LAG_S,
    MAX_PLACE_SHARE,
    MAX_VAGUENESS_RATIO,
    MIN_SPELL_SHARE,
    SPELL_S,
    WANDER_MEAN_S,
    WINDOW_FRAMES,
)
from moireid.verifier.motion.likelihood import log10_ratio
from moireid.verifier.reasons import json_number

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Figures:
    """One grating's figures, all 0 where too few frames could be read.

    phase_residual_rad: standard deviation of the regression's residual; wandering_rad: the same after removing what
    goes with the camera's place and what lags by up to a frame; slow_wander_rad: its part below 0.5 Hz; spell_rad: its
    root mean square in the worst second; excitation_rad: standard deviation of the predicted phase; expected_error_rad:
    expected error of one frame; strip_wander_rad: deviation of the worst strip; strip_sd_rad: error bar of a typical
    strip; place_wander_rad: deviation of places within a strip; score: logarithm of the likelihood ratio;
    possible_score: the same where poses err as much as they may; suspected:
    the likeliest kind of forgery; information: Fisher information on the gain.
    """

    correlation: float = 0.0
    window_correlation_mean: float = 0.0
    gain_ratio: float = 0.0
    gain_sd: float = 0.0
    phase_residual_rad: float = 0.0
    wandering_rad: float = 0.0
    slow_wander_rad: float = 0.0
    spell_rad: float = 0.0
    excitation_rad: float = 0.0
    expected_error_rad: float = 0.0
    strip_wander_rad: float = 0.0
    strip_sd_rad: float = 0.0
    place_wander_rad: float = 0.0
    score: float = 0.0
    suspected: str = ""
    information: float = 0.0
    possible_score: float = 0.0

    def to_json(self) -> dict[str, object]:
        """As an entry of `invariant.gratings`."""
        return {name: json_number(value) for name, value in asdict(self).items() if name != "possible_score"}


def figures_of(signal: GratingSignal, gain_spread: float = GAIN_SD_RATIO) -> Figures:
    """All figures of one grating; gain_spread: as `likelihood.log10_ratio`.

    Source: linear regression of measured on *predicted* phase, so that the gain is a ratio at any angle.
    """
    used = np.isfinite(signal.phase_sd_rad)
    measured, predicted = signal.measured_rad[used], signal.predicted_rad[used]
    if len(measured) < WINDOW_FRAMES:
        return Figures()
    # Each stretch has a phase constant of its own, so only what moves within one is evidence.
    stretch = signal.stretch[used]
    measured, predicted = within_stretches(measured, stretch), within_stretches(predicted, stretch)
    excitation = float(predicted.std())
    power = float(predicted @ predicted)
    gain = float(predicted @ measured) / power if power > 0 else 0.0
    residual = measured - gain * predicted
    wandering = _without_place(residual, predicted, signal, used)
    wandering, lagging = _without_lag(wandering, predicted, signal.times_s[used], stretch)
    slow, fast = float(slow_part(wandering, signal.times_s[used], WANDER_MEAN_S, stretch).std()), float(wandering.std())
    spell = _worst_spell(wandering, signal.times_s[used], signal.phase_sd_rad[used])
    expected = math.hypot(float(np.median(signal.phase_sd_rad[used])), signal.pose_sd_rad, lagging)
    gain_sd = math.hypot(_slope_sd(residual, power), signal.tangent_sd * abs(gain))
    strips = float(signal.strip_residual_rad.max(initial=0.0))
    strip_sd = float(np.median(signal.strip_sd_rad)) if len(signal.strip_sd_rad) else 0.0
    places = _places_apart(signal)
    shown = {"wander": slow, "jitter": fast, "spell": spell, "strips": strips, "places": places}

    def ratio(error_rad: float) -> tuple[float, str]:
        return log10_ratio(
            gain,
            gain_sd,
            shown,
            excitation,
            error_rad,
            strip_sd_rad=strip_sd,
            rounding_rad=signal.rounding_rad,
            gain_spread=gain_spread,
        )

    score, suspected = ratio(expected)
    return Figures(
        abs(pearson(measured, predicted)),
        window_correlation_mean(measured, predicted),
        gain,
        gain_sd,
        float(residual.std()),
        fast,
        slow,
        spell,
        excitation,
        expected,
        strips,
        strip_sd,
        places,
        score,
        suspected,
        float(np.sum(predicted**2 / (signal.phase_sd_rad[used] ** 2 + signal.pose_sd_rad**2))),
        score if signal.doubt == 1 else max(score, ratio(signal.doubt * expected)[0]),
    )


def _worst_spell(wandering: Array, times_s: Array, phase_sd_rad: Array) -> float:
    """Root mean square of the deviation within the worst `SPELL_S` of the film, rad.

    A frame with a larger error bar than the median counts less in proportion.  Windows that hold too little of the
    time, at the ends of the film and beside gaps, are left out.
    """
    weighted = wandering * np.minimum(1.0, np.median(phase_sd_rad) / phase_sd_rad)
    power = np.concatenate([[0.0], np.cumsum(weighted**2)])
    first = np.searchsorted(times_s, times_s - SPELL_S / 2)
    end = np.searchsorted(times_s, times_s + SPELL_S / 2, side="right")
    frames = end - first
    # By time and not by number: some seconds have more frames than others.
    told = np.concatenate([[0.0], np.cumsum(np.minimum(np.gradient(times_s), longest_step_s(times_s)))])
    held = told[end] - told[first]
    filled = held >= MIN_SPELL_SHARE * np.median(held)
    return math.sqrt(max(float(((power[end] - power[first]) / frames)[filled].max()), 0.0))


def _places_apart(signal: GratingSignal) -> float:
    """Deviation of places within the worst strip, rad; 0 if it is not known.

    A strip with a far larger error bar than the clearest is partly covered, for example by a hand, and is left out.
    """
    apart, sd = signal.place_residual_rad, signal.strip_sd_rad
    if len(sd) == len(apart):
        apart = apart[sd <= MAX_VAGUENESS_RATIO * sd.min(initial=math.inf)]
    return float(apart.max(initial=0.0))


def _without_place(residual: Array, predicted: Array, signal: GratingSignal, used: NDArray[np.bool_]) -> Array:
    """The residual without what depends on the camera's place: the motion's square, the other axis, the distance.

    Convention: these columns have mean 0 and are orthogonal to the prediction; at most `MAX_PLACE_SHARE` of the motion
        is removed.
    Source: linear regression.
    """
    columns = [predicted**2]
    if signal.covariates is not None:
        columns += list(signal.covariates[used].T)
    table = np.column_stack(columns)
    table = np.column_stack([within_stretches(column, signal.stretch[used]) for column in table.T])
    power = float(predicted @ predicted)
    if power > 0:
        table = table - np.outer(predicted, predicted @ table) / power
    spread = table.std(axis=0)
    # A column that hardly varies would be scaled up until it explains noise.
    table = table[:, spread > 1e-9] / spread[spread > 1e-9]
    if len(residual) < 10 * (table.shape[1] + 1) or not table.shape[1]:
        return residual
    explained = table @ np.linalg.lstsq(table, residual, rcond=1e-6)[0]
    most = MAX_PLACE_SHARE * float(predicted.std())
    return np.asarray(residual - explained * min(1.0, most / max(float(explained.std()), 1e-12)))


def _without_lag(residual: Array, predicted: Array, times_s: Array, numbers: NDArray[np.int64]) -> tuple[Array, float]:
    """The residual without a lag of the fringes: one lag for the whole film, at most `MAX_LAG_S`.

    Returns: the residual, and the phase error from the variation of the lag between frames, rad.
    Convention: a lag of tau adds -tau times the rate of the prediction; fringes that come early are not corrected.
    Source: linear regression; Taylor series of the prediction.  A block that is not coded again grows older with each
        frame, so lags are uniform from 0 to twice their mean, and their standard deviation is the mean over the root of
        3.
    """
    rate = np.zeros_like(predicted)
    for stretch in unbroken(times_s, GAP_S, numbers):
        clock, kept = np.unique(times_s[stretch], return_index=True)
        if len(clock) > 2:
            rate[stretch[kept]] = np.gradient(predicted[stretch[kept]], clock)
    rate = within_stretches(rate, numbers)
    power = float(predicted @ predicted)
    rate -= predicted * (float(predicted @ rate) / power if power > 0 else 0.0)
    swing = float(rate @ rate)
    lag_s = -float(rate @ residual) / swing if swing > 0 else 0.0
    lag_s = float(np.clip(lag_s, 0.0, MAX_LAG_S))
    return residual + lag_s * rate, lag_s * float(rate.std()) / math.sqrt(3)


def pearson(a: Array, b: Array) -> float:
    """Correlation coefficient of two series; 0 where one of them does not move."""
    a, b = a - a.mean(), b - b.mean()
    scale = math.sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / scale if scale > 0 else 0.0


def window_correlation_mean(measured: Array, predicted: Array) -> float:
    """Mean of |rho| over windows of 30 frames, stride 1: the published figure."""
    return float(np.mean(np.abs(window_correlations(measured, predicted))))


def window_correlations(measured: Array, predicted: Array) -> Array:
    """Correlation in each window of 30 frames, stride 1, (T - 29,); empty for a shorter series."""
    if len(measured) < WINDOW_FRAMES:
        return np.zeros(0)
    both = np.stack([measured, predicted])
    windows = np.lib.stride_tricks.sliding_window_view(both, WINDOW_FRAMES, axis=1)
    apart = windows - windows.mean(axis=2, keepdims=True)
    seen, law = np.einsum("ktn,ktn->kt", apart, apart)
    scale = np.sqrt(seen * law)
    along = np.einsum("tn,tn->t", apart[0], apart[1])
    return np.asarray(np.divide(along, scale, out=np.zeros_like(along), where=scale > 0))


def _slope_sd(residual: Array, power: float) -> float:
    """Standard deviation of the slope of a regression with residuals of a first-order autoregressive process."""
    if power <= 0:
        return math.inf
    lag_one = float(np.clip(pearson(residual[1:], residual[:-1]), 0.0, 0.999))
    return math.sqrt(float(residual @ residual) / len(residual) / power * (1 + lag_one) / (1 - lag_one))
