"""Phase cells: how far each cell's fringe is ahead of the uniform rows.

Every sample of a cell sees level + contrast cos(field + symbol).  The field is the phase of the uniform rows: their
measured beat, the view geometry, and their *measured* motion.  So the reading does not need exact poses, and works even
if the fringes break the law.  Offset and twist of the sheet depend on assembly.  They are estimated from the uniform
rows, and again from the cells once their symbols are nearly clear.

Convention: phases in rad, positive where the cell's fringes are ahead; frames (F,) are those that cells are read in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.frames import own_rect
from moireid.idcodes.family import CellReading
from moireid.idcodes.pitch import steps_from_reference
from moireid.idcodes.spacing import PHASE_LEVELS, nearest_place
from moireid.layers import is_smooth
from moireid.verifier import limits, measuring
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.fringes.sinusoid import Complex
from moireid.verifier.fringes.strip_law import strip_law, within_law
from moireid.verifier.fringes.strip_phase import StripPhase
from moireid.verifier.identity.cell_slip import RowMotion, row_motion
from moireid.verifier.identity.cell_waveform import (
    Moments,
    learn_waveform,
    match_cost,
    match_phase,
    match_symbol,
    moments,
)
from moireid.verifier.identity.neighbour_lines import ahead_of_own_lines
from moireid.verifier.series import spread_out
from moireid.verifier.tracking.brightness_profiles import Strip, rims_of
from moireid.verifier.tracking.track import Track

Array = NDArray[np.float64]


#: Margin left out at a cell's ends, mm, at most a fifth of the cell: blur mixes neighbours there.
MARGIN_MM = 1.2
#: Frames from which the fringe's shape is learnt.
SHAPE_FRAMES = 48


#: Frames from which the twist, one figure for the whole film, is estimated; steps from none to the largest usual one.
TWIST_FRAMES, TWIST_STEPS = 128, 400
#: A smooth grating's cells are read so often with what their neighbours add, by the symbols read before.
NEIGHBOUR_PASSES = 2
UNREAD = CellReading(math.nan, math.inf, math.nan, math.inf)
"""A cell that no frame shows."""


@dataclass(frozen=True)
class Field:
    """The uniform rows' field of one grating.

    clock_rad (T,): measured less predicted motion, with the sheet's offset; twist_rad_per_mm: phase slope along the
    lenses; level, contrast (T,): of the picture, counts; frequency_per_mm: of the reference cells; middle_mm: across;
    read (T,): frames in which a row shows its phase, without which no cell can be read, and that the law covers.
    """

    clock_rad: Array
    twist_rad_per_mm: float
    level: Array
    contrast: Array
    frequency_per_mm: float
    middle_mm: float
    read: NDArray[np.bool_]


def read_cells(
    track: Track, measurement: Measurement, grating: int, field: Field
) -> tuple[dict[int, CellReading], list[RowMotion]]:
    """Phases of all phase cells of one grating, by cell index, relative to one of its `uniform_fields`; and what the
    cells of each row show of motion.

    Convention: phase positive where the cell's fringe is ahead, which means that its lines are shifted back.
    Returns: empty if the grating has no phase cells.
    Source: each cell over the sampled frames, first by itself; then a plane of phase, common to all cells, is
        subtracted, and each cell is fitted on one of the code's places.  In a smooth grating the symbols read so give
        what neighbours add to each cell, which is then read whole, less that.  The sample is bounded, so a long film
        takes no more time or memory than one of 8 s.
    """
    strips = [(k, strip) for k, strip in enumerate(track.strips) if strip.grating == grating and not strip.uniform]
    sampled = field.read[track.cell_frames]
    if not strips or not sampled.any():
        return {}, []
    shape, badge, frames = _shape(track, measurement, grating, field), track.badge, track.cell_frames[sampled]
    own = badge.gratings[grating]
    # Looked up once, as that compares all cells of the grating.
    rows, rims = [], [rim for rim, _ in rims_of(own)]
    for index, strip in strips:
        seen = _in_contrasts(track.profiles[index][sampled], field, frames)
        phase = _field_phase(badge, strip, measurement, field, frames)
        members = _members(own, strip, rims)
        rows.append(_Row(strip, seen, phase, moments(seen, phase), members, np.zeros(phase.shape[1])))
    cells, ahead_rad = _placed(rows, shape, field, own)
    if is_smooth(own):
        uniform = uniform_readings(track, measurement, grating)
        beats = steps_from_reference([uniform.get(cell, UNREAD) for cell in range(len(own.cells))], own)
        steps = [round(beats[cell][0]) for cell in sorted(uniform)]
        before: dict[int, int] = {}
        for _ in range(NEIGHBOUR_PASSES):
            places = {cell: nearest_place(found.phase_rad) for cell, found in cells.items()}
            if places == before:
                break
            ahead, before = ahead_of_own_lines(track, grating, places, steps), places
            rows = [_with_neighbours(own, row, ahead) for row in rows]
            cells, ahead_rad = _placed(rows, shape, field, own)
    own_rad = np.split(ahead_rad, np.cumsum([len(row.members) for row in rows], dtype=int)[:-1])
    return cells, [
        row_motion(row.seen, row.phase + row.ahead_rad + ahead @ row.members, shape, row.members)
        for row, ahead in zip(rows, own_rad, strict=True)
    ]


@dataclass(frozen=True)
class _Row:
    """A strip of phase cells, of N places: its samples in contrasts about the level, and the field's phase there,
    (frames, N); their sums; members (cells, N): 1 where a cell is read, else 0; ahead_rad (N,): what neighbours add.
    """

    strip: Strip
    seen: Array
    phase: Array
    sums: Moments
    members: Array
    ahead_rad: Array


def _members(own: Grating, strip: Strip, rims_mm: Sequence[float]) -> Array:
    """As in `_Row`; rims_mm: by cell, what is left out at its ends at least."""
    found = []
    for cell in strip.cells:
        low, _, high, _ = own_rect(own.axis, own.cells[cell].rect_mm)
        margin = max(min(MARGIN_MM, 0.2 * (high - low)), rims_mm[cell])
        found.append((strip.along_mm >= low + margin) & (strip.along_mm <= high - margin))
    return np.array(found, float)


def _with_neighbours(own: Grating, row: _Row, ahead: dict[int, Array]) -> _Row:
    """The row with its cells read whole, as is known what neighbours add to them; ahead: as `ahead_of_own_lines`."""
    members = _members(own, row.strip, [0.0] * len(own.cells))
    return replace(row, members=members, ahead_rad=(members * [ahead[cell] for cell in row.strip.cells]).sum(axis=0))


def _placed(
    rows: Sequence[_Row], shape: Complex, field: Field, grating: Grating
) -> tuple[dict[int, CellReading], Array]:
    """Each cell on one of the code's places, less a plane of phase; and how far the fringes of each are ahead of the
    field, in the order of the rows.
    """
    costs = np.concatenate(
        [match_cost(row.sums.of_cells(row.members, row.ahead_rad), shape, measuring.CELL_NOISE_RATIO) for row in rows]
    )
    ahead, sd = match_phase(costs)
    along = [row.members @ row.strip.along_mm / np.maximum(row.members.sum(axis=1), 1.0) for row in rows]
    across = np.repeat([row.strip.across_mm - field.middle_mm for row in rows], [len(part) for part in along])
    levels = (grating.code.phase_levels if grating.code else None) or PHASE_LEVELS
    offset = _offsets(ahead, np.hypot(sd, measuring.CELL_FLOOR_RAD), np.concatenate(along), across, levels)
    placed, placed_sd = match_symbol(costs, offset, levels)
    free = [math.remainder(phase, 2 * math.pi) for phase in ahead - offset]
    figures = zip(placed.tolist(), np.hypot(placed_sd, measuring.CELL_FLOOR_RAD).tolist(), free, strict=True)
    cells = [cell for row in rows for cell in row.strip.cells]
    return {cell: CellReading(math.nan, math.inf, *own) for cell, own in zip(cells, figures, strict=True)}, ahead


def _field_phase(
    badge: Badge, strip: Strip, measurement: Measurement, field: Field, frames: NDArray[np.int64]
) -> Array:
    """Phase of the field at the samples of a strip in some frames, (frames, N)."""
    law = strip_law(badge, strip, measurement.camera_mm[frames], measurement.maps[strip.grating].used_rad)
    along = law.whole_phase_rad(field.frequency_per_mm) + field.clock_rad[frames, None]
    return along + field.twist_rad_per_mm * (strip.across_mm - field.middle_mm)


def _in_contrasts(profiles: NDArray[np.float32], field: Field, frames: NDArray[np.int64]) -> Array:
    """Profiles of some frames minus their level, in units of their contrast, (frames, N)."""
    return np.asarray((profiles - field.level[frames, None]) / np.maximum(field.contrast[frames], 1.0)[:, None])


def _shape(track: Track, measurement: Measurement, grating: int, field: Field) -> Complex:
    """The fringe's shape, learnt from the reference rows, which have the same beat as the cells."""
    code = track.badge.gratings[grating].code
    assert code is not None
    read = np.flatnonzero(field.read)
    frames = read[spread_out(len(read), SHAPE_FRAMES)]
    seen, phases = [], []
    for index, strip in enumerate(track.strips):
        if strip.grating == grating and strip.uniform and code.roles[strip.cells[0]] == "reference":
            seen.append(_in_contrasts(track.profiles[index][frames], field, frames).ravel())
            phases.append(_field_phase(track.badge, strip, measurement, field, frames).ravel())
    return learn_waveform(np.concatenate(seen), np.concatenate(phases))


