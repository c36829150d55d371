"""The figures of one grating over a film, and calibrated odds from a score.

The figures say how well a grating's fringes follow the prediction, and how large the residuals are.

A score is as sharp as its noise model; on films it is overconfident.  So it is calibrated: the logarithm of the odds
that films with this score are honest, where as many are honest as forged, capped at what the set of films supports.
Odds are no probability: how many films are forged in the first place is not known here.

Convention: gain is measured over predicted phase, +1 for a genuine badge; all angles in rad.
Source: logistic regression of honest against forged films on the score (Platt 1999), by `moireid lab bench priors`; the
    verbal scale is that of the ENFSI guideline for evaluative reporting (2015).
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits
from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.strip_shape import BLOCKS
from moireid.verifier.reasons import json_number

Array = NDArray[np.float64]


#: Noise of a place over that of its strip, which is the mean of so many.
NOISE_OF_PLACES = math.sqrt(BLOCKS)
#: Figures that a report does not show.
INNER = ("rounding_rad", "tangent_sd", "air_rad", "strip_beyond_rad", "place_beyond_rad", "noise_rad")


@dataclass(frozen=True)
class Figures:
    """One grating's figures, all 0 where too few frames could be read.

    phase_residual_rad: standard deviation of the regression's residual; excitation_rad: standard deviation of the
    predicted phase; expected_error_rad: expected error of one frame; strip_wander_rad: deviation of the worst strip;
    strip_sd_rad: error bar of a typical strip; place_wander_rad: deviation of places within a strip; strip_beyond_rad,
    place_beyond_rad: their part beyond noise (`_beyond_noise`); noise_rad: error of the signal of all strips, as their
    contrasts show it; rounding_rad and tangent_sd: as in `GratingSignal`; information: Fisher information on the gain;
    air_share: as `air_share`; air_sd: the part of gain_sd that is its error; air_rad: spread of the difference of both
    laws; all 0 where no view is from beyond the critical angle.
    """

    correlation: float = 0.0
    window_correlation_mean: float = 0.0
    gain_ratio: float = 0.0
    gain_sd: float = 0.0
    phase_residual_rad: float = 0.0
    excitation_rad: float = 0.0
    expected_error_rad: float = 0.0
    strip_wander_rad: float = 0.0
    strip_sd_rad: float = 0.0
    place_wander_rad: float = 0.0
    rounding_rad: float = 0.0
    tangent_sd: float = 0.0
    information: float = 0.0
    air_share: float = 0.0
    air_sd: float = 0.0
    air_rad: float = 0.0
    strip_beyond_rad: float = 0.0
    place_beyond_rad: float = 0.0
    noise_rad: float = 0.0

    def to_json(self) -> dict[str, object]:
        """As an entry of `invariant.gratings`."""
        return {name: json_number(value) for name, value in asdict(self).items() if name not in INNER}


def figures_of(signal: GratingSignal) -> Figures:
    """All figures of one grating.

    Source: linear regression of measured on *predicted* phase, so that the gain is a ratio at any angle; less what air
        beneath the sheet adds to it, with the error of that (`air_share`).
    """
    used = np.isfinite(signal.phase_sd_rad)
    measured, predicted = signal.measured_rad[used], signal.predicted_rad[used]
    if len(measured) < limits.WINDOW_FRAMES:
        return Figures()
    # Each stretch has a phase constant of its own, so only what moves within one is evidence.
    stretch = signal.stretch[used]
    measured, predicted = within_stretches(measured, stretch), within_stretches(predicted, stretch)
    power = float(predicted @ predicted)
    gain = float(predicted @ measured) / power if power > 0 else 0.0
    residual = measured - gain * predicted
    air = within_stretches(signal.air_rad[used], stretch)
    share, share_sd, air_gain, apart = air_share(air, predicted, residual)
    residual, gain = residual - share * apart, gain - share * air_gain
    return Figures(
        abs(pearson(measured, predicted)),
        window_correlation_mean(measured, predicted),
        gain,
        math.hypot(
            _slope_sd(residual, power),
            math.hypot(signal.tangent_sd, law_error_share(signal)) * abs(gain),
            share_sd * air_gain,
        ),
        float(residual.std()),
        float(predicted.std()),
        math.hypot(float(np.median(signal.phase_sd_rad[used])), signal.pose_sd_rad),
        float(signal.strip_residual_rad.max(initial=0.0)),
        float(np.median(signal.strip_sd_rad)) if len(signal.strip_sd_rad) else 0.0,
        float(signal.place_residual_rad.max(initial=0.0)),
        signal.rounding_rad,
        signal.tangent_sd,
        float(np.sum(predicted**2 / (signal.phase_sd_rad[used] ** 2 + signal.pose_sd_rad**2))),
        share,
        share_sd * abs(air_gain),
        float(air.std()),
        _beyond_noise(signal.strip_residual_rad, signal.strip_noise_rad),
        _beyond_noise(signal.place_residual_rad, NOISE_OF_PLACES * signal.strip_noise_rad),
        float(np.sqrt(np.mean(noise**2) / len(noise))) if len(noise := signal.strip_noise_rad) else 0.0,
    )


def air_share(air_rad: Array, predicted: Array, residual: Array) -> tuple[float, float, float, Array]:
    """How much of the difference between a sheet that is laid on and one that is glued a film shows, 0 to 1, and its
    standard deviation; by how much the whole difference changes a gain; and what that leaves of it, (T,).

    Parameters: air_rad: as `GratingSignal.air_rad`; residual: what the gain alone leaves of the measured phase; all
        (T,), with mean 0 in each stretch.
    Source: mean and standard deviation of a normal distribution cut off at 0 and 1, as any share is as likely
        beforehand.  Its own is that of the regression on what a gain cannot take up, and of a bent page, which looks
        much like that: `MAX_SHAPE_SHARE` of the motion, in three standard deviations.
    """
    power = float(predicted @ predicted)
    gain = float(air_rad @ predicted) / power if power > 0 else 0.0
    apart = air_rad - gain * predicted
    left = float(apart @ apart)
    if not left > 0:
        return 0.0, 0.0, 0.0, apart
    seen = float(apart @ residual) / left
    bent = limits.MAX_SHAPE_SHARE / 3 * math.sqrt(power / left)
    shares = np.linspace(0.0, 1.0, 201)
    away = ((shares - seen) / math.hypot(_slope_sd(residual - seen * apart, left), bent)) ** 2
    likely = np.exp(-0.5 * (away - away.min()))
    share = float(np.average(shares, weights=likely))
    return share, math.sqrt(np.average((shares - share) ** 2, weights=likely)), gain, apart


def law_error_share(signal: GratingSignal) -> float:
    """Error of the law, as a share of the motion: from aside a sheet's own thickness, index and focus change it."""
    return limits.LAW_MOTION_SHARE * signal.aside_share


