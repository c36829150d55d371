"""What a handful of photographs cannot show: could this film be a table of pictures, indexed by parallax?

The picture of a badge with one axis depends on one parallax, and weakly on distance.  So a forger with some photographs
can lay the fitting one over each frame, or cross-fade two.  Two things give that away:

- *spacing*: the fringes stand closer where the camera is nearer (`fringes.depth_law`);
- *waveform*: two cross-faded pictures, apart by a phase d, keep (1 - w) + w exp(i h d) of harmonic h, so the third one
  dips nine times as deep between two photographs as the first.  On a badge the waveform changes slowly with parallax.

A zoom within the film, or a shadow that moves, can do the same to a true badge, so neither rejects a film.

Convention: waveform is the third harmonic in contrasts, as `StripPhase.overtone`; its *ripple* is the root mean square,
over views (`fringes.seen_way`), of what depends on parallax finely.
Source: complex amplitudes of a sum of two shifted waves; regression on B-splines (Eilers and Marx 1996).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.fringes.seen_way import views_of
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import (
    INDEPENDENT_PER_S,
    LEAST_STILLS,
    MAX_RESTING_SHARE,
    MAX_RIPPLE_CONTRASTS,
    MAX_SPACING_ERROR_RATIO,
    PHOTOGRAPH_SDS,
    REST_RAD,
    RESTING_STILLS,
    RIPPLE_LEFT_SHARE,
    RIPPLE_STEP_RAD,
    SPACING_FLOOR_RAD,
)
from moireid.verifier.reasons import Level, Reason
from moireid.verifier.splines import cubic_bumps

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Passes = Callable[[GratingSignal], bool]
#: Knots of the fine regression, at least and at most; frames for each of its unknowns.
KNOTS_RANGE, FRAMES_PER_UNKNOWN = (4, 80), 2
#: Frames that are taken at a time.
PIECE_FRAMES = 8192
#: A film with fewer frames is too short for a smooth course of many parts.
SHORT_FRAMES = 120
#: Independent times below which the scatter of the spacing says nothing.
LEAST_PIECES = 2.0
#: More photographs than this are not counted.
MOST_PHOTOGRAPHS = 100
#: Steps towards the places that are seen most, and by how much a place must move to be worth another.
LLOYD_STEPS, NEAR_RAD = 50, 1e-6


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
        """Whether the distance changed enough to tell a badge from photographs."""
        return PHOTOGRAPH_SDS * self.sd <= 1.0

    @property
    def few(self) -> float:
        """By how much more the gain scatters by chance, as its deviation is itself of few independent times."""
        if self.pieces <= LEAST_PIECES or math.isinf(self.pieces):
            return 1.0 if math.isinf(self.pieces) else math.inf
        # SciPy takes longer to load than a short film to verify, and few films need this.
        from scipy.special import ndtr, stdtrit

        student = float(stdtrit(self.pieces - 1, ndtr(PHOTOGRAPH_SDS)))
        return student / PHOTOGRAPH_SDS * math.sqrt(self.pieces / (self.pieces - 1))

    @property
    def of_pictures(self) -> float:
        """How much less likely the gain is where the spacing stays than on a badge, at most 1.

        Source: ratio of two normal densities, about 0 and about 1.
        """
        return math.exp(-max(0.0, (self.gain**2 - (self.gain - 1) ** 2) / 2 / self.sd**2))

    @property
    def wrong(self) -> bool:
        """Whether it contradicts a badge.

        Photographs give too small a gain, so the limit is strict there.  Too great a gain comes from chance or from a
        zoom, so a short film has more room there.
        """
        error, sds = abs(self.gain - 1), PHOTOGRAPH_SDS * self.sd
        return error > max(MAX_SPACING_ERROR_RATIO, sds) and (self.gain < 1 or error > self.few * sds)


def no_photographs(signals: Sequence[GratingSignal], moved: Sequence[GratingSignal], passes: Passes) -> list[Reason]:
    """The findings on spacing and waveform, and how many photographs would make such a film.

    Parameters: moved: those of the signals that moved enough; passes: whether a signal would pass all else.
    Source: module docstring.
    """
    spacing = spacing_of(signals)
    waveforms = [found for found in (waveform_of(signal, passes) for signal in moved) if found is not None]
    reasons = [] if spacing is None else [_spaced(spacing)]
    if not waveforms:
        return reasons
    worst = max(waveforms, key=lambda found: found.ripple / found.limit)
    most = max(waveforms, key=lambda found: (found.stills, found.photographs))
    return [
        *reasons,
        _even(worst),
        _needed(most, from_two=spacing is not None and spacing.tested and not spacing.wrong),
    ]


def _spaced(spacing: Spacing) -> Reason:
    level: Level = "undecided" if spacing.wrong else "pass" if spacing.tested else "note"
    seen = "As the badge comes nearer or goes away, the spacing of its fringes"
    text = {
        "undecided": f"{seen} does not follow, as on photographs laid over a film, or under a zoom. Film without zoom.",
        "pass": f"{seen} follows, which that of photographs from one distance does not.",
        "note": "The distance hardly changed, so the film does not show whether the fringes' spacing follows it.",
    }[level]
    gain = None if level == "note" else spacing.gain
    return Reason("spacing", level, gain, MAX_SPACING_ERROR_RATIO, "ratio", text)


def _even(waveform: Waveform) -> Reason:
    level: Level = "pass" if waveform.ripple <= waveform.limit else "undecided"
    text = "The fringes keep their shape from place to place."
    if level == "undecided":
        text = "The fringes change their shape from place to place, as between cross-faded photographs. "
        text += "Film in even light."
    return Reason("waveform", level, waveform.ripple, waveform.limit, "contrasts", text)


def _needed(found: Waveform, *, from_two: bool) -> Reason:
    count = found.photographs
    least_stills = RESTING_STILLS if found.rests else LEAST_STILLS
    if found.stills < least_stills:
        text = f"The film hardly shows more than {found.stills} pictures of the badge, over and over. "
        text += "Keep the badge moving."
        return Reason("photographs", "undecided", float(found.stills), float(least_stills), "photographs", text)
    least = f"at least {count}" if count < MOST_PHOTOGRAPHS else f"more than {count}"
    text = f"To fake this film with unchanged photographs of the badge, a forger would need {least} along its course"
    # One from another distance may be all that the spacing asks for, so it adds nothing to the count.
    text += ", and some from another distance." if from_two else "."
    return Reason("photographs", "note", float(count), None, "photographs", text)


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
    _, piece = np.unique(np.floor((times - times[0]) * INDEPENDENT_PER_S), return_inverse=True)
    told = np.bincount(piece, weights=information)
    # Times that tell nothing do not count.
    pieces = whole**2 / float(np.sum(told**2))
    scatter = math.sqrt(float(np.sum(np.bincount(piece, weights=score - error * information) ** 2))) / whole
    change = math.sqrt(float(sum(np.sum(depth.power) for depth in depths)) / whole)
    return Spacing(1 + error, math.hypot(scatter, SPACING_FLOOR_RAD / max(change, 1e-12)), pieces)


class Course:
    """What a grating's waveform is regressed on: place, distance and time, and the place finely."""

    def __init__(self, signal: GratingSignal) -> None:
        beyond = signal.beyond
        assert beyond is not None
        self.used = np.isfinite(signal.phase_sd_rad)
        self.law_rad = beyond.law_rad[self.used]
        # A picture shows its phase, and keeps that where it is moved after a cut; the law's phase goes elsewhere.
        self.place_rad = in_one_turn(signal.phase_rad[self.used], signal.stretch[self.used])
        place, time = _standard(self.law_rad), _standard(signal.times_s[self.used])
        self._weight = views_of(self.place_rad)
        short = len(place) < SHORT_FRAMES
        columns = [np.vander(place, 4 if short else 5), time[:, None] ** np.arange(1, 2 if short else 4)]
        if signal.covariates is not None:
            near = _standard(signal.covariates[self.used, 1])
            columns.append(np.column_stack([near] if short else [near, near * place, near**2]))
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
    def told(self) -> bool:
        """Whether there are frames enough."""
        return bool(len(self.law_rad) >= FRAMES_PER_UNKNOWN * (self._smooth.shape[1] + self._fine.shape[1]))

    def ripple2(self, overtone: Complex) -> tuple[float, float]:
        """Square of the ripple over views, not frames, which rests would thin out; and its standard deviation.

        Source: analysis of variance with weights; noise that lasts over frames counts by its correlation with the frame
            before.
        """
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


