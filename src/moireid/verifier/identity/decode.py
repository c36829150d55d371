"""Whose badge is it: decode the cells without using the claim, then compare."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

from moireid.idcodes import CellReading, DecodeResult, family_named, specimen_of
from moireid.optics import beat_period_mm
from moireid.provenance import Seal
from moireid.verifier import measuring
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.cell_phase import UNREAD, Field, read_cells, uniform_fields, uniform_readings
from moireid.verifier.identity.cell_slip import (
    TOGETHER,
    CellMotion,
    RowMotion,
    RowsApart,
    cell_motion_of,
    greatest,
    rows_apart,
)
from moireid.verifier.identity.page_scale import page_scale
from moireid.verifier.reasons import Level, Reason, json_number
from moireid.verifier.tracking.track import Track

IdentityVerdict = Literal["match", "mismatch", "unreadable", "not_claimed"]


@dataclass(frozen=True)
class Identity:
    """Outcome of the identity test; beat periods of the reference cell in page mm.

    beats_agree: whether the rows' beats belong to the decoded id, None if no row is readable; built_since: since when
    the figures that it was compared with are on record; cell_motion, rows_apart: as in `CellReadings`.
    """

    verdict: IdentityVerdict
    reasons: tuple[Reason, ...]
    decoded_id: str | None = None
    claimed_id: str | None = None
    beat_period_mm: float | None = None
    expected_beat_period_mm: float | None = None
    symbol_errors_corrected: int = 0
    built: str = "not_known"
    built_since: str | None = None
    score: float | None = None
    beats_agree: bool | None = True
    cell_motion: CellMotion | None = None
    rows_apart: RowsApart = TOGETHER

    @property
    def page_off(self) -> bool:
        """Whether page or sheet is off its size (`page_scale`), so that the fringes are not those of the design."""
        return any(reason.code == "page_scale" for reason in self.reasons)

    def to_json(self) -> dict[str, Any]:
        """As the `identity` object of `verify --json`."""
        names = (
            "decoded_id",
            "claimed_id",
            "beat_period_mm",
            "expected_beat_period_mm",
            "symbol_errors_corrected",
            "built",
            "built_since",
            "score",
        )
        return {"verdict": self.verdict, **{name: json_number(getattr(self, name)) for name in names}}


@dataclass(frozen=True)
class CellReadings:
    """The readings of all cells; decoded and fields belong to the gratings that carry a code.

    cells: one reading per cell, by grating; fields: of the uniform rows, by grating, as used for decoding; cell_motion:
    how far the cells' fringes move, over how far the rows make them; rows_apart: how far the code's rows move apart
    from the plain rows.
    """

    decoded: DecodeResult | None
    cells: tuple[tuple[CellReading, ...], ...]
    fields: dict[int, Field]
    cell_motion: CellMotion | None = None
    rows_apart: RowsApart = TOGETHER


def read_identity(track: Track, measurement: Measurement) -> CellReadings:
    """Decode the gratings that carry a code.

    Convention: only the layout of the track's badge is used.
    Source: if several fields are possible, the first with which a payload decodes; otherwise the likeliest.
    """
    badge = track.badge
    coded = [index for index, grating in enumerate(badge.gratings) if grating.code]
    uniform = [uniform_readings(track, measurement, k) for k in range(len(badge.gratings))]
    if not coded:
        return CellReadings(None, tuple(tuple(cells.values()) for cells in uniform), {})

    @cache
    def read(index: int, option: int) -> tuple[tuple[CellReading, ...], list[RowMotion]]:
        """The readings of one grating under one of its fields, which several combinations share, and its motion."""
        phases, moved = read_cells(track, measurement, index, options[index][option])
        cells = uniform[index] | phases
        return tuple(cells.get(k, UNREAD) for k in range(len(badge.gratings[index].cells))), moved

    options = {index: uniform_fields(track, measurement, index) for index in coded}
    family, gratings = family_named(badge.gratings[coded[0]].family), tuple(badge.gratings[index] for index in coded)
    tried: list[tuple[DecodeResult, dict[int, int]]] = []
    for chosen in itertools.islice(itertools.product(*(range(len(options[k])) for k in coded)), measuring.MOST_FIELDS):
        picked = dict(zip(coded, chosen, strict=True))
        tried.append((family.read([read(*one)[0] for one in picked.items()], gratings), picked))
        if tried[-1][0].payload is not None:
            break
    decoded, picked = tried[-1] if tried[-1][0].payload is not None else tried[0]
    fields = {index: options[index][option] for index, option in picked.items()}
    cells = tuple(read(k, picked[k])[0] if k in picked else tuple(cells.values()) for k, cells in enumerate(uniform))
    moved = {index: read(index, option)[1] for index, option in picked.items()}
    times = {index: track.times_s[track.cell_frames[fields[index].read[track.cell_frames]]] for index in coded}
    apart = greatest(rows_apart(moved[index], times[index]) for index in coded)
    return CellReadings(decoded, cells, fields, cell_motion_of([*itertools.chain(*moved.values())]), apart)


def judge_identity(
    track: Track, measurement: Measurement, *, claimed_id: str | None, seal: Seal | None = None
) -> Identity:
    """Decode, then compare with the claim, which may be sealed; without `claimed_id` and seal only decode.

    Convention: the score is the margin of the worst symbol used: 1 if it lies on its place, 0 if it is as near to the
        next place; negative for another identity.
    """
    reading, badge = read_identity(track, measurement), track.badge
    decoded, readings = reading.decoded, reading.cells
    index = next((k for k, grating in enumerate(badge.gratings) if grating.code), 0)
    coded = badge.gratings[index]
    reference = coded.code.reference_cell if coded.code else 0
    found = decoded.payload.hex() if decoded and decoded.payload else None
    expected_mm = coded.cells[reference].pitch_mm
    if seal is not None and found is not None and seal.holds(found):
        claimed_id = found
        expected_mm = specimen_of(badge, found).gratings[index].cells[reference].pitch_mm
    verdict, reason, score = _compare(decoded, found, claimed_id, sealed=seal is not None)
    off = None
    if decoded is not None and (found is None or decoded.beats_agree is None):
        off = page_scale(track, measurement, readings, backwards=_backwards(measurement))
    return Identity(
        verdict,
        (reason, *_cells_move(reading.cell_motion, found), *([] if off is None else [off])),
        cell_motion=reading.cell_motion,
        rows_apart=reading.rows_apart,
        decoded_id=found,
        claimed_id=claimed_id,
        beat_period_mm=float(beat_period_mm(readings[index][reference].frequency_per_mm)),
        expected_beat_period_mm=float(beat_period_mm(1 / expected_mm - 1 / badge.lens.pitch_mm)),
        symbol_errors_corrected=decoded.corrected if decoded else 0,
        score=score,
        beats_agree=decoded.beats_agree if decoded else True,
    )


def _backwards(measurement: Measurement) -> bool:
    """Whether the fringes of all gratings together move the other way than by the law."""
    return sum(float(signal.measured_rad @ signal.predicted_rad) for signal in measurement.gratings) < 0


def _cells_move(motion: CellMotion | None, found: str | None) -> tuple[Reason, ...]:
    """Whether the fringes of the cells move as far as the rows make them.

    A still picture of cells between genuine rows is a forgery.  Cells that move less than the law, by more than their
    error bar allows, may be photographs that were morphed into each other.  Cells that change more than their rows do
    are next to rows that were smoothed, as in cross-faded photographs.
    """
    if motion is None or found is None:
        return ()
    least = 1 - max(measuring.CELLS_SHORT_RATIO, measuring.CELLS_SHORT_SDS * motion.sd)
    level: Level = "fail" if motion.whole <= measuring.CELLS_STILL_RATIO else "undecided"
    moving = measuring.CELLS_MOVE_RATIO <= motion.whole <= measuring.CELLS_MOST_RATIO
    if moving and motion.typical >= least:
        level = "pass"
    # Where so many cells hardly move that they decide, the typical cell says nothing of them.
    seen = motion.typical if moving else motion.whole
    text = {
        "pass": "The fringes in the badge's code move together with those of its rows.",
        "undecided": f"The fringes in the badge's code move {seen:.2f} times as far as those of its rows, so they "
        "may not be one picture. Film again from nearer, in even light.",
        "fail": "The fringes in the badge's code stay still while those of its rows move, as in a picture that was "
        "pasted in.",
    }[level]
    below = measuring.CELLS_STILL_RATIO if level == "fail" else measuring.CELLS_MOVE_RATIO
    limit = least if moving else below if seen < 1 else measuring.CELLS_MOST_RATIO
    return (Reason("cells_move", level, seen, limit, "", text),)


def _compare(
    decoded: DecodeResult | None, found: str | None, claimed_id: str | None, *, sealed: bool
) -> tuple[IdentityVerdict, Reason, float | None]:
    """Verdict, reason and score from the identity read and the identity claimed; sealed: one is, and may be unknown."""
    if decoded is None and (sealed or claimed_id is not None):
        text = "This badge carries no code that could confirm whose it is."
        return "unreadable", Reason("identity", "undecided", None, claimed_id, "", text), 0.0
    if decoded is None:
        text = "The badge carries no identity, and none was claimed."
        return "not_claimed", Reason("identity", "note", None, None, "", text), None
    margin = decoded.margin
    if claimed_id is None and not sealed:
        text = "The badge's code can be read." if found else "No identity can be read from the badge."
        return "not_claimed", Reason("identity", "note", found, None, "", text), margin
    if found is None:
        text = (
            f"The badge's code cannot be read: {decoded.unclear} of its {decoded.symbols} symbols are unclear, and "
            "others may be wrong. Film the whole badge from nearer, with more motion."
        )
        return "unreadable", Reason("identity", "undecided", float(decoded.unclear), None, "symbols", text), 0.0
    if decoded.beats_agree is False:
        text = "The badge's code is that of one badge, and the fringes of its rows are those of another."
        return "mismatch", Reason("beats", "fail", found, claimed_id, "", text), -margin
    if decoded.beats_agree is None and found == claimed_id:
        text = "The badge's code is that of the claimed badge, but no row's fringes are clear enough to confirm it."
        return "unreadable", Reason("beats", "undecided", found, claimed_id, "", text), 0.0
    if found == claimed_id:
        text = "The badge's code is that of the claimed badge."
        return "match", Reason("identity", "pass", found, claimed_id, "", text), margin
    text = "The badge's code is that of another badge than the claimed one."
    if claimed_id is None:
        text = "The badge's code is another than the claimed one, which is kept sealed."
    return "mismatch", Reason("identity", "fail", found, claimed_id, "", text), -margin
