"""The interface of a code family, and the measured figures of a cell.

A family knows three things: how many bits it carries, which cells write a payload, and which payload a set of
readings spells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from moireid.badge import Cell, Grating
from moireid.idcodes.partial import PartialWord


@dataclass(frozen=True)
class CellReading:
    """What a film tells of one cell, in page units, at infinite distance and zero parallax.

    frequency_per_mm: signed beat frequency, cycles per mm; phase_rad: fringe phase against the reference cells' field,
    near one of the code's places; each with its standard deviation, infinite where it was not or could not be read;
    free_rad: the phase without knowledge of the places, for benches.
    """

    frequency_per_mm: float
    frequency_sd: float
    phase_rad: float
    phase_sd: float
    free_rad: float = math.nan


@dataclass(frozen=True)
class Decoded:
    """The outcome of decoding, made without looking at any claim.

    payload: None where the readings spell no code word; unclear: symbols too vague to count; corrected: symbols (bytes
    of a word) that error correction changed or filled in; margin: 1 where every symbol lies on its place, 0 where the
    middle one is as near to its neighbour; beats_agree: whether the beat differences are those of the payload,
    None where none could be read;
    partial: the word as it was read, where a payload could not be made of it and the family can compare such words.
    """

    payload: bytes | None
    symbols: int
    unclear: int
    corrected: int
    margin: float
    beats_agree: bool | None = True
    partial: PartialWord | None = None


class CodeFamily(Protocol):
    """One way of writing a payload into line spacing."""

    name: str

    def write(
        self, payload: bytes, gratings: tuple[Grating, ...], front_pitch_mm: float
    ) -> tuple[tuple[Cell, ...], ...]:
        """The cells of all gratings with the payload written into their pitches and edges."""

    def read(self, readings: Sequence[Sequence[CellReading]], gratings: tuple[Grating, ...]) -> Decoded:
        """The payload that the readings spell; only the gratings' layout and code are looked at, not their pitches."""