def uniform_readings(track: Track, measurement: Measurement, grating: int) -> dict[int, CellReading]:
    """The beats of the uniform cells of a grating, by cell, over whose strips they are averaged by their error bars.

    A row with a far larger phase error than the others is partly covered.  The cover stays still and biases the beat
    alike in all parts of the film, so the error bar of the beat does not show it.  Such a row counts as unread.
    """
    clearest = min((float(np.median(row.phase_sd_rad)) for row in measurement.strips if row), default=math.inf)
    most = limits.MAX_VAGUENESS_RATIO * max(clearest, 1e-3)
    cells: dict[int, list[StripPhase]] = {}
    for strip, row in zip(track.strips, measurement.strips, strict=True):
        if strip.grating == grating and row is not None:
            cells.setdefault(strip.cells[0], []).append(row)
    found = {}
    for cell, own in sorted(cells.items()):
        sd = np.array([max(row.frequency_sd, measuring.MIN_FREQUENCY_SD_PER_MM) for row in own])
        known = bool(np.all(np.isfinite(sd)))
        weight = 1 / sd**2 if known else np.ones(len(own))
        frequency = float(np.average([row.frequency_per_mm for row in own], weights=weight))
        covered = min(float(np.median(row.phase_sd_rad)) for row in own) > most
        frequency_sd = math.sqrt(1 / weight.sum()) if known and not covered else math.inf
        found[cell] = CellReading(frequency, frequency_sd, math.nan, math.inf)
    return found


