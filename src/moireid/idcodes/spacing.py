"""Non-uniform line spacing: cells whose lines are shifted by quarters of the pitch, between uniform rows.

A line shift of s in a cell shifts the phase of its fringe by -2 pi s / p, wherever the camera is.  So the phase of each
cell against the uniform rows is its symbol.  Four cells make a byte of the word (first cell highest).  Cells of several
gratings, in order, make one word.

The uniform rows also carry a personal beat: the payload determines the beat level of each.  The differences of the
measured beats must be those of the payload, and the word and the beats must agree.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from moireid.badge import Cell, Grating
from moireid.errors import CodeError
from moireid.idcodes.family import CellReading, DecodeResult
from moireid.idcodes.pitch import UNCLEAR_BEYOND_STEPS, code_of, level_pitch_mm, line_up, steps_from_reference
from moireid.idcodes.words import MAX_TRIES, WordCode
from moireid.layers import is_smooth

#: Phases of a cell, two bits each; half a step is pi / 4.
PHASE_LEVELS = 4
CELLS_PER_BYTE = 4
#: Order of symbols around the circle, such that neighbours differ in one bit (Gray).
_GRAY = (0, 1, 3, 2)
#: A phase is unclear if it is nearer than this to the border between two symbols, in steps, or has such an error bar.
UNCLEAR_BEYOND_TURNS = 0.35


class SpacingFamily:
    """The spacing family: cells of shifted lines between uniform rows of a personal beat.  It carries 64 or 128 bits.

    Notes
    -----
    Convention: a line shift of s in a cell moves its fringe phase by -2 pi s / p_r, wherever the camera is.  Four cells
    make a byte of the word, the first cell its highest two bits.
    Source: the phase follows from the superposition of two gratings; the word is Reed-Solomon over GF(256).
    """

    name = "spacing"

    def write(
        self, payload: bytes, gratings: tuple[Grating, ...], front_pitch_mm: float
    ) -> tuple[tuple[Cell, ...], ...]:
        """Write a payload into the cells of all gratings.

        Parameters
        ----------
        payload : bytes
            8 or 16 bytes, as the gratings' code says.
        gratings : tuple of Grating
            Their cells, in order, make one word.
        front_pitch_mm : float
            Pitch of the lenses or of the mask, mm.

        Returns
        -------
        tuple of tuple of Cell
            The cells of each grating.

        Raises
        ------
        CodeError
            Where the payload or the number of cells does not fit.

        Notes
        -----
        Convention: symbol place k of `PHASE_LEVELS` moves the lines by -k / `PHASE_LEVELS` of the pitch, which moves
        the fringe phase by +2 pi k / `PHASE_LEVELS`.
        Source: `moireid.idcodes.words` for the word; `beat_levels` for the uniform rows.
        """
        places = itertools.chain(word_places(word_of(gratings), payload), itertools.repeat(0))
        levels = (beat_levels(payload, gratings, index) for index in range(len(gratings)))
        return tuple(
            lined_up(grating, places, own, front_pitch_mm) for grating, own in zip(gratings, levels, strict=True)
        )

    def read(self, readings: Sequence[Sequence[CellReading]], gratings: tuple[Grating, ...]) -> DecodeResult:
        """Decode one reading a cell: nearest phase, doubts by distance and error bar, the word, then the beats.

        Parameters
        ----------
        readings : sequence of sequence of CellReading
            One a cell, in the order of the gratings' cells.
        gratings : tuple of Grating
            Their layout and code.

        Returns
        -------
        DecodeResult
            Its payload is None where the readings spell none.

        Raises
        ------
        CodeError
            Where a grating carries no code.

        Notes
        -----
        Convention: a reading's phase is against the field of the reference row.
        Source: `moireid.idcodes.words`; `moireid.idcodes.pitch.steps_from_reference` for the beats.
        """
        word = word_of(gratings)
        cells = [
            (reading.phase_rad, reading.phase_sd)
            for grating, row in zip(gratings, readings, strict=True)
            for role, reading in zip(code_of(grating).roles, row, strict=True)
            if role == "phase"
        ]
        used = CELLS_PER_BYTE * word.word_bytes
        found, doubts = _decode(word, cells[:used])
        middle = sorted(doubts)[used // 2]
        margin = 1.0 - 2.0 * min(middle, 0.5)
        by_byte = [doubts[k : k + CELLS_PER_BYTE] for k in range(0, used, CELLS_PER_BYTE)]
        unclear = sum(max(of_byte) > UNCLEAR_BEYOND_TURNS for of_byte in by_byte)
        if found is None:
            return DecodeResult(None, word.word_bytes, unclear, 0, margin)
        payload, corrected = found
        return DecodeResult(
            payload, word.word_bytes, unclear, corrected, margin, _beats_agree(payload, readings, gratings)
        )


def lined_up(grating: Grating, places: Iterator[int], levels: Sequence[int], front_pitch_mm: float) -> tuple[Cell, ...]:
    """Place the lines of a grating's cells.

    Parameters
    ----------
    grating : Grating
        Its cells' places and roles.
    places : iterator of int
        On the circle, one is taken for each phase cell in order.
    levels : sequence of int
        Beat level of each uniform cell in order.
    front_pitch_mm : float
        Pitch of the lenses or of the mask, mm.

    Returns
    -------
    tuple of Cell
        In the order of the grating's cells; of a smooth grating they are counted as it needs them
        (`moireid.smooth_lines.smoothest`).

    Raises
    ------
    CodeError
        Where the grating carries no code.

    Notes
    -----
    Convention: as `SpacingFamily.write`.
    """
    from moireid.smooth_lines import smoothest

    code, uniform = code_of(grating), iter(levels)
    reference = level_pitch_mm(code, levels[_middle(grating)], front_pitch_mm)
    cells = tuple(
        line_up(cell, grating, reference, -next(places) / PHASE_LEVELS)
        if role == "phase"
        else line_up(cell, grating, level_pitch_mm(code, next(uniform), front_pitch_mm))
        for role, cell in zip(code.roles, grating.cells, strict=True)
    )
    return smoothest(replace(grating, cells=cells)) if is_smooth(grating) else cells


def beat_levels(payload: bytes, gratings: tuple[Grating, ...], index: int) -> list[int]:
    """Beat levels of the uniform cells of one grating, drawn from the payload by SHA-256."""
    code = code_of(gratings[index])
    digest = hashlib.sha256(b"moireid/beats/1/" + bytes([index]) + payload).digest()
    uniform = sum(role != "phase" for role in code.roles)
    # The phase cells have the reference row's beat; the lower half of the levels blurs least in a small picture.
    middle = _middle(gratings[index])
    return [digest[k] % (code.levels // 2 if k == middle else code.levels) for k in range(uniform)]


def _beats_agree(
    payload: bytes, readings: Sequence[Sequence[CellReading]], gratings: tuple[Grating, ...]
) -> bool | None:
    """Whether each clearly read uniform cell has the payload's beat difference; None where no cell is read.

    A difference is wrong beyond half a step plus three error bars: with an error bar of 0.2 steps, half a step alone
    would reject every tenth true row.
    """
    compared = 0
    for index, grating in enumerate(gratings):
        code, levels = code_of(grating), beat_levels(payload, gratings, index)
        reference = levels[_middle(grating)]
        steps = steps_from_reference(readings[index], grating)
        uniform = [found for role, found in zip(code.roles, steps, strict=True) if role != "phase"]
        for place, (level, (measured, sd)) in enumerate(zip(levels, uniform, strict=True)):
            if place == _middle(grating) or sd > UNCLEAR_BEYOND_STEPS:
                continue
            if abs(measured - (level - reference)) > 0.5 + 3.0 * sd:
                return False
            compared += 1
    return True if compared else None


def _middle(grating: Grating) -> int:
    """Place of the reference cell among the uniform cells."""
    code = code_of(grating)
    return sum(role != "phase" for role in code.roles[: code.reference_cell])


def word_of(gratings: tuple[Grating, ...]) -> WordCode:
    """The code of the word that all phase cells of the gratings spell.  Raises: CodeError where they spell none."""
    cells = sum(role == "phase" for grating in gratings for role in code_of(grating).roles)
    bits = {code_of(grating).payload_bits for grating in gratings}
    phases = {code_of(grating).phase_levels for grating in gratings}
    if len(bits) != 1 or phases != {PHASE_LEVELS}:
        raise CodeError(f"a spacing code has cells of {PHASE_LEVELS} phases and one payload over all gratings")
    return WordCode(bits.pop() // 8, min(cells // CELLS_PER_BYTE, 255))


def _places(octet: int) -> list[int]:
    """Places on the circle of the four symbols of a byte, first symbol highest."""
    return [_GRAY.index(octet >> shift & 3) for shift in (6, 4, 2, 0)]


def _octet(places: Sequence[int]) -> int:
    """The byte of four places: inverse of `_places`."""
    value = 0
    for place in places:
        value = value << 2 | _GRAY[place]
    return value


def word_places(word: WordCode, payload: bytes) -> list[int]:
    """Places on the circle of all symbols of the word that spells the payload, in the order of the cells."""
    return [place for octet in word.encode(payload) for place in _places(octet)]


def true_phases_rad(payload: bytes, gratings: tuple[Grating, ...]) -> dict[tuple[int, int], float]:
    """The true phase of each used cell, by (grating, cell), for benches that know what was printed."""
    cells = [
        (index, cell)
        for index, grating in enumerate(gratings)
        for cell, role in enumerate(code_of(grating).roles)
        if role == "phase"
    ]
    places = word_places(word_of(gratings), payload)
    return {cell: 2 * math.pi * place / PHASE_LEVELS for cell, place in zip(cells, places, strict=False)}


def decode_phases(
    word: WordCode, phase_rad: Iterable[float], phase_sd: Iterable[float], *, tries: int = MAX_TRIES
) -> bytes | None:
    """The payload spelled by phases, one for each cell in the word's order, or None; one try is a hard decision."""
    found, _ = _decode(word, list(zip(phase_rad, phase_sd, strict=True)), tries)
    return found[0] if found else None


