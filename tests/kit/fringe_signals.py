"""Phase signals of one grating without pictures: the law's phase, the measured one, and their errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.explanations.honest import PhaseSeries, phase_series
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal

#: Frames a second, and frames of a usual signal.
FPS, FRAMES = 30.0, 300
#: Error bars of a clear film, rad.
PHASE_SD, POSE_SD = 0.02, 0.01


def clock(frames: int = FRAMES) -> np.ndarray:
    """Times of so many frames, s."""
    return np.arange(frames) / FPS


def trajectory(seed: int = 1, frames: int = FRAMES, *, late_s: float = 0.0) -> np.ndarray:
    """A hand's motion: smooth, and varied from 0.2 to 1.1 Hz; mean 0 and standard deviation 1, where it is not late."""
    rng = np.random.default_rng(seed)
    hertz, phase = rng.uniform(0.2, 1.1, 4), rng.uniform(0, 6, 4)

    def wave(times_s: np.ndarray) -> np.ndarray:
        return np.sin(2 * np.pi * np.outer(times_s, hertz) + phase).sum(axis=1)

    usual = wave(clock(frames))
    return (wave(clock(frames) - late_s) - usual.mean()) / usual.std()


def apart_from(law: np.ndarray, seed: int = 9) -> np.ndarray:
    """Another trajectory of standard deviation 1, whose correlation with the law is 0."""
    other = trajectory(seed, len(law))
    other = other - law * (other @ law) / (law @ law)
    other -= other.mean()
    return other / other.std()


def lasting_noise(frames: int = FRAMES, size: float = 0.01, seed: int = 4, lasting: float = 0.6) -> np.ndarray:
    """A first-order autoregressive series of standard deviation `size`, with this correlation of neighbours."""
    drawn = np.random.default_rng(seed).standard_normal(frames)
    noise = drawn.copy()
    for k in range(1, frames):
        noise[k] = lasting * noise[k - 1] + math.sqrt(1 - lasting**2) * drawn[k]
    return size * noise


def fringe_signal(
    law: np.ndarray,
    measured: np.ndarray,
    *,
    times_s: np.ndarray | None = None,
    stretch: np.ndarray | None = None,
    phase_sd: float | np.ndarray = PHASE_SD,
    pose_sd: float = POSE_SD,
    rows_rad: float = 0.01,
    places_rad: float = 0.02,
    place_px: np.ndarray | None = None,
    **others: Any,
) -> GratingSignal:
    """One grating's signal; place_px (T, 2): of the badge in the picture; others: fields of `GratingSignal`."""
    count = len(law)
    stretch = np.zeros(count, np.int64) if stretch is None else stretch
    if place_px is not None:
        none = np.zeros(count)
        others["beyond"] = BeyondPhase(law, DepthLaw(none, none, none), none.astype(complex), place_px, none + 1.0 + 0j)
    return GratingSignal(
        within_stretches(np.asarray(measured, float), stretch),
        within_stretches(np.asarray(law, float), stretch),
        np.full(count, phase_sd) if np.isscalar(phase_sd) else np.asarray(phase_sd),
        pose_sd,
        np.array([0.5 * rows_rad, rows_rad]),
        clock(count) if times_s is None else times_s,
        np.array([places_rad, places_rad]),
        stretch=stretch,
        **others,
    )


def series_of(law: np.ndarray, measured: np.ndarray | None = None, **how: Any) -> PhaseSeries:
    """The series of a signal; what is measured is the law's phase unless it is given."""
    series = phase_series(fringe_signal(law, law if measured is None else measured, **how))
    assert series is not None
    return series
