"""The radius of a sheet's lenses, from how much of the fringes' third harmonic they let through.

Lenses that focus on the printed page show its lines with sharp edges, and so a third harmonic.  Rays of a lens of
another radius land side by side, which blurs the third harmonic before the first.  A radius too large and one too small
blur alike, so both are given.

Convention: the third harmonic in contrasts of the first one, seen from the front, as in `AsBuilt`; radii over that
which focuses on the back, as `sheets.sheet_lens` has it.
Source: `lenticule.trace_mm`; Fourier series of lines that cover a share d: |sin 3 pi d| / (3 sin pi d).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from moireid.badge import Lens
from moireid.lenticule import trace_mm

RATIOS = np.linspace(0.8, 1.6, 81)
RAYS = 400


def third_harmonic_expected(lens: Lens, pitch_mm: float, duty: float, radius_ratio: float) -> float:
    """The third harmonic of fringes under such a sheet, contrasts.

    Parameters: pitch_mm, duty: of the printed lines; radius_ratio: radius over that of `lens`.
    """
    assert lens.radius_mm is not None
    across = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * lens.pitch_mm
    zero = np.zeros(RAYS)
    landed, _ = trace_mm(replace(lens, radius_mm=radius_ratio * lens.radius_mm), across, zero, zero)
    landed = landed[np.isfinite(landed)]
    first, third = (abs(np.mean(np.exp(2j * math.pi * k * landed / pitch_mm))) for k in (1, 3))
    return float(abs(math.sin(3 * math.pi * duty)) / (3 * abs(math.sin(math.pi * duty))) * third / max(first, 1e-9))


def radius_ratios(lens: Lens, pitch_mm: float, duty: float, third_harmonic: float) -> tuple[float, float]:
    """The smallest and the largest radius that let so much through, over that which focuses on the back.

    Returns: two ratios, within 0.8 to 1.6 and with lenses that meet; both that of the sharpest lens where more was
        measured than it lets through.
    """
    assert lens.radius_mm is not None
    # Lenses of half a pitch touch.
    ratios = RATIOS[RATIOS * lens.radius_mm > 0.5001 * lens.pitch_mm]
    through = np.array([third_harmonic_expected(lens, pitch_mm, duty, ratio) for ratio in ratios])
    enough = np.flatnonzero(through >= min(third_harmonic, through.max()))
    return float(ratios[enough[0]]), float(ratios[enough[-1]])
