"""All strips of a track, measured: phase, predicted phase, the spacing against distance, and the gratings' maps.

A map of places (`place_map`) is estimated from the strips and used to measure them again, until nothing is missing from
it; most badges need none.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.verifier import measuring
from moireid.verifier.fringes.beyond_phase import depth_law
from moireid.verifier.fringes.place_map import PlaceMap, knots_mm, seen_map, still_shift
from moireid.verifier.fringes.strip_law import air_law, strip_law, within_law
from moireid.verifier.fringes.strip_phase import StripPhase, measure_strip
from moireid.verifier.fringes.strip_shape import places_apart_rad, strip_shape
from moireid.verifier.tracking.track import Track

Array = NDArray[np.float64]


def measure_strips(
    track: Track, badge: Badge, camera_mm: Array, maps: list[Array]
) -> tuple[list[StripPhase | None], tuple[PlaceMap, ...]]:
    """The strips of a track, and the gratings' maps with which they were measured, from those to begin with."""
    for _ in range(measuring.MAP_ROUNDS):
        strips = [_measured_strip(track, badge, index, camera_mm, maps) for index in range(len(track.strips))]
        seen = tuple(
            seen_map(
                used,
                [
                    found.still
                    for strip, found in zip(track.strips, strips, strict=True)
                    if found and strip.grating == g
                ],
            )
            for g, used in enumerate(maps)
        )
        if all(one.change_rad is None for one in seen):
            break
        maps = [one.used_rad if one.change_rad is None else one.seen_rad for one in seen]
    return strips, seen


def _measured_strip(track: Track, badge: Badge, index: int, camera_mm: Array, maps: list[Array]) -> StripPhase | None:
    """One strip of a track; None for a row of phase cells, which is read with the identity."""
    strip = track.strips[index]
    if not strip.uniform:
        return None
    law = strip_law(badge, strip, camera_mm, maps[strip.grating])
    band = search_band_per_mm(badge, badge.gratings[strip.grating], strip.cells[0])
    profiles = track.profiles[index].astype(float)
    found = measure_strip(profiles, law, strip.length_mm, band)
    known = within_law(track.strips, camera_mm)
    shape = strip_shape(profiles, law, replace(found, phase_sd_rad=np.where(known, found.phase_sd_rad, np.inf)))
    predicted = law.middle_phase_rad(found.frequency_per_mm)
    camera = (strip.frame.places(camera_mm[:, :2]) / np.abs(camera_mm[:, 2:])).T
    middle = np.array([[strip.middle_mm], [strip.across_mm]]) / np.abs(camera_mm[:, 2])
    air = air_law(badge.lens, badge.gratings[strip.grating].pitch_mm, *(middle - camera))
    apart = places_apart_rad(shape, track.times_s, predicted, air)
    depth = depth_law(shape, law, found, camera[0], strip.length_mm)
    still = still_shift(strip, shape, knots_mm(badge.gratings[strip.grating]))
    return replace(found, predicted_rad=predicted, place_residual_rad=apart, depth=depth, still=still)


def search_band_per_mm(badge: Badge, grating: Grating, cell: int) -> tuple[float, float]:
    """Lowest and highest beat frequency that a cell may have: of all symbols for a code, else of this cell.

    Convention: signed as `optics.beat_frequency_per_mm`; widened by `PITCH_TOLERANCE_SHARE`.
    """
    tolerance = measuring.PITCH_TOLERANCE_SHARE / badge.lens.pitch_mm
    if grating.code is None:
        own = 1 / grating.cells[cell].pitch_mm - 1 / badge.lens.pitch_mm
        return own - tolerance, own + tolerance
    code = grating.code
    ends = [code.base_frequency_per_mm + code.frequency_step_per_mm * level for level in (0, code.levels - 1)]
    return min(ends) - tolerance, max(ends) + tolerance
