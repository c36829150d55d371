"""The interface of a code family, and the measured figures of a cell.

A family defines three things: how many bits it carries, which cells write a payload, and which payload a set of
readings spells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from moireid.badge import Cell, Grating


@dataclass(frozen=True)
class CellReading:
    """The measured figures of one cell of a grating.

    Parameters
    ----------
    frequency_per_mm : float
        Beat frequency, signed, cycles per mm of page, for a camera infinitely far away.
    frequency_sd : float
        Its standard deviation, same unit; infinite where it was not read.
    phase_rad : float
        Fringe phase against the field of the reference cells, at zero parallax, near one of the code's places.
    phase_sd : float
        Its standard deviation, rad; infinite where it was not read.
    free_rad : float
        The same phase without knowledge of the code's places, for benchmarks; nan where it is not known.

    Notes
    -----
    Convention: seen from far away the beat is 1/p_r - 1/p_f.  It is negative where the printed pitch p_r is coarser
    than the lens pitch p_f.
    Source: `moireid.optics.beat_frequency_per_mm`.
    """

    frequency_per_mm: float
    frequency_sd: float
    phase_rad: float
    phase_sd: float
    free_rad: float = math.nan


@dataclass(frozen=True)
class DecodeResult:
    """The result of decoding, made without looking at any claim.

    Attributes
    ----------
    payload : bytes or None
        None where the readings spell no code word.
    symbols : int
        Number of symbols in the word: bands of the pitch family, bytes of the spacing family.
    unclear : int
        Symbols with a reading that was too vague to count; at most `symbols`.
    corrected : int
        Symbols that error correction changed or filled in.
    margin : float
        1 where every reading lies on its place, 0 where the median one is as near to its neighbour.
    beats_agree : bool or None
        Whether the differences of the beats are those of the payload; None where no beat could be read.
    """

    payload: bytes | None
    symbols: int
    unclear: int
    corrected: int
    margin: float
    beats_agree: bool | None = True


class CodeFamily(Protocol):
    """One way of writing a payload into line spacing.

    Attributes
    ----------
    name : str
        As a badge's gratings name their family.

    Notes
    -----
    Convention: a family never sees the badge's claimed id when it reads.
    """

    name: str

    def write(
        self, payload: bytes, gratings: tuple[Grating, ...], front_pitch_mm: float
    ) -> tuple[tuple[Cell, ...], ...]:
        """Write a payload into the pitches and edges of the cells.

        Parameters
        ----------
        payload : bytes
            Of a length that the gratings' code carries.
        gratings : tuple of Grating
            The gratings with their code and with cells whose places are set.
        front_pitch_mm : float
            Pitch of the lenses or of the mask, mm.

        Returns
        -------
        tuple of tuple of Cell
            The cells of each grating, in the order of `gratings`.

        Raises
        ------
        CodeError
            Where the payload or the number of cells does not fit.
        """

    def read(self, readings: Sequence[Sequence[CellReading]], gratings: tuple[Grating, ...]) -> DecodeResult:
        """Find the payload that readings spell.

        Parameters
        ----------
        readings : sequence of sequence of CellReading
            One a cell, in the order of the gratings' cells.
        gratings : tuple of Grating
            Only their layout and code are looked at, not their pitches.

        Returns
        -------
        DecodeResult
            The payload, if one was spelt, and how clear it was.

        Raises
        ------
        CodeError
            Where a grating carries no code.
        """