def _beyond_noise(apart_rad: Array, noise_rad: Array) -> float:
    """What noise does not explain of the worst strip's deviation, rad; 0 if it is not known.

    Parameters: apart_rad, noise_rad (S,): of each strip, as in `GratingSignal`.
    Source: additive noise, such as a codec's, changes a fringe's contrast by as much as it turns its phase; a motion
        only turns it.  So contrasts show how much of a deviation is noise, however long a codec repeats it and over how
        many pixels.  That counts where a sheet is turned so far that fringes lean by whole periods across a strip and
        cancel, so that little else is left.
    """
    known = noise_rad if len(noise_rad) == len(apart_rad) else np.zeros(len(apart_rad))
    excess = apart_rad**2 - (limits.NOISE_EXCUSED_RATIO * known) ** 2
    return math.sqrt(float(excess.max(initial=0.0)))


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
    if len(measured) < limits.WINDOW_FRAMES:
        return np.zeros(0)
    both = np.stack([measured, predicted])
    windows = np.lib.stride_tricks.sliding_window_view(both, limits.WINDOW_FRAMES, axis=1)
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


def calibrated_log10(score: float) -> float:
    """Calibrated decadic logarithm of the odds of the honest explanation, capped on both sides.

    Convention: it never has another sign than the score.  A film that hardly tests the law, such as a single sweep, has
    a low score and no support either way; the films of the calibration all test it.
    """
    value = limits.CALIBRATION_SLOPE * score
    if score > 0:
        value = max(value + limits.CALIBRATION_OFFSET_LOG10, 0.0)
    return min(max(value, -limits.CALIBRATION_CAP_LOG10), limits.CALIBRATION_CAP_LOG10)
