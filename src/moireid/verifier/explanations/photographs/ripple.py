"""How much does the fringes' waveform change from place to place, and what does a long exposure do to it?

Two cross-faded pictures, apart by a phase d, keep (1 - w) + w exp(i h d) of harmonic h, so the third one dips nine
times as deep between two photographs as the first.  On a badge the waveform changes slowly with parallax, except for
what stays still (`third_harmonic`) and for the smear of a long exposure, which is largest on a badge that is quick in
the picture and on fine fringes.

Convention: waveform is the third harmonic in contrasts, as `StripPhase.overtone`; its *ripple* is the root mean square,
over views (`fringes.phase_coverage`), of what depends on parallax finely.  Speeds are per second, so that missing
frames change nothing.  Series (T,) or (T, N), one entry per frame.
Source: complex amplitudes of a sum of two shifted waves; regression on B-splines (Eilers and Marx 1996).  Smear: the
Fourier transform of a box of width x is 1 - x^2 / 24 + x^4 / 1920 and so on.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.photographs.fringe_spacing import in_one_turn
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic, standing_still, third_harmonic_of
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.phase_coverage import views_of
from moireid.verifier.limits import MAX_STILL_SHARE, RIPPLE_STEP_RAD
from moireid.verifier.series import cubic_bumps, standard

Array = NDArray[np.float64]


def speed2(series: Array, stretch: NDArray[np.int64], times_s: Array) -> Array:
    """Square of a series' speed, (T,), per s^2: the mean of that from the frame before and that to the one after.

    Within a stretch (`camera.stretches`); 0 for a frame that is alone in it.
    """
    joined = (np.diff(stretch) == 0) & (np.diff(times_s) > 0)
    step2 = np.where(joined, np.sum(np.diff(series, axis=0) ** 2, axis=1), 0.0)
    step2 = step2 / np.where(joined, np.diff(times_s), 1.0) ** 2
    sides = np.r_[0, joined] + np.r_[joined, 0]
    return np.asarray((np.r_[0.0, step2] + np.r_[step2, 0.0]) / np.maximum(sides, 1))


def smeared_parts(place_px: Array, stretch: NDArray[np.int64], times_s: Array) -> Array:
    """What is lost by a long exposure goes with these, (T, 2): second and fourth power of the speed, at most 1."""
    square = speed2(place_px, stretch, times_s)
    square = square / max(float(square.max(initial=0.0)), 1e-12)
    return np.column_stack([square, square**2])


Complex = NDArray[np.complex128]
#: Knots of the fine regression, at least and at most; frames for each of its unknowns.
KNOTS_RANGE, FRAMES_PER_UNKNOWN = (4, 80), 2
#: Frames that are taken at a time.
PIECE_FRAMES = 8192
#: A film with fewer frames is too short for a smooth curve of many parts.
SHORT_FRAMES = 120


class WaveformModel:
    """What a grating's waveform is regressed on: place, distance and time, other causes, and the place finely."""

    def __init__(self, signal: GratingSignal) -> None:
        beyond = signal.beyond
        assert beyond is not None
        self.used = np.isfinite(signal.phase_sd_rad)
        self.law_rad = beyond.law_rad[self.used]
        # A picture shows its phase, and keeps that where it is moved after a cut; the law's phase goes elsewhere.
        self.place_rad = in_one_turn(signal.phase_rad[self.used], signal.stretch[self.used])
        place, time = standard(self.law_rad), standard(signal.times_s[self.used])
        self._weight = views_of(self.place_rad)
        short = len(place) < SHORT_FRAMES
        columns = [np.vander(place, 4 if short else 5), time[:, None] ** np.arange(1, 2 if short else 4)]
        if signal.covariates is not None:
            near = standard(signal.covariates[self.used, 1])
            columns.append(np.column_stack([near] if short else [near, near * place, near**2]))
        self._phase_rad, self._expected = signal.phase_rad[self.used], beyond.expected[self.used]
        # From the side a sheet is out of focus, by its own law.
        columns.append(np.column_stack([standard(part) for part in (self._expected.real, self._expected.imag)]))
        self._smeared = smeared_parts(beyond.place_px, signal.stretch, signal.times_s)[self.used]
        weigh = np.sqrt(self._weight)[:, None]
        self._smooth = np.linalg.qr(weigh * np.column_stack(columns))[0]
        most = len(self.law_rad) / FRAMES_PER_UNKNOWN - self._smooth.shape[1] - 3
        knots = int(np.clip(min(np.ptp(self.law_rad) / RIPPLE_STEP_RAD, most), *KNOTS_RANGE))
        bumps = cubic_bumps(self.law_rad, knots)
        # An hour has 200,000 frames, so nothing else has that many rows: the bumps are changed where they are.
        bumps *= weigh
        pieces = [slice(k, k + PIECE_FRAMES) for k in range(0, len(bumps), PIECE_FRAMES)]
        along = self._smooth.T @ bumps
        for piece in pieces:
            bumps[piece] -= self._smooth[piece] @ along
        squares, turned = np.linalg.eigh(bumps.T @ bumps)
        kept = squares > 1e-12 * squares.max(initial=1e-24)
        for piece in pieces:
            bumps[piece, : kept.sum()] = bumps[piece] @ (turned[:, kept] / np.sqrt(squares[kept]))
        self._fine = bumps[:, : kept.sum()]
        # Frames have alike noise, so noise of weight w is in what is fitted by the trace of the hat times w.
        self._spread = self._fine.T @ (self._weight[:, None] * self._fine)
        smooth = float(np.einsum("ij,ij,i->", self._smooth, self._smooth, self._weight))
        self._left = float(self._weight.sum()) - smooth - float(np.trace(self._spread))

    @property
    def enough(self) -> bool:
        """Whether there are frames enough."""
        return bool(len(self.law_rad) >= FRAMES_PER_UNKNOWN * (self._smooth.shape[1] + self._fine.shape[1]))

    def third_harmonic(self, overtone: Complex) -> ThirdHarmonic:
        """What of the waveform turns with the fringes."""
        return third_harmonic_of(overtone, self._phase_rad, self._weight, self._expected)

    def _without_other_causes(self, overtone: Complex) -> Complex:
        """The waveform without what stays still on the badge, and as it was before a long exposure smeared it."""
        own = self.third_harmonic(overtone).size
        most = MAX_STILL_SHARE * abs(own)
        seen = overtone - standing_still(overtone, self._phase_rad, self._weight, self._smooth, most)
        # A shutter that is open for long makes a harmonic weaker, and turns it nowhere.
        weigh = np.sqrt(self._weight)
        along = weigh * (seen * np.conj(own)).real / max(abs(own) ** 2, 1e-30)
        parts = weigh[:, None] * self._smeared
        along, parts = (series - self._smooth @ (self._smooth.T @ series) for series in (along, parts))
        share, *_ = np.linalg.lstsq(parts, along, rcond=1e-6)
        return np.asarray(seen - own * np.clip(self._smeared @ share, -1.0, 0.0))

    def ripple2(self, overtone: Complex) -> tuple[float, float]:
        """Square of the ripple over views, not frames, which rests would thin out; and its standard deviation.

        Source: analysis of variance with weights; noise that lasts over frames counts by its correlation with the frame
            before.
        """
        overtone = self._without_other_causes(overtone)
        square = variance = 0.0
        views = float(self._weight.sum())
        for part in (overtone.real, overtone.imag):
            rough = np.sqrt(self._weight) * part
            rough -= self._smooth @ (self._smooth.T @ rough)
            along = self._fine.T @ rough
            left = rough - self._fine @ along
            noise = float(left @ left) / self._left
            lasting = float(np.clip(left[1:] @ left[:-1] / max(float(left @ left), 1e-30), 0.0, 0.9))
            noise *= (1 + lasting) / (1 - lasting)
            square += (float(along @ along) - float(np.trace(self._spread)) * noise) / views
            variance += 2 * float(np.sum(self._spread**2)) * (noise / views) ** 2
        return square, math.sqrt(variance)
