"""Identities as line spacing: the code word, and the bands that spell it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from moireid.badge import Badge, Cell, Code, Grating
from moireid.errors import CodeError
from moireid.idcodes import CellReading, PitchFamily, family_named
from moireid.idcodes.short_words import WORD_SYMBOLS, decode_word, encode_word

PAYLOADS = [bytes.fromhex(text) for text in ("38c1c2", "000000", "ffffff", "0102f0", "a5000f")]
FAMILY = PitchFamily()
FRONT = 0.508
SURE = 1e-4


# The code word, written out again: GF(16) by x^4 + x + 1, generator (x - 1)(x - a), CRC-32 bit by bit.


def times(a: int, b: int) -> int:
    """Product in GF(16) with the polynomial x^4 + x + 1."""
    product = 0
    for bit in range(4):
        if b >> bit & 1:
            product ^= a << bit
    for bit in (6, 5, 4):
        if product >> bit & 1:
            product ^= 0b10011 << (bit - 4)
    return product


def value_at(word: tuple[int, ...], x: int) -> int:
    """The word as a polynomial, first symbol highest, at x (Horner)."""
    value = 0
    for symbol in word:
        value = times(value, x) ^ symbol
    return value


def crc32_low_byte(data: bytes) -> int:
    """Low byte of CRC-32 (ISO 3309), bit by bit."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    return ~crc & 0xFF


@pytest.mark.parametrize("payload", PAYLOADS, ids=bytes.hex)
def test_word_is_payload_check_and_parity(payload: bytes) -> None:
    """Catches: nibbles swapped, another check, another code than the documented one; old badges must stay legible."""
    word = encode_word(payload)
    check = crc32_low_byte(payload)
    assert len(word) == WORD_SYMBOLS == 10
    assert word[:8] == tuple(nibble for byte in (*payload, check) for nibble in divmod(byte, 16))
    assert [value_at(word, root) for root in (1, 2)] == [0, 0]
    assert decode_word(word) == (payload, 0)


def test_words_of_two_payloads_differ_in_three_symbols_at_least(rng: np.random.Generator) -> None:
    """Catches: parity that does not depend on some symbol."""
    payloads = {bytes(row) for row in rng.integers(0, 256, (60, 3), dtype=np.uint8)}
    payloads |= {bytes([a, b, c]) for a, b, c in itertools.product((0, 1, 16), repeat=3)}
    words = [encode_word(payload) for payload in sorted(payloads)]
    nearest = min(sum(x != y for x, y in zip(a, b, strict=True)) for a, b in itertools.combinations(words, 2))
    assert nearest >= 3


@pytest.mark.parametrize("payload", PAYLOADS, ids=bytes.hex)
def test_every_single_wrong_symbol_is_mended(payload: bytes) -> None:
    """Catches: positions that the decoder cannot reach, and a count of corrections that is not one."""
    word = list(encode_word(payload))
    for place, wrong in itertools.product(range(WORD_SYMBOLS), range(16)):
        if wrong != word[place]:
            assert decode_word([*word[:place], wrong, *word[place + 1 :]]) == (payload, 1)


@pytest.mark.parametrize("payload", PAYLOADS, ids=bytes.hex)
def test_every_one_or_two_erased_symbols_are_filled_in_and_three_are_not(payload: bytes) -> None:
    """Catches: an erased symbol taken for a zero that was read, erasures not counted, a guess at three."""
    word = encode_word(payload)
    for count, mended in ((1, True), (2, True), (3, False)):
        for places in itertools.combinations(range(WORD_SYMBOLS), count):
            read = [None if place in places else symbol for place, symbol in enumerate(word)]
            assert decode_word(read) == ((payload, count) if mended else None)


def test_one_wrong_symbol_beside_an_erased_one_is_never_taken_for_the_payload(rng: np.random.Generator) -> None:
    """Catches: a decoder that goes beyond its two parity symbols (2 errors + erasures <= 2)."""
    payload = PAYLOADS[0]
    word = encode_word(payload)
    for erased, place in itertools.permutations(range(WORD_SYMBOLS), 2):
        read: list[int | None] = list(word)
        read[erased], read[place] = None, word[place] ^ int(rng.integers(1, 16))
        outcome = decode_word(read)
        assert outcome is None or outcome[0] != payload


def test_two_wrong_symbols_never_give_the_payload_back(rng: np.random.Generator) -> None:
    """Catches: a correction claimed beyond capacity.  Another word may be nearer, and says so by one correction."""
    payload, strange = PAYLOADS[3], 0
    word = encode_word(payload)
    trials = 4000
    for _ in range(trials):
        read = list(word)
        for place in rng.choice(WORD_SYMBOLS, 2, replace=False):
            read[place] ^= int(rng.integers(1, 16))
        outcome = decode_word(read)
        if outcome is not None:
            strange += 1
            assert outcome[0] != payload and outcome[1] == 1
    # The check byte lets one in 256 pass of those that the code takes for a neighbour's, which is no more than all.
    assert strange <= binom.isf(1e-6, trials, 1 / 256)


