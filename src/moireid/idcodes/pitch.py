"""The pitch family (beat-frequency identity), and the arithmetic of beat levels that every family uses.

A grating of this family is cut into bands across the fringes, each with its own printed pitch.  One band is the
reference.  Each other band carries four bits as its beat level, read as a *difference* against the reference; ten bands
carry 24 bits.  The first functions convert beat levels to pitches, and frequencies to levels, for the uniform cells of
any family.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from moireid.badge import Cell, Code, Grating
from moireid.errors import CodeError
from moireid.frames import own_rect
from moireid.idcodes.family import CellReading, DecodeResult
from moireid.idcodes.words import SYMBOL_BITS, WORD_SYMBOLS, decode_word, encode_word
from moireid.optics import rear_pitch_for_beat_mm

#: A reading is unclear if it is further than this from every level, in steps, or if its error bar is larger.
UNCLEAR_BEYOND_STEPS = 0.35


def code_of(grating: Grating) -> Code:
    """The grating's code.  Raises: CodeError where it carries none."""
    if grating.code is None:
        raise CodeError("this grating carries no code; it can be checked for motion alone")
    return grating.code


def level_pitch_mm(code: Code, level: int, front_pitch_mm: float) -> float:
    """Printed pitch of a beat level under that front pitch.

    Convention: as `optics.beat_frequency_per_mm` at infinite distance.  Source: p = 1 / (1/p_f + f).
    """
    frequency = code.base_frequency_per_mm + code.frequency_step_per_mm * level
    return float(rear_pitch_for_beat_mm(front_pitch_mm, frequency))


def line_up(cell: Cell, grating: Grating, pitch_mm: float, shift: float = 0.0) -> Cell:
    """The cell with that pitch: a dark line is centred on the grating's middle, then moved by `shift` of a pitch.

    With this common line the fringes of all uniform cells meet in the middle of a badge built without twist.
    """
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    middle_mm = (low + high) / 2
    return replace(cell, pitch_mm=pitch_mm, edge_mm=middle_mm + (shift - cell.duty / 2) * pitch_mm)


def steps_from_reference(readings: Sequence[CellReading], grating: Grating) -> list[tuple[float, float]]:
    """Level of each cell less that of the reference, in steps with standard deviation; unread cells are infinite.

    Convention: page scale drops out, as markers and lines are printed together; lens pitch, distance and tilt shift
    all cells alike and drop out of the difference.
    """
    code = code_of(grating)
    reference = readings[code.reference_cell]
    found = []
    for reading in readings:
        steps = (reading.frequency_per_mm - reference.frequency_per_mm) / code.frequency_step_per_mm
        sd = math.hypot(reading.frequency_sd, reference.frequency_sd) / abs(code.frequency_step_per_mm)
        found.append((steps, sd if math.isfinite(steps) else math.inf))
    return found


LEVELS = 2**SYMBOL_BITS
BANDS = WORD_SYMBOLS + 1


class PitchFamily:
    """The pitch family: bands of uniform pitch, read as differences of beat frequency.  It carries 24 bits.

    Notes
    -----
    Convention: one band is the reference.  Each other band carries four bits as its beat level against the reference.
    Source: `moireid.optics.beat_frequency_per_mm`.  Differences of beats cancel lens pitch, print scale and distance
    to first order (docs/explanation/physics.md).
    """

    name = "pitch"

    def write(
        self, payload: bytes, gratings: tuple[Grating, ...], front_pitch_mm: float
    ) -> tuple[tuple[Cell, ...], ...]:
        """Set the pitches of the first grating's bands so that they spell a payload.

        Parameters
        ----------
        payload : bytes
            3 bytes.
        gratings : tuple of Grating
            One grating, its bands from the first to the last.
        front_pitch_mm : float
            Pitch of the lenses or of the mask, mm.

        Returns
        -------
        tuple of tuple of Cell
            The bands of that grating.

        Raises
        ------
        CodeError
            Where the payload or the number of bands does not fit.

        Notes
        -----
        Convention: the reference band has the code's reference level.
        Source: `level_pitch_mm`, p_r = 1 / (1/p_f + f).
        """
        grating, code = gratings[0], _code(gratings)
        symbols = iter(encode_word(payload))
        cells = []
        for role, cell in zip(code.roles, grating.cells, strict=True):
            level = (code.reference_level or 0) if role == "reference" else next(symbols)
            cells.append(line_up(cell, grating, level_pitch_mm(code, level, front_pitch_mm)))
        return (tuple(cells),)

    def read(self, readings: Sequence[Sequence[CellReading]], gratings: tuple[Grating, ...]) -> DecodeResult:
        """Decode one reading a band: the nearest level, erasing what is unclear, then the word.

        Parameters
        ----------
        readings : sequence of sequence of CellReading
            One a band, of the first grating.
        gratings : tuple of Grating
            Their layout and code.

        Returns
        -------
        DecodeResult
            With `partial` None, as this family's words are too short to compare.

        Raises
        ------
        CodeError
            Where the grating carries no code of this family.

        Notes
        -----
        Convention and source: `steps_from_reference` and `moireid.idcodes.words`.
        """
        code = _code(gratings)
        symbols: list[int | None] = []
        distances = []
        for role, (steps, sd) in zip(code.roles, steps_from_reference(readings[0], gratings[0]), strict=True):
            if role == "reference":
                continue
            level = steps + (code.reference_level or 0)
            nearest = round(level) if math.isfinite(sd) else -1
            distances.append(abs(level - nearest) if math.isfinite(sd) else 0.5)
            clear = distances[-1] <= UNCLEAR_BEYOND_STEPS and sd <= UNCLEAR_BEYOND_STEPS
            symbols.append(nearest if clear and 0 <= nearest < code.levels else None)
        found = decode_word(symbols)
        margin = 1.0 - 2.0 * sorted(distances)[len(distances) // 2]
        payload, corrected = found or (None, 0)
        return DecodeResult(payload, len(symbols), symbols.count(None), corrected, margin)


def _code(gratings: tuple[Grating, ...]) -> Code:
    """The code of the first grating, checked against what this family writes."""
    code = code_of(gratings[0])
    bands = sum(role == "beat" for role in code.roles)
    if code.levels != LEVELS or code.reference_level is None or bands != WORD_SYMBOLS or "phase" in code.roles:
        raise CodeError(
            f"a pitch code has {WORD_SYMBOLS} bands of {LEVELS} levels and a reference; this one has {bands}"
        )
    return code