@dataclass(frozen=True)
class Waveform:
    """Ripple of the waveform and what is allowed, contrasts; and how many photographs would stay below that.

    photographs: cross-faded, and right in phase by the law; evenly spaced over what the fringes pass, or where they are
    seen most, whichever takes fewer; stills: where they are seen most;
    rests: whether nearly all frames show `LEAST_STILLS` places.
    """

    ripple: float
    limit: float
    photographs: int
    stills: int
    rests: bool


def waveform_of(signal: GratingSignal, passes: Passes) -> Waveform | None:
    """The waveform over a grating's course; None where it cannot be told.

    Parameters: passes: whether a signal would pass all else.
    """
    if signal.beyond is None or np.isfinite(signal.phase_sd_rad).sum() < 10:
        return None
    course = Course(signal)
    if not course.told:
        return None
    seen = signal.beyond.overtone[course.used]
    square, sd = course.ripple2(seen)
    limit = math.hypot(MAX_RIPPLE_CONTRASTS, math.sqrt(PHOTOGRAPH_SDS * sd))
    typical = float(np.median(np.abs(seen)))
    # If even the law itself would not pass with this film's other faults, the phase tells no photographs apart.
    judge = passes if passes(replace(signal, measured_rad=signal.predicted_rad)) else _any_passes

    def hidden(nodes: Array) -> bool:
        return _hidden(nodes, signal, course, typical, limit, judge)

    counts = [
        next((n for n in range(2, MOST_PHOTOGRAPHS) if hidden(taken(n, course.place_rad))), MOST_PHOTOGRAPHS)
        for taken in (evenly, seen_most)
    ]
    return Waveform(math.sqrt(max(square, 0.0)), limit, min(counts), counts[1], rests(course.place_rad))