@pytest.mark.parametrize(
    ("erased", "expected"), [(0, (1 + 10 * 15) / 16**2 / 256), (1, 1 / 16 / 256), (2, 1 / 256)], ids=["0", "1", "2"]
)
def test_random_words_are_accepted_as_rarely_as_the_code_allows(
    erased: int, expected: float, rng: np.random.Generator
) -> None:
    """Catches: a check byte that is not held against the payload (0.59), a code that corrects nothing (1.5e-5), and one
    erased symbol beside one wrong one "mended" though two parity symbols cannot (0.0025 in place of 0.00024).

    Of the 16^10 words, each of 16^8 code words takes its 150 neighbours along; an erased symbol leaves one parity
    symbol, which is spent on being held against, and two leave none.  The check byte passes one in 256.
    """
    if not erased:
        assert expected == pytest.approx(0.0023, abs=5e-5)  # as the docstring of words.py says
    trials, accepted = 15000, 0
    for row in rng.integers(0, 16, (trials, WORD_SYMBOLS)):
        places = rng.choice(WORD_SYMBOLS, erased, replace=False)
        accepted += decode_word([None if k in places else int(s) for k, s in enumerate(row)]) is not None
    assert binom.ppf(1e-6, trials, expected) <= accepted <= binom.isf(1e-6, trials, expected)


def test_words_of_another_length_are_refused() -> None:
    """Catches: a short payload padded in silence."""
    for payload in (b"", b"ab", b"abcd"):
        with pytest.raises(CodeError, match="6 hex digits"):
            encode_word(payload)
    for count in (0, 9, 11):
        with pytest.raises(CodeError, match="10 symbols"):
            decode_word([0] * count)


# The bands.


def grating(*, axis: str = "x", step: float = -0.004, first_level: int = -3, reference: int = 4) -> Grating:
    """Eleven bands that nothing is symmetric in: off the page's middle, duty 0.4, the reference not in the middle."""
    rects = [(12.0, 30.0 + 5 * k, 131.0, 35.0 + 5 * k) for k in range(11)]
    whole = (12.0, 30.0, 131.0, 85.0)
    if axis == "y":
        rects = [(y0, x0, y1, x1) for x0, y0, x1, y1 in rects]
        whole = (30.0, 12.0, 85.0, 131.0)
    cells = tuple(Cell(rect, 0.52, 0.0, 0.4) for rect in rects)
    code = Code(reference, step, 16, math.copysign(0.045, step), first_level)
    return Grating(whole, axis, 0.52, "pitch", cells, code)  # type: ignore[arg-type]


def written(payload: bytes, **layout: object) -> Grating:
    blank = grating(**layout)  # type: ignore[arg-type]
    return replace(blank, cells=FAMILY.write(payload, blank, FRONT))


def ideal(badge_grating: Grating, *, front: float = FRONT) -> list[CellReading]:
    """Readings of a perfect reader: the beat of each band's pitch under the sheet as it really is."""
    return [CellReading(1 / cell.pitch_mm - 1 / front, SURE, 0.0, 0.01) for cell in badge_grating.cells]


def off(readings: list[CellReading], band: int, **changes: float) -> list[CellReading]:
    """The readings with one band's frequency moved (`by`) or its error bar set (`sd`)."""
    one = readings[band]
    moved = replace(one, frequency_per_mm=one.frequency_per_mm + changes.get("by", 0.0))
    return [*readings[:band], replace(moved, frequency_sd=changes.get("sd", one.frequency_sd)), *readings[band + 1 :]]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(("step", "first_level"), [(-0.004, -3), (0.0035, -12), (-0.002, 0), (0.004, 5)])
def test_what_is_written_is_read(axis: str, step: float, first_level: int, rng: np.random.Generator) -> None:
    """Catches: levels counted from the wrong end, a reference that carries a symbol, bands in another order."""
    for _ in range(20):
        payload = rng.bytes(3)
        bands = written(payload, axis=axis, step=step, first_level=first_level)
        decoded = FAMILY.read(ideal(bands), bands)
        assert (decoded.payload, decoded.corrected) == (payload, 0)
        assert decoded.symbols == encode_word(payload)
        assert np.abs(decoded.offsets).max() < 1e-9