def uniform_fields(track: Track, measurement: Measurement, grating: int) -> list[Field]:
    """Possible fields of the uniform rows of a grating, the likeliest first.

    Convention: clock + twist (across - middle) + law is the phase of a uniform row anywhere on the grating.
    Source: circular mean over the rows, weighted by their Fisher information, for the twist at which the rows agree
        best.  Evenly spaced rows agree as well with a twist that adds a whole turn per row.  So there may be several
        fields, and decoding decides: with a wrong one whole rows of symbols are wrong.
    """
    badge = track.badge
    code = badge.gratings[grating].code
    assert code is not None
    _, top, _, bottom = own_rect(badge.gratings[grating].axis, badge.gratings[grating].rect_mm)
    middle = (top + bottom) / 2
    both = zip(track.strips, measurement.strips, strict=True)
    uniform = [(strip, seen) for strip, seen in both if strip.grating == grating and seen is not None]
    rows = [seen for _, seen in uniform]
    apart = np.array([row.phase_rad - row.predicted_rad for row in rows])
    weight = np.array([1 / np.maximum(row.phase_sd_rad, 1e-3) ** 2 for row in rows])
    across = np.array([strip.across_mm - middle for strip, _ in uniform])
    reference = [row for strip, row in uniform if code.roles[strip.cells[0]] == "reference"]
    frequency = float(np.mean([row.frequency_per_mm for row in reference]))
    share = weight / np.maximum(weight.sum(axis=0), 1e-12)
    level, contrast = ((share * np.array([getattr(row, n) for row in rows])).sum(axis=0) for n in ("level", "contrast"))
    read = weight.any(axis=0) & within_law(track.strips, measurement.camera_mm)
    fields = []
    for twist in _twists(apart, across, weight, 2 * math.pi / badge.lens.pitch_mm):
        clock = np.angle((weight * np.exp(1j * (apart - twist * across[:, None]))).sum(axis=0))
        fields.append(Field(clock, twist, level, contrast, frequency, middle, read))
    return fields


