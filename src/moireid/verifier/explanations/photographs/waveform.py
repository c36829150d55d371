"""The waveform of a grating's fringes, and how many cross-faded photographs would show it as even as the film does.

A forger can place the fitting one of some photographs over each frame, or cross-fade two.  Their waveform then changes
between two of them, by its `ripple`; the more photographs, the less.

Convention: contrasts, as in `ripple`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.explanations.photographs.fringe_spacing import cross_faded, evenly, seen_most
from moireid.verifier.explanations.photographs.ripple import WaveformModel
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic
from moireid.verifier.explanations.residuals import residual_limit_rad
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MAX_RIPPLE_CONTRASTS, PHOTOGRAPH_SDS, RIPPLE_LEFT_SHARE

Array = NDArray[np.float64]
#: Whether a grating's phase (T,) would be taken for the law's.
Passes = Callable[[Array], bool]
#: More photographs than this are not counted.
MOST_PHOTOGRAPHS = 100


@dataclass(frozen=True)
class Waveform:
    """Ripple of the waveform and what is allowed, contrasts; how many photographs would stay below that; and the third
    harmonic, None for fringes so long that none is looked for.

    photographs: cross-faded, and right in phase by the law; evenly spaced over what the fringes pass, or where they are
    seen most, whichever takes fewer.
    """

    ripple: float
    limit: float
    photographs: int
    third_harmonic: ThirdHarmonic | None


def waveform_of(signal: GratingSignal) -> Waveform | None:
    """The waveform over a grating's path; None where there is too little of it."""
    if signal.beyond is None or np.isfinite(signal.phase_sd_rad).sum() < 10:
        return None
    model = WaveformModel(signal)
    if not model.enough:
        return None
    seen = signal.beyond.overtone[model.used]
    square, sd = model.ripple2(seen)
    limit = math.hypot(MAX_RIPPLE_CONTRASTS, math.sqrt(PHOTOGRAPH_SDS * sd))
    typical = float(np.median(np.abs(seen)))
    hidden = partial(_hidden, signal=signal, model=model, typical=typical, limit=limit, passes=_law_like(signal))
    counts = [
        next((n for n in range(2, MOST_PHOTOGRAPHS) if hidden(taken(n, model.place_rad))), MOST_PHOTOGRAPHS)
        for taken in (evenly, seen_most)
    ]
    return Waveform(math.sqrt(max(square, 0.0)), limit, min(counts), model.third_harmonic(seen) if seen.any() else None)


def _law_like(signal: GratingSignal) -> Passes:
    """Whether a phase is as near to the law as an honest film's is."""
    used = np.isfinite(signal.phase_sd_rad)
    law = signal.predicted_rad[used]
    excitation, error = float(law.std()), float(np.median(signal.phase_sd_rad[used]))
    limit = residual_limit_rad(excitation, math.hypot(error, signal.pose_sd_rad))
    return lambda phase: float((phase[used] - law).std()) <= limit


def _hidden(
    nodes: Array, signal: GratingSignal, model: WaveformModel, typical: float, limit: float, passes: Passes
) -> bool:
    """Whether photographs taken at these places, cross-faded along the film's own motion, would stay unseen."""
    first, third = cross_faded(model.place_rad, nodes)
    size = np.maximum(np.abs(first), 1e-9)
    square, _ = model.ripple2(typical * third * (np.conj(first) / size) ** 3 / size)
    if RIPPLE_LEFT_SHARE * math.sqrt(max(square, 0.0)) > limit:
        return False
    late = np.zeros(len(signal.measured_rad))
    late[model.used] = np.angle(first * np.exp(-1j * model.place_rad))
    shown = within_stretches(signal.predicted_rad + late, signal.stretch)
    return passes(shown)