def test_symbols_are_steps_of_beat_frequency_from_the_reference() -> None:
    """Catches: steps of pitch in place of frequency, and the sign of the step dropped."""
    bands = written(PAYLOADS[3], step=-0.004, first_level=-3, reference=4)
    beats = [1 / cell.pitch_mm - 1 / FRONT for cell in bands.cells]
    assert beats[4] == pytest.approx(-0.045)
    others = [beat for band, beat in enumerate(beats) if band != 4]
    assert others == pytest.approx([-0.045 - 0.004 * (symbol - 3) for symbol in encode_word(PAYLOADS[3])])


@pytest.mark.parametrize("axis", ["x", "y"])
def test_every_band_has_a_dark_line_centred_on_the_gratings_middle(axis: str) -> None:
    """Catches: bands aligned at an edge, whose fringes never line up, or along the wrong axis."""
    bands = written(PAYLOADS[0], axis=axis)
    for cell in bands.cells:
        lines = (71.5 - (cell.edge_mm + cell.duty * cell.pitch_mm / 2)) / cell.pitch_mm
        assert lines == pytest.approx(round(lines), abs=1e-9)
        assert cell.duty == 0.4
    assert [cell.rect_mm for cell in bands.cells] == [cell.rect_mm for cell in grating(axis=axis).cells]


@pytest.mark.parametrize("scale", [0.992, 0.997, 1.003, 1.008])
def test_print_scale_and_lens_pitch_drop_out(scale: float) -> None:
    """Catches: absolute beats in place of differences.  In page units a print 0.5 % too large is a lens 0.5 % too fine;
    at 0.8 % every beat moves by four of the steps."""
    bands = written(PAYLOADS[4], step=-0.004)
    readings = ideal(bands, front=FRONT * scale)
    assert abs(readings[0].frequency_per_mm - ideal(bands)[0].frequency_per_mm) > 0.005
    decoded = FAMILY.read(readings, bands)
    assert (decoded.payload, decoded.corrected) == (PAYLOADS[4], 0)


def test_a_camera_near_by_moves_no_symbol() -> None:
    """Catches: a decoder that needs the distance: at 0.4 m every beat moves by 0.7 steps, differences by 0.2 %."""
    bands = written(PAYLOADS[0], step=-0.004)
    readings = [
        CellReading((1 + 0.6 / 400.0) / cell.pitch_mm - 1 / FRONT, SURE, 0.0, 0.01) for cell in bands.cells
    ]  # fmt: skip
    decoded = FAMILY.read(readings, bands)
    assert (decoded.payload, decoded.corrected) == (PAYLOADS[0], 0)
    assert np.abs(decoded.offsets).max() < 0.05


def test_reading_does_not_look_at_the_pitches_of_the_badge_it_is_given() -> None:
    """Catches: a decoder that peeks at the claimed badge and so finds what it is told to find."""
    mine, claimed = written(PAYLOADS[0]), written(PAYLOADS[2])
    assert FAMILY.read(ideal(mine), claimed).payload == PAYLOADS[0]


def test_mirrored_fringes_do_not_read_as_the_payload() -> None:
    """Catches: |f| in place of f, with which a mirrored film would pass."""
    bands = written(PAYLOADS[0])
    turned = [replace(reading, frequency_per_mm=-reading.frequency_per_mm) for reading in ideal(bands)]
    assert FAMILY.read(turned, bands).payload != PAYLOADS[0]


def test_a_band_read_as_its_neighbour_is_mended_and_counted() -> None:
    """Catches: corrections that are made but not told."""
    bands = written(PAYLOADS[0], step=-0.004)
    symbols = encode_word(PAYLOADS[0])
    for band in (0, 5, 10):
        symbol = symbols[band - (band > 4)]
        away = -0.004 if symbol < 15 else 0.004
        decoded = FAMILY.read(off(ideal(bands), band, by=away), bands)
        assert (decoded.payload, decoded.corrected) == (PAYLOADS[0], 1)
        assert decoded.symbols[band - (band > 4)] == symbol + (1 if symbol < 15 else -1)


@pytest.mark.parametrize(("steps", "kept"), [(0.3, True), (-0.34, True), (0.36, False), (0.5, False), (-0.36, False)])
def test_a_reading_near_the_point_of_confusion_is_erased(steps: float, kept: bool) -> None:
    """Catches: rounding whatever comes, and offsets of the wrong sign or unit."""
    bands = written(PAYLOADS[0], step=-0.004)
    decoded = FAMILY.read(off(ideal(bands), 7, by=-0.004 * steps), bands)
    assert (decoded.symbols[6] is not None) == kept
    assert decoded.payload == PAYLOADS[0]
    assert decoded.corrected == (0 if kept else 1)
    assert decoded.offsets[6] == pytest.approx(steps - round(steps), abs=1e-6)


