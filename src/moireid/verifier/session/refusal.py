"""Why a film of a freshly built badge may not have been accepted: what it shows of how the badge is built.

Each finding is beyond what an ordinary badge shows, and names what a builder can do about it.
"""

from __future__ import annotations

import math

import numpy as np

from moireid.badge import Badge
from moireid.sheets import air_mm_per_gain
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.measuring import MAP_SDS

#: From here on a figure may explain a refusal: twist of the page, 1/m; lenses off their places, mm root mean square;
#: gain over the design, as a share; contrast of the fringes, over the most that they can have.
BENT_PER_M, OFF_MM, GAIN_OFF_SHARE, LEAST_CONTRAST = 0.25, 0.04, 0.1, 0.15
#: Fundamental of a square wave over its mean.
MOST_CONTRAST = 4 / math.pi


def build_findings(measurement: Measurement, badge: Badge, gain: float | None) -> list[str]:
    """Sentences about a badge that differs from an ordinary one; none where nothing does.

    Parameters
    ----------
    measurement : Measurement
        Of a film of it.
    badge : Badge
        Its design.
    gain : float or None
        How far its fringes move, over the design, if that was measured.
    """
    found = [_flatness(measurement), _wander(measurement, badge), _gap(badge, gain), _contrast(measurement)]
    return [sentence for sentence in found if sentence]


def _flatness(measurement: Measurement) -> str:
    twist = abs(measurement.camera.twist_per_m)
    if twist < BENT_PER_M:
        return ""
    return f"The page is not flat: as if bent to a radius of {0.5 / twist:.1f} m across its corners. Lay it on a board."


def _wander(measurement: Measurement, badge: Badge) -> str:
    sizes = [(math.sqrt(float(np.mean(one.seen_rad**2))), one.sd_rad) for one in measurement.maps]
    sure = max((size for size, sd in sizes if size > MAP_SDS * sd), default=0.0)
    off_mm = sure / (2 * math.pi) * badge.lens.pitch_mm
    if off_mm < OFF_MM:
        return ""
    return (
        f"Lenses are {off_mm:.2f} mm off their places, root mean square. Glue the sheet without "
        "tension, or take another piece."
    )


def _gap(badge: Badge, gain: float | None) -> str:
    """Fringes move in proportion to the optical gap: that of the sheet, and of air beneath it."""
    if gain is None or abs(gain - 1) < GAIN_OFF_SHARE:
        return ""
    if gain < 0:
        return "Fringes run the other way than designed, as on a page of another size or under another sheet."
    air_mm = (gain - 1) * air_mm_per_gain(badge.lens, badge.gratings[0].pitch_mm)
    as_air = f", or with {air_mm:.2f} mm of air beneath it: press it flat" if gain > 1 else ""
    return (
        f"Fringes move {gain:.2f} times as far as designed, as under a sheet of {gain * badge.lens.thickness_mm:.2f} mm"
        f"{as_air}."
    )


def _contrast(measurement: Measurement) -> str:
    ratios = [strip.contrast / np.maximum(strip.level, 1e-6) for strip in measurement.strips if strip]
    value = float(np.median(np.concatenate(ratios))) / MOST_CONTRAST if ratios else 1.0
    if value >= LEAST_CONTRAST:
        return ""
    return f"Fringes have {value:.0%} of the contrast that they can have. So look haze, glare, and pale print."
