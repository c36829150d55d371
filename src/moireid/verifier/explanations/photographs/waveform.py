"""The waveform of a grating's fringes: is it as even as a badge's?

A forger can place the fitting one of some photographs over each frame, or cross-fade two.  Their waveform then changes
between two of them, by its `ripple`; the more photographs, the less.

Convention: contrasts, as in `ripple`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from moireid.verifier.explanations.photographs.ripple import WaveformModel
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MAX_RIPPLE_CONTRASTS, PHOTOGRAPH_SDS


@dataclass(frozen=True)
class Waveform:
    """Ripple of the waveform and what is allowed, contrasts; and the third harmonic, None for fringes so long that none
    is looked for.
    """

    ripple: float
    limit: float
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
    return Waveform(math.sqrt(max(square, 0.0)), limit, model.third_harmonic(seen) if seen.any() else None)
