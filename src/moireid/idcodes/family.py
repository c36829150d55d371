"""What every code family offers, and what a reader measures of a cell.

A family knows three things: how many bits it carries, which cells write a payload, and which payload a set of
readings spells.  The badge's grating names its family, so a reader finds the decoder by that name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from moireid.badge import Cell, Grating
from moireid.errors import CodeError


@dataclass(frozen=True)
class CellReading:
    """What a film tells of one cell, in page units, at infinite distance and zero parallax.

    frequency_per_mm: signed beat frequency, cycles per mm; phase_rad: fringe phase at the cell's centre; each with
    its standard deviation (infinite where it could not be read).
    """

    frequency_per_mm: float
    frequency_sd: float
    phase_rad: float
    phase_sd: float


@dataclass(frozen=True)
class Decoded:
    """The outcome of decoding, made without looking at any claim.

    payload: None where the readings spell no code word; symbols: as read, None for erased ones;
    corrected: symbols that error correction changed or filled in; offsets: distance of each reading from its
    symbol's place, in symbol steps, so 0.5 is the point of confusion.
    """

    payload: bytes | None
    symbols: tuple[int | None, ...]
    corrected: int
    offsets: tuple[float, ...]


class CodeFamily(Protocol):
    """One way of writing a payload into line spacing."""

    name: str

    def payload_bits(self, grating: Grating) -> int:
        """Bits that the grating's cells carry."""

    def write(self, payload: bytes, grating: Grating, front_pitch_mm: float) -> tuple[Cell, ...]:
        """The grating's cells with the payload written into their pitches and edges."""

    def read(self, readings: Sequence[CellReading], grating: Grating) -> Decoded:
        """The payload that the readings spell; only the grating's layout and code are looked at, not its pitches."""


def family_named(name: str) -> CodeFamily:
    """The family of that name.  Raises: CodeError where this version has none."""
    from moireid.idcodes.pitch import PitchFamily

    families: dict[str, CodeFamily] = {PitchFamily.name: PitchFamily()}
    if name not in families:
        raise CodeError(f"code family {name!r} is not known to this version; it reads {', '.join(families)}")
    return families[name]
