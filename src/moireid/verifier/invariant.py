"""The motion invariant: does the fringe phase follow the camera as the optics say?

Correlation alone forgets how *much* the fringes move, so four things must hold together: enough motion to tell,
correlation, gain, and a residual that the known errors explain.  Each limit below has its reason; none was fitted to
this project's own simulator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.measure import GratingSignal, Measurement
from moireid.verifier.reasons import Level, Reason, Verdict, json_number, worst

Array = NDArray[np.float64]
WINDOW_FRAMES = 30
#: Least standard deviation of the predicted phase: 0.25 rad is 3.5 cm of sideways sway at 1 m.  Less is not told from
#: the drifts that light and codec make (0.01 to 0.05 rad on films made outside) with five standard deviations to spare.
MIN_EXCITATION_RAD = 0.25
#: ... and it must stand this far above the prediction's own error, which then leaves a correlation of 0.95.
MIN_EXCITATION_TO_ERROR = 3.0
#: Published renderings reach 0.99; hand-held films at 1 to 2 m measured 0.997 and more here, and pose noise at the
#: least excitation allowed leaves 0.97.
MIN_CORRELATION = 0.95
#: A sheet's thickness and index as sold vary by about 10 %, the solved focal length by up to 5 %, pitch by 1 %.
GAIN_TOLERANCE = 0.15
GAIN_SDS = 3.0
#: From this share of the gain on, an error bar is too wide to accept on: fringes at 1.9 times the true gain would be
#: taken for true ones with a chance of 1 % (ln(1.15 / 1.9) is 2.33 times 0.215).
VAGUE_GAIN = 0.215
#: What strays from the law in step with the camera's place is no wander of the fringes: a bent sheet, light from one
#: side, a pose that errs with the tilt; 3 % of the motion each.
PLACE_SHARE = 0.05
#: What is left then is explained by: this floor (light and codec, as above), this share of the motion (a law traced for
#: the sheet as sold), and three times the error of pose and phase.
RESIDUAL_FLOOR_RAD = 0.05
RESIDUAL_SHARE = 0.03
#: Far away, where markers are a few pixels, poses err by up to so many times what they tell: coded pictures err alike
#: in neighbouring frames.  A film that could be true then is left open, and not rejected.
ERROR_UNTOLD = 2.5
#: And what is left after the camera's place by so many times: 1.4 on films made outside, at 1 to 2 m.
RESIDUAL_UNTOLD = 1.5
#: Strips of one true badge share the camera's pose, so they move together within their noise: 0.027 rad at most on 36
#: films made outside at 1 to 3 m, at 45 degrees and sent by chat.  Patches on clocks of their own show 0.15 and more.
MAX_STRIP_WANDER_RAD = 0.1


@dataclass(frozen=True)
class Invariant:
    """Outcome of the motion test; figures are None where nothing could be measured."""

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

    def to_json(self) -> dict[str, Any]:
        """As the `invariant` object of `verify --json`."""
        names = (
            "correlation", "window_correlation_mean", "gain_ratio", "gain_sd",
            "phase_residual_rad", "excitation_rad", "score",
        )  # fmt: skip
        figures = {name: json_number(getattr(self, name)) for name in names}
        return {"verdict": self.verdict, **figures, "gratings": list(self.gratings)}


def judge_invariant(measurement: Measurement) -> Invariant:
    """Hold measured against predicted phase, over a whole measurement; conventions and source as `judge_signals`."""
    return judge_signals(measurement.gratings)


def judge_signals(signals: Sequence[GratingSignal]) -> Invariant:
    """Hold measured against predicted phase, one signal a grating.

    Convention: gain is measured over predicted phase, +1 for a genuine badge; the score is the share of the predicted
    motion that the fringes follow, 1 for genuine, about 0 for unrelated, negative for contrary motion.
    Source: linear regression of measured on predicted phase (regressing on the *predicted* phase makes the gain a
    ratio at any angle); gratings are combined by their Fisher information.
    """
    figures = [_figures(signal) for signal in signals]
    information = np.array([f["information"] for f in figures])
    if not information.sum() > 0:
        nothing = Reason("fringes", "undecided", 0.0, None, "", "No fringes could be read on the badge.")
        return Invariant("inconclusive", (nothing,))
    share = information / information.sum()

    def mean(name: str) -> float:
        return float(sum(w * f[name] for w, f in zip(share, figures, strict=True) if w > 0))

    correlation, gain, gain_sd = mean("correlation"), mean("gain_ratio"), mean("gain_sd")
    residual, excitation, expected = mean("phase_residual_rad"), mean("excitation_rad"), mean("expected_error_rad")
    wander = max(f["strip_wander_rad"] for f in figures)
    reasons = [_enough_motion(excitation, expected)]
    if reasons[0].level == "pass":
        reasons += [
            _correlated(correlation, excitation, expected), _gain_right(gain, gain_sd),
            _residual_explained(mean("wandering_rad"), excitation, expected), _strips_agree(wander, expected),
        ]  # fmt: skip
    return Invariant(
        worst(reasons), tuple(reasons), correlation, mean("window_correlation_mean"), gain, gain_sd, residual,
        excitation, mean("score"), tuple({k: json_number(v) for k, v in f.items()} for f in figures),
    )  # fmt: skip


def _figures(signal: GratingSignal) -> dict[str, float]:
    """All figures of one grating."""
    used = np.isfinite(signal.phase_sd_rad)
    measured, predicted = signal.measured_rad[used], signal.predicted_rad[used]
    names = (
        "correlation", "window_correlation_mean", "gain_ratio", "gain_sd", "phase_residual_rad", "wandering_rad",
        "excitation_rad", "expected_error_rad", "strip_wander_rad", "score", "information",
    )  # fmt: skip
    if len(measured) < WINDOW_FRAMES:
        return dict.fromkeys(names, 0.0)
    measured, predicted = measured - measured.mean(), predicted - predicted.mean()
    excitation = float(predicted.std())
    power = float(predicted @ predicted)
    gain = float(predicted @ measured) / power if power > 0 else 0.0
    residual = measured - gain * predicted
    wandering = float(_without_place(residual, predicted, signal, used).std())
    followed = float(np.clip(gain, 1 - GAIN_TOLERANCE, 1 + GAIN_TOLERANCE))
    unexplained = float(np.sum((measured - followed * predicted) ** 2)) / power if power > 0 else math.inf
    expected = math.hypot(float(np.median(signal.phase_sd_rad[used])), signal.pose_sd_rad)
    gain_sd = math.hypot(_slope_sd(residual, power), signal.tangent_sd * abs(gain))
    values = (
        abs(pearson(measured, predicted)), window_correlation_mean(measured, predicted), gain,
        gain_sd, float(residual.std()), wandering, excitation, expected,
        float(signal.strip_residual_rad.max(initial=0.0)), 1.0 - unexplained,
        float(np.sum(predicted**2 / (signal.phase_sd_rad[used] ** 2 + signal.pose_sd_rad**2))),
    )  # fmt: skip
    return dict(zip(names, values, strict=True))


def _without_place(residual: Array, predicted: Array, signal: GratingSignal, used: NDArray[np.bool_]) -> Array:
    """What is left of the residual without what goes with the camera's place: the motion's square, the other axis, the
    distance.

    Convention: all of mean 0 and apart from the prediction itself; at most `PLACE_SHARE` of the motion is taken away.
    Source: linear regression.
    """
    columns = [predicted**2]
    if signal.elsewhere is not None:
        columns += list(signal.elsewhere[used].T)
    table = np.column_stack(columns)
    table = table - table.mean(axis=0)
    power = float(predicted @ predicted)
    if power > 0:
        table = table - np.outer(predicted, predicted @ table) / power
    spread = table.std(axis=0)
    # A column that hardly moves would be blown up until it explains noise.
    table = table[:, spread > 1e-9] / spread[spread > 1e-9]
    if len(residual) < 10 * (table.shape[1] + 1) or not table.shape[1]:
        return residual
    explained = table @ np.linalg.lstsq(table, residual, rcond=1e-6)[0]
    most = PLACE_SHARE * float(predicted.std())
    return np.asarray(residual - explained * min(1.0, most / max(float(explained.std()), 1e-12)))


def pearson(a: Array, b: Array) -> float:
    """Correlation coefficient of two series; 0 where one of them does not move."""
    a, b = a - a.mean(), b - b.mean()
    scale = math.sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / scale if scale > 0 else 0.0


def window_correlation_mean(measured: Array, predicted: Array) -> float:
    """Plain mean of |rho| over windows of 30 frames, stride 1: the published figure."""
    return float(np.mean(np.abs(window_correlations(measured, predicted))))


def window_correlations(measured: Array, predicted: Array) -> Array:
    """Correlation of each window of 30 frames, stride 1, (T - 29,); none of a series that is shorter."""
    if len(measured) < WINDOW_FRAMES:
        return np.zeros(0)
    windows = np.lib.stride_tricks.sliding_window_view(np.stack([measured, predicted]), WINDOW_FRAMES, axis=1)
    return np.array([pearson(a, b) for a, b in windows.transpose(1, 0, 2)])


def _slope_sd(residual: Array, power: float) -> float:
    """Standard deviation of a regression's slope, residuals correlated in time as a first-order process."""
    if power <= 0:
        return math.inf
    lag_one = float(np.clip(pearson(residual[1:], residual[:-1]), 0.0, 0.999))
    return math.sqrt(float(residual @ residual) / len(residual) / power * (1 + lag_one) / (1 - lag_one))


