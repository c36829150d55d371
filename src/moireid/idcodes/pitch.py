"""The beat-frequency identity: a grating cut into bands across the fringes, each with its own printed pitch.

One band is the reference.  Symbol s of another band is its beat frequency, read as a *difference* against the
reference: f = f_ref + step (first_level + s), in cycles per mm of the page.  Printed with the markers, the page's
own scale drops out; lens pitch, distance and tilt shift all bands alike and drop out of the difference.

All bands have a dark line centred on the grating's middle, so that the fringes of a true badge line up there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from moireid.badge import Cell, Code, Grating
from moireid.errors import CodeError
from moireid.idcodes.family import CellReading, Decoded
from moireid.idcodes.words import PAYLOAD_BYTES, SYMBOL_BITS, WORD_SYMBOLS, decode_word, encode_word
from moireid.optics import rear_pitch_for_beat_mm

#: Symbols of one band, and bands of one grating: a word and its reference.
LEVELS = 2**SYMBOL_BITS
BANDS = WORD_SYMBOLS + 1
#: A reading further than this from any symbol's place, in steps, or with such an error bar, is erased, not guessed.
ERASE_BEYOND_STEPS = 0.35


class PitchFamily:
    """Bands of uniform pitch, read as differences of beat frequency."""

    name = "pitch"

    def payload_bits(self, grating: Grating) -> int:
        """24 bits: ten bands of four bits, less a check byte and two parity symbols."""
        self._code(grating)
        return PAYLOAD_BYTES * 8

    def write(self, payload: bytes, grating: Grating, front_pitch_mm: float) -> tuple[Cell, ...]:
        """The grating's bands with their pitches set to spell `payload` (3 bytes).

        Convention: frequencies as `optics.beat_frequency_per_mm` at infinite distance, under the nominal front pitch.
        Source: p = 1 / (1/p_f + f), one band at a time.
        Raises: CodeError where the payload or the number of bands does not fit.
        """
        code = self._code(grating)
        symbols = iter(encode_word(payload))
        low, high = (0, 2) if grating.axis == "x" else (1, 3)
        middle_mm = (grating.rect_mm[low] + grating.rect_mm[high]) / 2
        cells = []
        for index, cell in enumerate(grating.cells):
            steps = 0 if index == code.reference_cell else code.first_level + next(symbols)
            frequency = code.base_frequency_per_mm + code.frequency_step_per_mm * steps
            pitch_mm = float(rear_pitch_for_beat_mm(front_pitch_mm, frequency))
            cells.append(replace(cell, pitch_mm=pitch_mm, edge_mm=middle_mm - cell.duty * pitch_mm / 2))
        return tuple(cells)

    def read(self, readings: Sequence[CellReading], grating: Grating) -> Decoded:
        """Decode one reading a band.

        Convention: the reading of the reference band is subtracted from each; its error bar adds to theirs.
        Source: nearest symbol, erasing what is nearer to the point of confusion than `ERASE_BEYOND_STEPS` allows,
        then Reed-Solomon and the check byte of `words`.
        """
        code = self._code(grating)
        reference = readings[code.reference_cell]
        symbols: list[int | None] = []
        offsets = []
        for index, reading in enumerate(readings):
            if index == code.reference_cell:
                continue
            steps = (reading.frequency_per_mm - reference.frequency_per_mm) / code.frequency_step_per_mm
            steps -= code.first_level
            error_bar = math.hypot(reading.frequency_sd, reference.frequency_sd) / abs(code.frequency_step_per_mm)
            nearest = round(steps) if math.isfinite(steps) else -1
            offsets.append(steps - nearest)
            sure = abs(steps - nearest) <= ERASE_BEYOND_STEPS and error_bar <= ERASE_BEYOND_STEPS
            symbols.append(nearest if sure and 0 <= nearest < code.levels else None)
        outcome = decode_word(symbols)
        payload, corrected = outcome if outcome else (None, 0)
        return Decoded(payload, tuple(symbols), corrected, tuple(offsets))

    def _code(self, grating: Grating) -> Code:
        """The grating's code, checked against what this family writes."""
        if grating.code is None or len(grating.cells) != BANDS or grating.code.levels != LEVELS:
            raise CodeError(
                f"a pitch code needs {BANDS} bands of {LEVELS} levels; this grating has {len(grating.cells)} bands"
                + (f" of {grating.code.levels} levels" if grating.code else " and no code")
            )
        return grating.code
