"""Does the spacing of the fringes follow the distance?

Nearer to the camera the fringes are closer together (`fringes.beyond_phase`).  Photographs from one distance that are
placed over a film keep their spacing.  A zoom within a film changes it too, so it rejects no film; where a zoom is
seen, its error counts.

`cross_faded` gives what photographs of a badge show that were taken at some places.

Convention: the gain is the change seen over that predicted: 1 on a badge, 0 on photographs.  A place is a fringe phase,
rad, with whole turns taken out, as a picture shows the same fringes a turn on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits
from moireid.verifier.fringes.grating_signal import GratingSignal

#: Independent times below which the scatter of the spacing means nothing.
LEAST_PIECES = 2.0


@dataclass(frozen=True)
class Spacing:
    """Change of the fringes' spacing with distance, seen over predicted (1 on a badge), and its standard deviation.

    pieces: independent times that the standard deviation is of.
    """

    gain: float
    sd: float
    pieces: float = math.inf

    @property
    def tested(self) -> bool:
        """Whether the distance changed enough to distinguish a badge from photographs."""
        return limits.PHOTOGRAPH_SDS * self.sd <= 1.0

    @property
    def few(self) -> float:
        """By how much more the gain scatters by chance, as its deviation is itself of few independent times."""
        if self.pieces <= LEAST_PIECES or math.isinf(self.pieces):
            return 1.0 if math.isinf(self.pieces) else math.inf
        # SciPy takes longer to load than a short film to verify, and few films need this.
        from scipy.special import ndtr, stdtrit

        student = float(stdtrit(self.pieces - 1, ndtr(limits.PHOTOGRAPH_SDS)))
        return student / limits.PHOTOGRAPH_SDS * math.sqrt(self.pieces / (self.pieces - 1))

    @property
    def wrong(self) -> bool:
        """Whether it contradicts a badge.

        Photographs give too small a gain, so the limit is strict there.  Too great a gain comes from chance or from a
        zoom, so a short film has more room there.
        """
        error, sds = abs(self.gain - 1), limits.PHOTOGRAPH_SDS * self.sd
        return error > max(limits.MAX_SPACING_ERROR_RATIO, sds) and (self.gain < 1 or error > self.few * sds)


def spacing_of(signals: Sequence[GratingSignal]) -> Spacing | None:
    """The spacing's gain, of all gratings together; None if the distance does not change at all.

    Source: the error bar is the scatter of sums over times that a hand's motion makes independent
        (`INDEPENDENT_PER_S`), and `SPACING_FLOOR_RAD`.  A short film has few such times: `PHOTOGRAPH_SDS` of Student's
        t are exceeded as seldom as those of a normal distribution.
    """
    depths = [signal.beyond.depth for signal in signals if signal.beyond is not None]
    if not depths:
        return None
    score, information = (sum(getattr(depth, name) for depth in depths) for name in ("score", "information"))
    whole = float(np.sum(information))
    if not whole > 0:
        return None
    error = float(np.sum(score)) / whole
    # Numbered anew, as a film's times may leave out a thousand years, and sums take memory for each number.
    times = signals[0].times_s
    _, piece = np.unique(np.floor((times - times[0]) * limits.INDEPENDENT_PER_S), return_inverse=True)
    by_piece = np.bincount(piece, weights=information)
    # Times without information do not count.
    pieces = whole**2 / float(np.sum(by_piece**2))
    scatter = math.sqrt(float(np.sum(np.bincount(piece, weights=score - error * information) ** 2))) / whole
    change = math.sqrt(float(sum(np.sum(depth.power) for depth in depths)) / whole)
    floor = limits.SPACING_FLOOR_RAD / max(change, 1e-12)
    return Spacing(1 + error, math.hypot(scatter, floor, max(_by_zoom(signal) for signal in signals)), pieces)


def _by_zoom(signal: GratingSignal) -> float:
    """Standard deviation of the gain by errors of a zoom within the film, from which the distance then follows.

    Source: errors in the regressor: that of one over the distance, over its own spread.
    """
    if signal.zoom <= 1:
        return 0.0
    if signal.covariates is None:
        return math.inf
    near = signal.covariates[np.isfinite(signal.phase_sd_rad), 1]
    # A steady motion over a range has a standard deviation of the range over sqrt(12).
    zoom = limits.ZOOM_ERROR_SHARE * math.log(signal.zoom) / math.sqrt(12)
    return zoom * float(np.mean(near)) / max(float(np.std(near)), 1e-12) if len(near) else math.inf


Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def in_one_turn(phase_rad: Array, stretch: NDArray[np.int64]) -> Array:
    """Phases (T,), each stretch moved by whole turns so that its mean is nearest to that of the longest one.

    Convention: a picture shows the same fringes a whole turn on, so a stretch that was read so shows no other pictures.
    """
    _, own = np.unique(stretch, return_inverse=True)
    frames = np.bincount(own)
    means = np.bincount(own, weights=phase_rad) / frames
    return np.asarray(phase_rad - 2 * np.pi * np.round((means - means[np.argmax(frames)]) / (2 * np.pi))[own])


def cross_faded(place_rad: Array, nodes: Array) -> tuple[Complex, Complex]:
    """First and third harmonic, each (T,), of 1 at best, of photographs cross-faded for phases (T,).

    Parameters: nodes (N,): phases at which they were taken, rising.
    """
    place = np.interp(place_rad, nodes, np.arange(len(nodes)))
    before = np.minimum(place.astype(int), len(nodes) - 2)
    share = place - before
    first, third = (
        (1 - share) * np.exp(1j * h * nodes[before]) + share * np.exp(1j * h * nodes[before + 1]) for h in (1, 3)
    )
    return first, third