def _any_passes(_: GratingSignal) -> bool:
    return True


def _hidden(nodes: Array, signal: GratingSignal, course: Course, typical: float, limit: float, passes: Passes) -> bool:
    """Whether photographs taken at these places, cross-faded along this film's own course, would stay unseen."""
    first, third = cross_faded(course.place_rad, nodes)
    size = np.maximum(np.abs(first), 1e-9)
    square, _ = course.ripple2(typical * third * (np.conj(first) / size) ** 3 / size)
    if RIPPLE_LEFT_SHARE * math.sqrt(max(square, 0.0)) > limit:
        return False
    late = np.zeros(len(signal.measured_rad))
    late[course.used] = np.angle(first * np.exp(-1j * course.place_rad))
    shown = within_stretches(signal.predicted_rad + late, signal.stretch)
    return passes(replace(signal, measured_rad=shown))


def evenly(count: int, place_rad: Array) -> Array:
    """So many places, (count,), at even distances over all that are seen."""
    return np.linspace(place_rad.min(), place_rad.max(), count)


def seen_most(count: int, place_rad: Array) -> Array:
    """So many places, (count,), rising, that are nearest to those seen: where a forger would take photographs.

    Source: Lloyd (1982), on a line, from even shares of the frames; stops short of the best where it takes long.
    """
    place = np.sort(place_rad)
    before = np.r_[0.0, np.cumsum(place)]
    nodes = np.quantile(place, (np.arange(count) + 0.5) / count)
    for _ in range(LLOYD_STEPS):
        ends = np.r_[0, np.searchsorted(place, (nodes[1:] + nodes[:-1]) / 2), len(place)]
        frames = np.diff(ends)
        means = np.diff(before[ends]) / np.maximum(frames, 1)
        moved = np.where(frames > 0, means, nodes)
        if np.abs(moved - nodes).max() < NEAR_RAD:
            break
        nodes = moved
    # Two at one place would leave nothing to cross-fade between.
    return np.asarray(nodes + NEAR_RAD * np.arange(count))


def rests(place_rad: Array) -> bool:
    """Whether few places, as wide as two `REST_RAD`, hold nearly all frames, (T,): the fullest first."""
    left = np.sort(place_rad)
    for _ in range(LEAST_STILLS):
        held = np.searchsorted(left, left + 2 * REST_RAD, "right") - np.arange(len(left))
        first = int(np.argmax(held))
        left = np.delete(left, np.s_[first : first + held[first]])
        if len(left) < (1 - MAX_RESTING_SHARE) * len(place_rad):
            return True
    return False


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


def _standard(series: Array) -> Array:
    return np.asarray((series - series.mean()) / max(float(series.std()), 1e-12))
