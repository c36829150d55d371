"""Does the waveform change from place to place as that of a few cross-faded photographs does?

Two cross-faded pictures, apart by a phase d, keep (1 - w) + w exp(i h d) of harmonic h.  So on its way from one to the
other the third harmonic sinks and lags, by some 4.5 d^2 of itself where d is small, and comes back.  On a badge it
hardly changes within a fringe.  Few photographs bend the waveform over the whole way, which a smooth curve takes for a
lens out of focus; so what they do is looked for by its own form.

A long exposure makes it sink too, where the badge is quick: by (3 turn)^2 / 24 if it lasts as long as a frame.  So what
goes with the square of the badge's speed in the picture is left out, and what the fringes' own speed may do is allowed.

Convention: the *share* is how much of that form a film shows: 0 on a badge, 1 on photographs.
Source: complex amplitudes of a sum of two shifted waves; regression over views, each of one weight.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.photographs.fringe_spacing import cross_faded, in_one_turn
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MAX_CROSS_FADE_SHARE, PHOTOGRAPH_SDS, REST_RAD, UNEVEN_SHARE
from moireid.verifier.series import standard

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Photographs that are looked for, at most, and places between the outermost at which they may have been taken.
MOST_LOOKED_FOR, PLACES = 4, 12
#: Frames below which there is no result, and views below which all may be photographs.
LEAST_FRAMES, LEAST_VIEWS = 10, 8
#: A form of which there is more than this much is not what was filmed: photographs show about 1.
MOST_SHARE = 2.0
#: Share of the views that show less than a whole photograph does.
WHOLE_SHARE = 0.9


@dataclass(frozen=True)
class CrossFade:
    """The share of the form of so many photographs, and its part that nothing else explains."""

    photographs: int
    share: float
    certain: float

    @property
    def seen(self) -> bool:
        """Whether the film shows photographs, and not a badge."""
        return self.certain > MAX_CROSS_FADE_SHARE


def cross_fade_of(signal: GratingSignal) -> CrossFade | None:
    """The form of few photographs that a grating's waveform shows most surely; None where it is not known."""
    used = np.isfinite(signal.phase_sd_rad)
    if signal.beyond is None or used.sum() < LEAST_FRAMES:
        return None
    place = in_one_turn(signal.phase_rad[used], signal.stretch[used])
    # A view is a step of place, however long it is seen.
    _, view = np.unique(np.floor((place - place.min()) / REST_RAD), return_inverse=True)
    frames = np.bincount(view)

    def seen(series: Array) -> Array:
        return np.bincount(view, weights=series) / frames

    times, stretch = signal.times_s, signal.stretch
    smooth = [place, times[used], speed2(signal.beyond.place_px, stretch, times)[used]]
    if signal.covariates is not None:
        smooth.append(signal.covariates[used, 1])
    columns = np.column_stack([np.ones(len(frames)), *(standard(seen(series)) for series in smooth)])
    if len(frames) < max(LEAST_VIEWS, 2 * columns.shape[1]):
        # So few views are so many photographs.
        return CrossFade(len(frames), 1.0, 1.0)
    kept = np.linalg.qr(columns)[0]

    def bent(series: Complex) -> Complex:
        return np.asarray(series - kept @ (kept.T @ series))

    overtone = signal.beyond.overtone[used]
    shown = seen(overtone.real) + 1j * seen(overtone.imag)
    # Between photographs it sinks, so what a photograph shows is nearer to the most than to the mean.
    mean = complex(shown.mean())
    typical = mean * float(np.quantile(np.abs(shown), WHOLE_SHARE)) / max(abs(mean), 1e-30)
    frame_s = float(np.median(np.diff(times)))
    turn2 = speed2(signal.phase_rad[:, None], stretch, times)[used] * frame_s**2
    lost = np.minimum(9 * turn2 / 24, 1.0) + signal.mixed_share * (1 - np.cos(3 * np.sqrt(turn2)))
    # Noise lasts over frames, so a view is seen anew only where the fringes come back to it.
    passed = np.bincount(view, weights=np.diff(view, prepend=-1) != 0)
    scattered = float(np.mean(seen(np.abs(overtone - shown[view]) ** 2) / 2 / passed))
    known = _ViewTable(bent(shown), bent(-typical * seen(lost).astype(complex)), scattered, UNEVEN_SHARE * abs(typical))
    found = (CrossFade(number, *known.shares(bent(typical * form))) for number, form in _forms(seen(place)))
    return max(found, key=lambda one: one.certain)


def speed2(series: Array, stretch: NDArray[np.int64], times_s: Array) -> Array:
    """Square of a series' speed, (T,), per s^2: the mean of that from the frame before and that to the one after.

    Within a stretch (`camera.stretches`); 0 for a frame that is alone in it.
    """
    joined = (np.diff(stretch) == 0) & (np.diff(times_s) > 0)
    step2 = np.where(joined, np.sum(np.diff(series, axis=0) ** 2, axis=1), 0.0)
    step2 = step2 / np.where(joined, np.diff(times_s), 1.0) ** 2
    sides = np.r_[0, joined] + np.r_[joined, 0]
    return np.asarray((np.r_[0.0, step2] + np.r_[step2, 0.0]) / np.maximum(sides, 1))


@dataclass(frozen=True)
class _ViewTable:
    """What views show, (V,); what a long exposure would add to it; variance of a part of it by noise, and by how much a
    badge's waveform changes by itself."""

    shown: Complex
    by_camera: Complex
    scattered: float
    uneven: float

    def shares(self, form: Complex) -> tuple[float, float]:
        """The share of a form (V,) in what is shown, and what of it is certain."""
        power = float(np.vdot(form, form).real)
        if power <= 0:
            return 0.0, -math.inf
        share, blurred = (float(np.vdot(form, series).real) / power for series in (self.shown, self.by_camera))
        if share > MOST_SHARE:
            return share, -math.inf
        left = self.shown - share * form
        rest = float(np.vdot(left, left).real)
        lasting = float(np.clip(np.vdot(left[:-1], left[1:]).real / max(rest, 1e-30), 0.0, 0.9))
        noise = max(rest / 2 / len(left) * (1 + lasting) / (1 - lasting), self.scattered)
        # A badge's own waveform may change by the form, at worst.
        uneven = self.uneven * math.sqrt(len(left) / power)
        sd = math.sqrt(noise / power)
        return share, share - max(blurred, 0.0) - PHOTOGRAPH_SDS * sd - uneven


def _forms(place_rad: Array) -> Iterator[tuple[int, Complex]]:
    """Numbers of photographs, and what these keep of the third harmonic if taken anywhere between the outermost."""
    between = np.linspace(place_rad.min(), place_rad.max(), PLACES + 2)
    for number in range(2, MOST_LOOKED_FOR + 1):
        for inner in itertools.combinations(between[1:-1], number - 2):
            first, third = cross_faded(place_rad, np.array([between[0], *inner, between[-1]]))
            size = np.maximum(np.abs(first), 1e-9)
            yield number, third * (np.conj(first) / size) ** 3 / size
