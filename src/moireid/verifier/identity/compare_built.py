"""The badge as built: measured at enrolment, and compared with that at verification.

A copy made from the same files has the same identity, but its sheet lies differently over the lines: another offset,
another twist, and another beat if it was printed again.  Paper grows and shrinks with humidity.  That changes the beat
too, so the tolerance of the offset grows with the measured change of the beat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.errors import DesignError
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.decode import read_identity
from moireid.verifier.limits import (
    COPY_SDS,
    INDEPENDENT_PER_S,
    MIN_FREQUENCY_SD_PER_MM,
    OFFSET_REPEATS_RAD,
    ORIGINAL_SDS,
    PAPER_DRIFT_SHARE,
    ROW_OFFSET_SD_RAD,
    TWIST_REPEATS_RAD,
)
from moireid.verifier.motion.judge import Invariant
from moireid.verifier.reasons import Reason
from moireid.verifier.tracking.track import Track

Built = Literal["original", "copy", "not_known"]


@dataclass(frozen=True)
class Comparison:
    """Outcome of comparing a film's figures with those of enrolment."""

    built: Built
    reasons: tuple[Reason, ...]


def measure_built(track: Track, measurement: Measurement, invariant: Invariant) -> AsBuilt:
    """The as-built figures measured from one film.

    Convention: as `AsBuilt`.
    Returns: AsBuilt.
    Raises: DesignError for a board that carries no identity.
    Source: `cell_phase.uniform_fields` of the first grating that carries a code.  The offset is the mean of measured
        less predicted phase; its error comes from the scatter over time and from the gain's error times the mean phase.
    """
    badge = track.badge
    index = next((k for k, grating in enumerate(badge.gratings) if grating.code), None)
    if index is None or badge.id is None or invariant.gain_ratio is None or invariant.gain_sd is None:
        raise DesignError("a board without an identity cannot be enrolled as built; print a badge with one")
    reading = read_identity(track, measurement)
    field = reading.fields[index]
    code = badge.gratings[index].code
    assert code is not None
    reference = reading.cells[index][code.reference_cell]
    clock = np.exp(1j * field.clock_rad)
    mean_turn = complex(clock.mean())
    wander = float(np.std(np.angle(clock / mean_turn)))
    seconds = float(measurement.times_s[-1] - measurement.times_s[0])
    off_centre = abs(float(np.mean([p.mean() for p in measurement.predictions_rad if p is not None])))
    offset_sd = math.hypot(wander / math.sqrt(max(INDEPENDENT_PER_S * seconds, 1.0)), off_centre * invariant.gain_sd)
    height = badge.gratings[index].rect_mm
    span = (height[3] - height[1]) if badge.gratings[index].axis == "x" else (height[2] - height[0])
    return AsBuilt(
        badge_id=badge.id,
        beat_frequency_per_mm=reference.frequency_per_mm,
        beat_frequency_sd=reference.frequency_sd,
        offset_rad=float(np.angle(mean_turn)),
        offset_sd=offset_sd,
        twist_rad_per_mm=field.twist_rad_per_mm,
        twist_sd=ROW_OFFSET_SD_RAD / span,
        gain_ratio=invariant.gain_ratio,
        gain_sd=invariant.gain_sd,
    )


def compare_built(found: AsBuilt, enrolled: AsBuilt, badge: Badge) -> Comparison:
    """Whether the film shows the very badge that was enrolled.

    Convention: differences are found less enrolled.
    Returns: Comparison; "not_known" lies between the limits of original and copy.
    Source: module docstring; limits in standard deviations of the repeatability, plus the possible drift of paper.
    """
    index = next(k for k, grating in enumerate(badge.gratings) if grating.code)
    rect, axis = badge.gratings[index].rect_mm, 0 if badge.gratings[index].axis == "x" else 1
    half_mm = (rect[axis + 2] - rect[axis]) / 2
    lines_per_mm = 1.0 / badge.lens.pitch_mm
    beat = found.beat_frequency_per_mm - enrolled.beat_frequency_per_mm
    beat_sd = math.hypot(found.beat_frequency_sd, enrolled.beat_frequency_sd, MIN_FREQUENCY_SD_PER_MM)
    beat_limit = PAPER_DRIFT_SHARE * lines_per_mm
    slide_rad = 2 * math.pi * half_mm * min(abs(beat), beat_limit)
    offset = abs(math.remainder(found.offset_rad - enrolled.offset_rad, 2 * math.pi))
    offset_sd = math.hypot(found.offset_sd, enrolled.offset_sd, OFFSET_REPEATS_RAD)
    twist = abs(found.twist_rad_per_mm - enrolled.twist_rad_per_mm)
    twist_sd = math.hypot(found.twist_sd, enrolled.twist_sd, 2 * math.pi * TWIST_REPEATS_RAD * lines_per_mm)
    checks = (
        ("as_built_beat", abs(beat), beat_limit, beat_sd, "cycles/mm", "fringe frequency"),
        ("as_built_offset", offset, slide_rad, offset_sd, "rad", "position of the sheet"),
        ("as_built_twist", twist, 0.0, twist_sd, "rad/mm", "rotation of the sheet"),
    )
    reasons, levels = [], []
    for code, difference, room, sd, unit, words in checks:
        limit, far = room + ORIGINAL_SDS * sd, room + COPY_SDS * sd
        level: Built = "original" if difference <= limit else "copy" if difference > far else "not_known"
        levels.append(level)
        text = f"The {words} differs from enrolment by {difference:.4g} {unit}; known errors explain {limit:.4g}."
        reasons.append(Reason(code, "note", difference, limit, unit, text))
    built: Built = "copy" if "copy" in levels else "not_known" if "not_known" in levels else "original"
    return Comparison(built, tuple(reasons))
