"""Whose badge is it: decode the cells without looking at any claim, then compare."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from moireid.badge import Badge, Grating
from moireid.idcodes import CellReading, Decoded, family_named
from moireid.optics import beat_period_mm
from moireid.verifier.measure import Measurement
from moireid.verifier.reasons import Reason, json_number
from moireid.verifier.track import Track

IdentityVerdict = Literal["match", "mismatch", "unreadable", "not_claimed"]


@dataclass(frozen=True)
class Identity:
    """Outcome of the identity test; beat periods of the reference cell in page mm."""

    verdict: IdentityVerdict
    reasons: tuple[Reason, ...]
    decoded_id: str | None = None
    claimed_id: str | None = None
    beat_period_mm: float | None = None
    expected_beat_period_mm: float | None = None
    symbol_errors_corrected: int = 0
    built: str = "not_known"
    score: float | None = None

    def to_json(self) -> dict[str, Any]:
        """As the `identity` object of `verify --json`."""
        names = (
            "decoded_id", "claimed_id", "beat_period_mm", "expected_beat_period_mm", "symbol_errors_corrected",
            "built", "score",
        )  # fmt: skip
        return {"verdict": self.verdict, **{name: json_number(getattr(self, name)) for name in names}}


def read_identity(track: Track, measurement: Measurement, badge: Badge) -> tuple[Decoded | None, list[CellReading]]:
    """Decode the first grating that carries a code; readings are those of its cells.

    Convention: only the layout of `badge` is used.  Returns: None and the first grating's readings where no grating
    carries a code.
    """
    for index, grating in enumerate(badge.gratings):
        if grating.code is not None:
            readings = _cell_readings(track, measurement, grating, index)
            return family_named(grating.family).read(readings, grating), readings
    return None, _cell_readings(track, measurement, badge.gratings[0], 0)


def judge_identity(track: Track, measurement: Measurement, badge: Badge, *, claimed_id: str | None) -> Identity:
    """Decode, then compare with the claim; `claimed_id` None asks for the decoding alone.

    Convention: the score is the distance of the symbols from confusion: 1 where each lies on its place, 0 where the
    worst one that was used is as near to its neighbour; negative for another identity.
    """
    decoded, readings = read_identity(track, measurement, badge)
    coded = next((grating for grating in badge.gratings if grating.code), badge.gratings[0])
    reference = coded.code.reference_cell if coded.code else 0
    found = decoded.payload.hex() if decoded and decoded.payload else None
    verdict, reason, score = _compare(decoded, found, claimed_id)
    return Identity(
        verdict,
        (reason,),
        decoded_id=found,
        claimed_id=claimed_id,
        beat_period_mm=float(beat_period_mm(readings[reference].frequency_per_mm)),
        expected_beat_period_mm=float(beat_period_mm(1 / coded.cells[reference].pitch_mm - 1 / badge.lens.pitch_mm)),
        symbol_errors_corrected=decoded.corrected if decoded else 0,
        score=score,
    )


def _compare(
    decoded: Decoded | None, found: str | None, claimed_id: str | None
) -> tuple[IdentityVerdict, Reason, float | None]:
    """Verdict, reason and score of what was read against what is claimed."""
    if decoded is None:
        text = "The board carries no identity; none was asked for."
        return "not_claimed", Reason("identity", "note", None, None, "", text), None
    margin = _margin(decoded)
    if claimed_id is None:
        text = f"The badge reads {found}." if found else "No identity can be read off the badge."
        return "not_claimed", Reason("identity", "note", found, None, "", text), margin
    if found is None:
        erased = sum(symbol is None for symbol in decoded.symbols)
        text = f"The identity cannot be read: {erased} of {len(decoded.symbols)} symbols are unclear; film from nearer."
        return "unreadable", Reason("identity", "undecided", erased, 2, "symbols", text), 0.0
    if found == claimed_id:
        text = f"The badge reads {found}, as claimed."
        return "match", Reason("identity", "pass", found, claimed_id, "", text), margin
    text = f"The badge reads {found}, but {claimed_id} is claimed."
    return "mismatch", Reason("identity", "fail", found, claimed_id, "", text), -margin


def _margin(decoded: Decoded) -> float:
    used = [abs(o) for o, symbol in zip(decoded.offsets, decoded.symbols, strict=True) if symbol is not None]
    return 1.0 - 2.0 * max(used, default=0.5)


def _cell_readings(track: Track, measurement: Measurement, grating: Grating, index: int) -> list[CellReading]:
    """One reading a cell: its strips' mean, weighted by their error bars."""
    readings = []
    for cell in range(len(grating.cells)):
        own = [
            phase for strip, phase in zip(track.strips, measurement.strips, strict=True)
            if (strip.grating, strip.cell) == (index, cell)
        ]  # fmt: skip
        # An error bar from four blocks can come out small by luck; a millicycle over 100 mm is its floor.
        sd = np.array([max(phase.frequency_sd, 1e-5) for phase in own])
        weight = 1 / sd**2 if np.all(np.isfinite(sd)) else np.ones(len(own))
        frequency = float(np.average([phase.frequency_per_mm for phase in own], weights=weight))
        turned = np.sum([np.exp(1j * phase.phase_rad).mean() for phase in own])
        phase_sd = float(np.median([np.median(phase.phase_sd_rad) for phase in own]))
        frequency_sd = math.sqrt(1 / weight.sum()) if np.all(np.isfinite(sd)) else math.inf
        readings.append(CellReading(frequency, frequency_sd, float(np.angle(turned)), phase_sd))
    return readings