def _enough_motion(excitation: float, expected: float) -> Reason:
    limit = max(MIN_EXCITATION_RAD, MIN_EXCITATION_TO_ERROR * expected)
    if excitation >= limit:
        text = f"The badge moved enough: the optics predict a phase spread of {excitation:.2f} rad."
        return Reason("motion", "pass", excitation, limit, "rad", text)
    text = (
        f"Too little motion: the optics predict a phase spread of {excitation:.2f} rad, {limit:.2f} are needed; "
        "film again and move the badge or the camera sideways by 20 cm or more, some times."
    )
    return Reason("motion", "undecided", excitation, limit, "rad", text)


def _correlated(correlation: float, excitation: float, expected: float) -> Reason:
    """Pass from the least on; fail below what a true badge may show where poses are worse than they tell."""
    possible = min(MIN_CORRELATION, excitation / math.hypot(excitation, ERROR_UNTOLD * expected))
    level: Level = "pass" if correlation >= MIN_CORRELATION else "fail" if correlation < possible else "undecided"
    text = f"Fringe phase and prediction correlate by {correlation:.4f}; {MIN_CORRELATION} is the least allowed."
    return Reason("correlation", level, correlation, MIN_CORRELATION, "", text)


def _gain_right(gain: float, gain_sd: float) -> Reason:
    """Pass within the tolerance; fail beyond it by three error bars; between, the film cannot tell."""
    limit = GAIN_TOLERANCE + GAIN_SDS * gain_sd
    words = f"The fringes move {gain:.3f} ± {gain_sd:.3f} times as far as the optics predict"
    # A film that cannot tell a true gain from a half or twice of it says nothing, wherever its best guess lies.
    vague = gain_sd >= VAGUE_GAIN * abs(gain)
    if abs(gain - 1) <= GAIN_TOLERANCE and not vague:
        return Reason("gain", "pass", gain, GAIN_TOLERANCE, "ratio", f"{words}; 1 ± {GAIN_TOLERANCE:g} is allowed.")
    if abs(gain - 1) > limit:
        return Reason("gain", "fail", gain, limit, "ratio", f"{words}; 1 ± {limit:.2f} would be possible.")
    advice = "give the focal length with --focal-px, or film with more motion"
    return Reason("gain", "undecided", gain, limit, "ratio", f"{words}, too vague to tell from 1; {advice}.")


def _residual_explained(residual: float, excitation: float, expected: float) -> Reason:
    fixed = math.hypot(RESIDUAL_FLOOR_RAD, RESIDUAL_SHARE * excitation)
    limit, possible = math.hypot(fixed, 3 * expected), math.hypot(fixed, 3 * RESIDUAL_UNTOLD * expected)
    level: Level = "pass" if residual <= limit else "fail" if residual > possible else "undecided"
    text = (
        f"Beside what goes with the camera's place, the phase strays from the law by {residual:.3f} rad; known errors "
        f"explain up to {limit:.3f} rad."
    )
    return Reason("residual", level, residual, limit, "rad", text)


def _strips_agree(wander: float, expected: float) -> Reason:
    limit = math.hypot(MAX_STRIP_WANDER_RAD, 3 * expected)
    good = wander <= limit
    text = f"Parts of the badge move apart by at most {wander:.3f} rad; {limit:.2f} rad are allowed."
    return Reason("agreement", "pass" if good else "fail", wander, limit, "rad", text)