def _decode(
    word: WordCode, cells: Sequence[tuple[float, float]], tries: int = MAX_TRIES
) -> tuple[tuple[bytes, int] | None, list[float]]:
    """Payload and number of corrected bytes, or None, and the doubt of each cell."""
    doubts = [_nearest(phase, sd)[1] for phase, sd in cells]
    weakest = [max(doubts[k : k + CELLS_PER_BYTE]) for k in range(0, len(cells), CELLS_PER_BYTE)]
    return word.decode(_octets(cells), weakest, tries), doubts


def _octets(cells: Sequence[tuple[float, float]]) -> bytes:
    """The bytes that phases and their error bars spell, each the nearest."""
    places = [_nearest(phase, sd)[0] for phase, sd in cells]
    return bytes(_octet(places[k : k + CELLS_PER_BYTE]) for k in range(0, len(cells), CELLS_PER_BYTE))


def nearest_place(phase_rad: float) -> int:
    """Nearest place of a phase on the circle."""
    return round(phase_rad / (2 * math.pi) * PHASE_LEVELS) % PHASE_LEVELS


def _nearest(phase_rad: float, phase_sd: float) -> tuple[int, float]:
    """Nearest place of a phase, and its doubt: distance and error bar in steps, infinite where it was not read."""
    if not math.isfinite(phase_sd):
        return 0, math.inf
    steps = float(phase_rad) / (2 * math.pi) * PHASE_LEVELS
    nearest = round(steps)
    return nearest % PHASE_LEVELS, abs(steps - nearest) + float(phase_sd) / (2 * math.pi) * PHASE_LEVELS
