"""The words of the spacing code: payload, check, Reed-Solomon, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.payloads import payload_for_name
from moireid.designer import Request, design_badge
from moireid.errors import CodeError
from moireid.idcodes import CellReading, family_named, spells_its_id
from moireid.idcodes.spacing import beat_levels, true_phases_rad
from moireid.idcodes.words import CHECK_BYTES, SPARE_PARITY, WordCode, check

CODES = [WordCode(8, 26), WordCode(16, 42), WordCode(8, 16)]


@pytest.mark.parametrize("code", CODES)
def test_every_number_of_wrong_bytes_that_is_promised_is_corrected(code, rng):
    """Catches: parity miscounted, positions counted from the other end."""
    payload = rng.bytes(code.payload_bytes)
    word = code.encode(payload)
    for wrong in range(code.parity_bytes // 2 + 1):
        read = bytearray(word)
        for place in rng.choice(code.word_bytes, wrong, replace=False):
            read[place] ^= int(rng.integers(1, 256))
        assert code.decode(bytes(read), [0.1] * code.word_bytes) == (payload, wrong)


@pytest.mark.parametrize("code", CODES)
def test_doubtful_bytes_are_erased_so_that_more_are_corrected(code, rng):
    """Catches: doubts that are not looked at, or sorted the wrong way round."""
    payload = rng.bytes(code.payload_bytes)
    wrong = code.parity_bytes - SPARE_PARITY
    places = rng.choice(code.word_bytes, wrong, replace=False)
    read = bytearray(code.encode(payload))
    for place in places:
        read[place] ^= int(rng.integers(1, 256))
    doubts = [0.4 if k in places else 0.1 for k in range(code.word_bytes)]
    assert code.decode(bytes(read), doubts) == (payload, wrong)
    if wrong > code.parity_bytes // 2:
        assert code.decode(bytes(read), [0.5 - doubt for doubt in doubts]) is None
    lost = [math.inf if k in places else 0.1 for k in range(code.word_bytes)]
    assert code.decode(bytes(read), lost) == (payload, wrong)


def test_words_beyond_capacity_are_never_another_payload(rng):
    """Catches: a check that is not held against the payload, or a decoder that goes beyond what parity promises."""
    code = CODES[0]
    for extra in range(1, 9):
        for _ in range(30):
            payload = rng.bytes(8)
            read = bytearray(code.encode(payload))
            for place in rng.choice(code.word_bytes, code.parity_bytes // 2 + extra, replace=False):
                read[place] ^= int(rng.integers(1, 256))
            found = code.decode(bytes(read), list(rng.uniform(0, 0.5, code.word_bytes)))
            assert found is None or found[0] == payload
    for _ in range(200):
        assert code.decode(rng.bytes(code.word_bytes), list(rng.uniform(0, 0.5, code.word_bytes))) is None


def test_the_check_is_five_bytes_of_its_own():
    """Catches: a shorter check, which would let through more than the stated 1e-9."""
    assert len(check(b"12345678")) == CHECK_BYTES == 5
    assert check(b"12345678") != check(b"12345679")


@pytest.mark.parametrize(("payload", "word"), [(8, 15), (16, 23), (8, 256)])
def test_words_that_cannot_be_are_refused(payload, word):
    with pytest.raises(CodeError, match="bytes"):
        WordCode(payload, word)


def ideal(badge):
    """Readings as a perfect film gives them."""
    phases = true_phases_rad(bytes.fromhex(badge.id), badge.gratings)
    rows = []
    for g, grating in enumerate(badge.gratings):
        row = []
        for c, (cell, role) in enumerate(zip(grating.cells, grating.code.roles, strict=True)):
            beat = 1 / cell.pitch_mm - 1 / badge.lens.pitch_mm
            phase = phases.get((g, c), 0.0)
            row.append(
                CellReading(math.nan, math.inf, phase, 0.05)
                if role == "phase"
                else CellReading(beat, 1e-5, math.nan, math.inf)
            )
        rows.append(row)
    return rows


@pytest.mark.parametrize("axes", ["x", "xy"])
@pytest.mark.parametrize("size", [8, 16])
def test_what_is_written_is_read(axes, size, rng):
    """Catches: cells in another order in writing and reading, over one grating or two."""
    payload = rng.bytes(size)
    badge = design_badge(Request("A", axes=axes, range_m=(0.8, 1.5)), payload)
    read = family_named("spacing").read(ideal(badge), badge.gratings)
    assert (read.payload, read.corrected, read.unclear, read.beats_agree) == (payload, 0, 0, True)
    assert spells_its_id(badge)


def test_line_shifts_have_the_stated_sign_and_size():
    """Catches: lines shifted on where they should be back, which mirrors every symbol but two.

    A line shift of +s moves the fringe by -2 pi s / p, so place k has its lines moved by -k/4 of the pitch.
    """
    badge = design_badge(Request("A"), payload_for_name("A"))
    grating = badge.gratings[0]
    middle = (grating.rect_mm[0] + grating.rect_mm[2]) / 2
    for (_, c), phase in true_phases_rad(payload_for_name("A"), badge.gratings).items():
        cell = grating.cells[c]
        shift = (cell.edge_mm + cell.duty * cell.pitch_mm / 2 - middle) / cell.pitch_mm
        assert math.remainder(shift + phase / (2 * math.pi), 1.0) == pytest.approx(0.0, abs=1e-9)


def test_beats_of_another_badge_under_the_right_cells_are_noticed():
    """Catches: a beat check that always agrees."""
    badge = design_badge(Request("A"), payload_for_name("A"))
    rows = ideal(badge)
    code = badge.gratings[0].code
    beat = code.roles.index("beat")
    reading = rows[0][beat]
    rows[0][beat] = CellReading(reading.frequency_per_mm + 1.2 * code.frequency_step_per_mm, 1e-5, math.nan, math.inf)
    assert not family_named("spacing").read(rows, badge.gratings).beats_agree
    rows[0][beat] = CellReading(reading.frequency_per_mm + 1.2 * code.frequency_step_per_mm, 1.0, math.nan, math.inf)
    assert family_named("spacing").read(rows, badge.gratings).beats_agree


def test_personal_beats_differ_between_people_and_stay_within_the_levels(rng):
    badge = design_badge(Request("A"), payload_for_name("A"))
    levels = {tuple(beat_levels(rng.bytes(8), badge.gratings, 0)) for _ in range(200)}
    assert len(levels) > 100
    assert all(0 <= level < badge.gratings[0].code.levels for found in levels for level in found)


def test_phases_with_noise_are_decoded_and_half_turned_ones_are_not(rng):
    """Catches: doubts in place of phases; a decoder that reads a mirrored badge as the payload."""
    badge = design_badge(Request("A"), payload_for_name("A"))
    noisy, mirrored = ideal(badge), ideal(badge)
    for k, reading in enumerate(noisy[0]):
        if np.isfinite(reading.phase_sd):
            noisy[0][k] = CellReading(math.nan, math.inf, reading.phase_rad + 0.3 * rng.standard_normal(), 0.3)
            mirrored[0][k] = CellReading(math.nan, math.inf, -reading.phase_rad, 0.05)
    family = family_named("spacing")
    assert family.read(noisy, badge.gratings).payload == payload_for_name("A")
    assert family.read(mirrored, badge.gratings).payload is None
