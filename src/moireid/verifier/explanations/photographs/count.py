"""What a handful of photographs cannot show: could this film be a table of pictures, indexed by parallax?

The picture of a badge with one axis depends on one parallax, and weakly on distance.  So a forger with some photographs
can lay the fitting one over each frame, or cross-fade two.  That gives it away: the fringes' `spacing`, which keeps to
the distance of the photographs, and their waveform, which changes between two of them: by its `ripple` where they are
many, by the form of their `cross_fade` where they are few.  Where all are laid over each other, their third harmonic is
not `turning` with the fringes.

A zoom within the film, or a shadow that moves, can do the same to a true badge, so neither rejects a film.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.explanations.photographs.cross_fade import CrossFade, cross_fade_of
from moireid.verifier.explanations.photographs.photo_sampling import cross_faded, evenly, seen_most
from moireid.verifier.explanations.photographs.ripple import Course
from moireid.verifier.explanations.photographs.spacing import spacing_finding, spacing_of
from moireid.verifier.explanations.photographs.third_harmonic import Turning, turning_findings
from moireid.verifier.explanations.residuals import residual_limit_rad
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import MAX_CROSS_FADE_SHARE, MAX_RIPPLE_CONTRASTS, PHOTOGRAPH_SDS, RIPPLE_LEFT_SHARE
from moireid.verifier.reasons import Level, Reason

Array = NDArray[np.float64]
#: Whether a grating's phase (T,) would be taken for the law's.
Passes = Callable[[Array], bool]
#: More photographs than this are not counted.
MOST_PHOTOGRAPHS = 100


def no_photographs(signals: Sequence[GratingSignal], moved: Sequence[GratingSignal]) -> list[Reason]:
    """The findings on spacing and waveform, and how many photographs would make such a film.

    Parameters: moved: those of the signals that moved enough.
    Source: module docstring.
    """
    spacing = spacing_of(signals)
    waveforms = [found for found in (waveform_of(signal) for signal in moved) if found is not None]
    reasons = [] if spacing is None else [spacing_finding(spacing)]
    reasons += _cross_faded([found for signal in moved if (found := cross_fade_of(signal)) is not None])
    if not waveforms:
        return reasons
    count = max(found.photographs for found in waveforms)
    return [
        *reasons,
        _even(max(waveforms, key=lambda found: found.ripple / found.limit)),
        *turning_findings([found.turning for found in waveforms if found.turning is not None]),
        _needed(count, from_two=spacing is not None and spacing.tested and not spacing.wrong),
    ]


def _even(waveform: Waveform) -> Reason:
    level: Level = "pass" if waveform.ripple <= waveform.limit else "undecided"
    text = "The fringes keep their shape from place to place."
    if level == "undecided":
        text = "The fringes change their shape from place to place, as between cross-faded photographs. "
        text += "Film in even light."
    return Reason("waveform", level, waveform.ripple, waveform.limit, "contrasts", text)


def _cross_faded(found: Sequence[CrossFade]) -> list[Reason]:
    if not found:
        return []
    worst = max(found, key=lambda one: one.certain)
    level: Level = "undecided" if worst.seen else "pass"
    text = "The fringes keep their shape all along their way."
    if worst.seen:
        text = f"The fringes change their shape as those of {worst.photographs} photographs do that are shown in turn, "
        text += "or one faded into the other. Film in even light, and keep the badge moving."
    return [Reason("cross_fade", level, worst.certain, MAX_CROSS_FADE_SHARE, "share", text)]


def _needed(count: int, *, from_two: bool) -> Reason:
    least = f"at least {count}" if count < MOST_PHOTOGRAPHS else f"more than {count}"
    text = f"To fake this film by cross-fading photographs of the badge, a forger would need {least} along its course"
    # One from another distance may be all that the spacing asks for, so it adds nothing to the count.
    text += ", and some from another distance." if from_two else "."
    return Reason("photographs", "note", float(count), None, "photographs", text)


@dataclass(frozen=True)
class Waveform:
    """Ripple of the waveform and what is allowed, contrasts; how many photographs would stay below that; and what turns
    with the fringes, None for fringes so long that no third harmonic is looked for.

    photographs: cross-faded, and right in phase by the law; evenly spaced over what the fringes pass, or where they are
    seen most, whichever takes fewer.
    """

    ripple: float
    limit: float
    photographs: int
    turning: Turning | None


def waveform_of(signal: GratingSignal) -> Waveform | None:
    """The waveform over a grating's path; None where there is too little of it."""
    if signal.beyond is None or np.isfinite(signal.phase_sd_rad).sum() < 10:
        return None
    course = Course(signal)
    if not course.told:
        return None
    seen = signal.beyond.overtone[course.used]
    square, sd = course.ripple2(seen)
    limit = math.hypot(MAX_RIPPLE_CONTRASTS, math.sqrt(PHOTOGRAPH_SDS * sd))
    typical = float(np.median(np.abs(seen)))
    passes = _law_like(signal)

    def hidden(nodes: Array) -> bool:
        return _hidden(nodes, signal, course, typical, limit, passes)

    counts = [
        next((n for n in range(2, MOST_PHOTOGRAPHS) if hidden(taken(n, course.place_rad))), MOST_PHOTOGRAPHS)
        for taken in (evenly, seen_most)
    ]
    return Waveform(math.sqrt(max(square, 0.0)), limit, min(counts), course.turning(seen) if seen.any() else None)


def _law_like(signal: GratingSignal) -> Passes:
    """Whether a phase is as near to the law as an honest film's is."""
    used = np.isfinite(signal.phase_sd_rad)
    law = signal.predicted_rad[used]
    excitation, error = float(law.std()), float(np.median(signal.phase_sd_rad[used]))
    limit = residual_limit_rad(excitation, math.hypot(error, signal.pose_sd_rad))
    return lambda phase: float((phase[used] - law).std()) <= limit


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
    return passes(shown)