def test_error_bars_erase_and_two_erased_bands_cost_nothing() -> None:
    """Catches: error bars left out, so that a wrong reading with a large bar counts as a symbol."""
    bands = written(PAYLOADS[1], step=-0.004)
    readings = ideal(bands)
    for band in (2, 9):
        readings = off(readings, band, by=0.0113, sd=0.0041)
    decoded = FAMILY.read(readings, bands)
    assert (decoded.payload, decoded.corrected) == (PAYLOADS[1], 2)
    assert [place for place, symbol in enumerate(decoded.symbols) if symbol is None] == [2, 8]
    assert FAMILY.read(off(readings, 0, sd=math.inf), bands).payload is None
    assert FAMILY.read(off(ideal(bands), 3, sd=0.0013), bands).corrected == 0  # under 0.35 steps


def test_the_references_error_bar_is_everybodys() -> None:
    """Catches: a reference that is trusted whatever its bar; the bars add as squares."""
    bands = written(PAYLOADS[0], step=-0.004)
    assert FAMILY.read(off(ideal(bands), 4, sd=0.0016), bands).symbols == (None,) * 10
    assert FAMILY.read(off(ideal(bands), 4, sd=0.0013), bands).payload == PAYLOADS[0]
    both = [replace(reading, frequency_sd=0.0011) for reading in ideal(bands)]
    assert FAMILY.read(both, bands).payload is None


@pytest.mark.parametrize("steps", [1.0, -1.0, 0.5])
def test_a_wrong_reference_never_reads_as_the_payload(steps: float) -> None:
    """Catches: a reference that is not subtracted.  Off by one step it moves every symbol by one."""
    bands = written(PAYLOADS[4], step=-0.004)
    decoded = FAMILY.read(off(ideal(bands), 4, by=-0.004 * steps), bands)
    assert decoded.payload != PAYLOADS[4]
    if abs(steps) == 1.0:
        expected = [symbol - int(steps) for symbol in encode_word(PAYLOADS[4])]
        assert decoded.symbols == tuple(symbol if 0 <= symbol < 16 else None for symbol in expected)


@pytest.mark.parametrize("frequency", [math.nan, math.inf, -math.inf, 1e308])
def test_a_reading_that_is_no_number_is_erased(frequency: float) -> None:
    """Catches: int(nan), and a symbol made of garbage."""
    bands = written(PAYLOADS[0])
    readings = ideal(bands)
    readings[8] = replace(readings[8], frequency_per_mm=frequency)
    decoded = FAMILY.read(readings, bands)
    assert (decoded.payload, decoded.symbols[7]) == (PAYLOADS[0], None)
    assert FAMILY.read([replace(r, frequency_sd=math.nan) for r in ideal(bands)], bands).payload is None


def test_levels_beyond_the_alphabet_are_erased_not_wrapped() -> None:
    """Catches: symbol -1 read as 15, or 16 as 0."""
    bands = written(PAYLOADS[1], step=-0.004)
    assert encode_word(PAYLOADS[1])[0] == 0
    assert FAMILY.read(off(ideal(bands), 0, by=0.004), bands).symbols[0] is None
    full = written(PAYLOADS[2], step=-0.004)
    assert encode_word(PAYLOADS[2])[0] == 15
    assert FAMILY.read(off(ideal(full), 0, by=-0.004), full).symbols[0] is None


def test_gratings_that_carry_no_pitch_code_are_refused() -> None:
    """Catches: a wrong number of bands or levels that is read off by one in silence."""
    bands = written(PAYLOADS[0])
    assert bands.code is not None
    wrong = [
        replace(bands, code=None),
        replace(bands, cells=bands.cells[:-1]),
        replace(bands, code=replace(bands.code, levels=8)),
    ]
    for one in wrong:
        for use in (
            lambda g: FAMILY.payload_bits(g),
            lambda g: FAMILY.write(b"abc", g, FRONT),
            lambda g: FAMILY.read(ideal(g), g),
        ):
            with pytest.raises(CodeError, match="11 bands of 16 levels"):
                use(one)
    assert FAMILY.payload_bits(bands) == 24


def test_families_are_found_by_name() -> None:
    """Catches: any name that ends up with the pitch family."""
    assert isinstance(family_named("pitch"), PitchFamily)
    with pytest.raises(CodeError, match=r"'uniform' is not known.*pitch"):
        family_named("uniform")


def test_the_default_badge_reads_as_its_own_id(ada: Badge) -> None:
    """Catches: a designer that writes by another convention than the reader's."""
    bands = ada.gratings[0]
    decoded = FAMILY.read(ideal(bands, front=ada.lens.pitch_mm * 1.004), bands)
    assert decoded.payload is not None and decoded.payload.hex() == ada.id
