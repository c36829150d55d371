"""Fringes that drift, come late, or follow the badge's place: how often would they pass on this film's own course?

On a course that goes steadily one way a delay is but a constant, which assembly decides, and a drift at the right speed
is the law itself.  Where nothing turns, the badge's place in the picture says as much as its parallax, and a generator
may have learnt to move fringes with the place.  So the chance is counted that a forger passes who knows neither speed,
nor delay, nor how far: forged signals are made on the film's own course, with no other fault, and judged as the film
is.

Convention: a drift goes at one speed all film long.  Its ratio to the best-fitting speed is any between
`FORGED_GAIN_MIN_RATIO` and `FORGED_GAIN_MAX_RATIO` alike, and so is that of fringes which follow a place.  A delay is
any of `DELAYS_S` alike.  Each stretch has a phase constant of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import GAP_S, unbroken
from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import (
    DELAYS_S,
    FORGED_GAIN_MAX_RATIO,
    FORGED_GAIN_MIN_RATIO,
    GAIN_TOLERANCE_SHARE,
    MIN_CORRELATION,
)

Array = NDArray[np.float64]
#: Steps of the drift's ratio that are tried.
RATIO_STEP = 0.05

Passes = Callable[[GratingSignal], bool]
#: Least and greatest gain that may pass.
Room = tuple[float, float]
DESIGNED_ROOM = (1 - GAIN_TOLERANCE_SHARE, 1 + GAIN_TOLERANCE_SHARE)


@dataclass(frozen=True)
class KnownBuilt:
    """What is known of a badge as built that the film agrees with: the room of its gain, and of its offset, rad.

    A forger who does not know the gain and the offset must meet both by chance.
    """

    gain_room: float
    offset_room_rad: float


def chance_of_drift(
    signal: GratingSignal, passes: Passes, known: KnownBuilt | None = None, room: Room = DESIGNED_ROOM
) -> float:
    """How often fringes that drift at an unknown constant speed would pass.

    Parameters: passes: whether a forged signal would; known: of the badge as built; room: gains that may pass.
    """
    return _chance_of_ratio(signal, signal.times_s[:, None], passes, known, room)


def chance_of_place(
    signal: GratingSignal, passes: Passes, known: KnownBuilt | None = None, room: Room = DESIGNED_ROOM
) -> float:
    """How often fringes that move with the badge's place in the picture, to an unknown degree, would pass."""
    return _chance_of_ratio(signal, signal.beyond.place_px, passes, known, room) if signal.beyond is not None else 0.0


def _chance_of_ratio(
    signal: GratingSignal, patterns: Array, passes: Passes, known: KnownBuilt | None, room: Room
) -> float:
    """How often the best-fitting sum of patterns (T, P), times an unknown ratio, would pass.

    Source: regressed on the course, ratio r has a gain of r times the square of how alike pattern and course are.  The
        offset of such fringes is any, so of known badges as built a share of room / pi agrees.
    """
    table = np.column_stack([within_stretches(pattern, signal.stretch) for pattern in patterns.T])
    course = within_stretches(signal.predicted_rad, signal.stretch)
    power = float(course @ course)
    best = table @ np.linalg.lstsq(table, course, rcond=1e-9)[0]
    alike = math.sqrt(max(float(best @ course), 0.0) / power) if power > 0 else 0.0
    if alike < MIN_CORRELATION:
        return 0.0
    ratios = np.arange(FORGED_GAIN_MIN_RATIO, FORGED_GAIN_MAX_RATIO + RATIO_STEP / 2, RATIO_STEP)
    near = ratios[(room[0] <= ratios * alike**2) & (ratios * alike**2 <= room[1])]
    share = sum(passes(replace(signal, measured_rad=ratio * best)) for ratio in near) / len(ratios)
    if known is None:
        return share
    narrow = 2 * known.gain_room / alike**2 / (FORGED_GAIN_MAX_RATIO - FORGED_GAIN_MIN_RATIO)
    return min(share, narrow) * min(1.0, known.offset_room_rad / math.pi)


def chance_of_delay(signal: GratingSignal, passes: Passes, known: KnownBuilt | None = None) -> float:
    """How often fringes that come late by an unknown time would pass."""
    return sum(_late_passes(signal, delay, passes, known) for delay in DELAYS_S) / len(DELAYS_S)


def _late_passes(signal: GratingSignal, delay_s: float, passes: Passes, known: KnownBuilt | None) -> bool:
    late = _delayed(signal, delay_s)
    shift = late - signal.predicted_rad
    if known is not None:
        # Fringes that come late on a steady course stand aside all the time, by more than the sheet may lie aside.
        aside = [abs(float(shift[signal.stretch == number].mean())) for number in np.unique(signal.stretch)]
        if max(aside) > known.offset_room_rad:
            return False
    return passes(replace(signal, measured_rad=within_stretches(late, signal.stretch)))


def _delayed(signal: GratingSignal, delay_s: float) -> Array:
    """The course so much later, (T,); before the beginning of a stretch it went on as it begins."""
    shown = np.empty_like(signal.predicted_rad)
    for part in unbroken(signal.times_s, GAP_S, signal.stretch):
        clock, kept = np.unique(signal.times_s[part], return_index=True)
        course = signal.predicted_rad[part[kept]]
        early = min(max(int(np.searchsorted(clock, clock[0] + delay_s)), 1), len(clock) - 1)
        wanted = signal.times_s[part] - delay_s
        shown[part] = np.interp(wanted, clock, course)
        if early > 0:
            rate = (course[early] - course[0]) / (clock[early] - clock[0])
            shown[part] += rate * np.minimum(wanted - clock[0], 0.0)
    return shown