def _twists(apart: Array, across: Array, weight: Array, slope: float) -> list[float]:
    """Twists, rad per mm across, at which the rows agree nearly as well as at the best one, best first.

    apart, weight (rows, T); slope: phase per mm across for a twist of one radian.  The mean of the rows in each frame
    is left free.  It must not be subtracted first, because a twist may make the rows cancel in it.  Twists beyond the
    usual ones come first only if the rows agree clearly better there.  Where they agree nowhere, there is but one.
    """
    if len(apart) < 2:
        return [0.0]
    step = slope * measuring.USUAL_TWIST_RAD / TWIST_STEPS
    count = round(slope * measuring.MAX_TWIST_RAD / step)
    grid = step * np.arange(-count, count + 1)
    some = spread_out(apart.shape[1], TWIST_FRAMES)
    turned = weight[:, some] * np.exp(1j * apart[:, some])
    agreement = np.abs(np.exp(-1j * np.outer(grid, across)) @ turned).sum(axis=1) / weight[:, some].sum()
    usual = slice(count - TWIST_STEPS, count + TWIST_STEPS + 1)
    found = {float(grid[k]): float(agreement[k]) for k in _near_best(agreement)}
    likely = {
        float(grid[usual][k]): float(agreement[usual][k]) + measuring.UNUSUAL_TWIST_LESS
        for k in _near_best(agreement[usual])
    }
    score = found | likely
    if agreement.max() < measuring.LEAST_AGREEMENT:
        # Such rows choose between no twists, and to read the cells under each would cost more than all else.
        return [max(score, key=lambda twist: score[twist])]
    return sorted(score, key=lambda twist: -score[twist])


def _near_best(agreement: Array) -> list[int]:
    """Peaks that are nearly as high as the highest one."""
    padded = np.concatenate([[-1.0], agreement, [-1.0]])
    peaks = np.flatnonzero((agreement >= padded[:-2]) & (agreement > padded[2:]))
    return [int(k) for k in peaks if agreement[k] >= agreement.max() - measuring.DOUBTFUL_AGREEMENT_SHARE]


def _offsets(phase: Array, sd: Array, along: Array, across: Array, levels: int) -> Array:
    """Remaining error of offset, twist and beat at each cell: a plane through the distances to the nearest symbol."""
    place = np.column_stack([np.ones(len(phase)), along - along.mean(), across])
    step = 2 * math.pi / levels
    offset = np.zeros(len(phase))
    for _ in range(3):
        apart = phase - offset
        apart = apart - step * np.round(apart / step)
        # A distance beyond a third of a step may belong to the next symbol, so it is left out.
        use = (np.abs(apart) < step / 3) / sd
        if np.count_nonzero(use) < 8:
            break
        plane, *_ = np.linalg.lstsq(place * use[:, None], apart * use, rcond=None)
        offset = offset + place @ plane
    return offset
