"""Identities as line spacing: the code words, the bands of the short code, and the cells of the long one."""

from __future__ import annotations

import hashlib
import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from moireid.badge import Badge, Cell, Code, Grating
from moireid.designer import Order, design_badge
from moireid.idcodes import CellReading, DecodeResult, PitchFamily, SpacingFamily
from moireid.idcodes.pitch import UNCLEAR_BEYOND_STEPS
from moireid.idcodes.words import CHECK_BYTES, WORD_SYMBOLS, WordCode, decode_word, encode_word

PAYLOADS = [bytes.fromhex(text) for text in ("38c1c2", "000000", "ffffff", "0102f0", "a5000f")]
FAMILY = PitchFamily()
FRONT = 0.508
SURE = 1e-4


# The short word, written out again: GF(16) by x^4 + x + 1, generator (x - 1)(x - a), CRC-32 bit by bit.


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


@pytest.mark.parametrize("payload", PAYLOADS, ids=bytes.hex)
def test_every_single_wrong_symbol_is_corrected(payload: bytes) -> None:
    """Catches: positions that the decoder cannot reach, and a count of corrections that is not one."""
    word = list(encode_word(payload))
    for place, wrong in itertools.product(range(WORD_SYMBOLS), range(16)):
        if wrong != word[place]:
            assert decode_word([*word[:place], wrong, *word[place + 1 :]]) == (payload, 1)


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


# The bands of the short code.


def grating(*, axis: str = "x", step: float = -0.004, reference_level: int = 3, reference: int = 4) -> Grating:
    """Eleven bands that nothing is symmetric in: off the page's middle, duty 0.4, the reference not in the middle."""
    rects = [(12.0, 30.0 + 5 * k, 131.0, 35.0 + 5 * k) for k in range(11)]
    whole = (12.0, 30.0, 131.0, 85.0)
    if axis == "y":
        rects = [(y0, x0, y1, x1) for x0, y0, x1, y1 in rects]
        whole = (30.0, 12.0, 85.0, 131.0)
    cells = tuple(Cell(rect, 0.52, 0.0, 0.4) for rect in rects)
    roles = tuple("reference" if band == reference else "beat" for band in range(11))
    code = Code(roles, 24, 16, math.copysign(0.033, step), step, reference_level=reference_level)  # type: ignore[arg-type]
    return Grating(whole, axis, 0.52, "pitch", cells, code)  # type: ignore[arg-type]


def written(payload: bytes, **layout: object) -> Grating:
    blank = grating(**layout)  # type: ignore[arg-type]
    (cells,) = FAMILY.write(payload, (blank,), FRONT)
    return replace(blank, cells=cells)


def ideal(badge_grating: Grating, *, front: float = FRONT) -> list[CellReading]:
    """Readings of a perfect reader: the beat of each band's pitch under the sheet as it really is."""
    return [CellReading(1 / cell.pitch_mm - 1 / front, SURE, math.nan, math.inf) for cell in badge_grating.cells]


def read(readings: list[CellReading], bands: Grating) -> DecodeResult:
    return FAMILY.read([readings], (bands,))


def off(readings: list[CellReading], band: int, **changes: float) -> list[CellReading]:
    """The readings with one band's frequency moved (`by`) or its error bar set (`sd`)."""
    one = readings[band]
    moved = replace(one, frequency_per_mm=one.frequency_per_mm + changes.get("by", 0.0))
    return [*readings[:band], replace(moved, frequency_sd=changes.get("sd", one.frequency_sd)), *readings[band + 1 :]]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(("step", "reference_level"), [(-0.004, 3), (0.0035, 12), (-0.002, 0), (0.004, 15)])
def test_what_is_written_is_read(axis: str, step: float, reference_level: int, rng: np.random.Generator) -> None:
    """Catches: levels counted from the wrong end, a reference that carries a symbol, bands in another order."""
    for _ in range(20):
        payload = rng.bytes(3)
        bands = written(payload, axis=axis, step=step, reference_level=reference_level)
        decoded = read(ideal(bands), bands)
        assert (decoded.payload, decoded.symbols, decoded.unclear, decoded.corrected) == (payload, 10, 0, 0)
        assert decoded.margin == pytest.approx(1.0, abs=1e-9)


def test_symbols_are_levels_of_beat_frequency() -> None:
    """Catches: steps of pitch in place of frequency, the sign of the step dropped, the reference at level 0."""
    bands = written(PAYLOADS[3], step=-0.004, reference_level=3, reference=4)
    beats = [1 / cell.pitch_mm - 1 / FRONT for cell in bands.cells]
    assert beats[4] == pytest.approx(-0.033 - 3 * 0.004)
    others = [beat for band, beat in enumerate(beats) if band != 4]
    assert others == pytest.approx([-0.033 - 0.004 * symbol for symbol in encode_word(PAYLOADS[3])])


@pytest.mark.claim("Print scale and lens pitch drop out of the code")
@pytest.mark.parametrize("scale", [0.992, 0.997, 1.003, 1.008])
def test_print_scale_and_lens_pitch_drop_out(scale: float) -> None:
    """Catches: absolute beats in place of differences.  In page units a print 0.5 % too large is a lens 0.5 % too fine;
    at 0.8 % every beat moves by four of the steps."""
    bands = written(PAYLOADS[4], step=-0.004)
    readings = ideal(bands, front=FRONT * scale)
    assert abs(readings[0].frequency_per_mm - ideal(bands)[0].frequency_per_mm) > 0.005
    decoded = read(readings, bands)
    assert (decoded.payload, decoded.corrected) == (PAYLOADS[4], 0)


def test_mirrored_fringes_do_not_read_as_the_payload() -> None:
    """Catches: |f| in place of f, with which a mirrored film would pass."""
    bands = written(PAYLOADS[0])
    turned = [replace(reading, frequency_per_mm=-reading.frequency_per_mm) for reading in ideal(bands)]
    assert read(turned, bands).payload != PAYLOADS[0]


def test_error_bars_erase_and_two_erased_bands_cost_nothing() -> None:
    """Catches: error bars left out, so that a wrong reading with a large bar counts as a symbol."""
    bands = written(PAYLOADS[1], step=-0.004)
    readings = ideal(bands)
    for band in (2, 9):
        readings = off(readings, band, by=0.0113, sd=0.0041)
    decoded = read(readings, bands)
    assert (decoded.payload, decoded.unclear, decoded.corrected) == (PAYLOADS[1], 2, 2)
    assert read(off(readings, 0, sd=math.inf), bands).payload is None
    assert read(off(ideal(bands), 3, sd=0.0013), bands).corrected == 0  # under 0.35 steps


@pytest.mark.parametrize("frequency", [math.nan, math.inf, -math.inf, 1e308])
def test_a_reading_that_is_no_number_is_erased(frequency: float) -> None:
    """Catches: int(nan), and a symbol made of garbage."""
    bands = written(PAYLOADS[0])
    readings = ideal(bands)
    readings[8] = replace(readings[8], frequency_per_mm=frequency)
    decoded = read(readings, bands)
    assert (decoded.payload, decoded.unclear) == (PAYLOADS[0], 1)
    assert read([replace(r, frequency_sd=math.nan) for r in ideal(bands)], bands).payload is None


# The long word.


@pytest.fixture(params=[(8, 26), (16, 42), (8, 17)], ids=["64", "128", "short"])
def long_word(request: pytest.FixtureRequest) -> WordCode:
    return WordCode(*request.param)


def test_a_long_word_is_payload_check_and_parity(long_word: WordCode, rng: np.random.Generator) -> None:
    """Catches: a check that is no check, payload bytes that move: printed badges must stay legible.

    The parity is held against the code's definition, roots 1 to 2^(n-1) of GF(256) by 0x11d, written out again.
    """
    payload = rng.bytes(long_word.payload_bytes)
    word = long_word.encode(payload)
    assert len(word) == long_word.word_bytes
    assert word[: len(payload)] == payload
    assert word[len(payload) : len(payload) + 5] == hashlib.sha256(b"moireid/word/1/" + payload).digest()[:5]
    root = 1
    for _ in range(long_word.word_bytes - long_word.payload_bytes - CHECK_BYTES):
        value = 0
        for byte in word:
            value = times_256(value, root) ^ byte
        assert value == 0
        root = times_256(root, 2)
    assert long_word.decode(word, [0.0] * len(word)) == (payload, 0)


def times_256(a: int, b: int) -> int:
    """Product in GF(256) with the polynomial 0x11d."""
    product = 0
    while b:
        product ^= a * (b & 1)
        a, b = (a << 1) ^ (0x11D if a & 0x80 else 0), b >> 1
    return product


def spoilt(word: bytes, places: np.ndarray, rng: np.random.Generator) -> bytes:
    """The word with other bytes at those places."""
    out = bytearray(word)
    for place in places:
        out[place] ^= int(rng.integers(1, 256))
    return bytes(out)


@pytest.mark.claim("A word corrects as many errors as half its parity")
def test_half_the_parity_of_unknown_errors_is_corrected(long_word: WordCode, rng: np.random.Generator) -> None:
    """Catches: a code weaker than its parity, a count of corrections that is none, errors only where doubt is."""
    payload = rng.bytes(long_word.payload_bytes)
    word = long_word.encode(payload)
    for _ in range(60):
        places = rng.choice(long_word.word_bytes, long_word.parity_bytes // 2, replace=False)
        read_ = spoilt(word, places, rng)
        assert long_word.decode(read_, [0.0] * len(word)) == (payload, len(places))


def test_nearly_all_the_parity_of_unread_bytes_is_filled_in(long_word: WordCode, rng: np.random.Generator) -> None:
    """Catches: unread bytes taken for zeros that were read; words made up where no parity is left over."""
    payload = rng.bytes(long_word.payload_bytes)
    word = long_word.encode(payload)
    most = long_word.parity_bytes - 2
    for count, expected in ((most, payload), (most + 1, None), (long_word.word_bytes, None)):
        places = rng.choice(long_word.word_bytes, count, replace=False)
        doubts = [math.inf if k in places else 0.0 for k in range(long_word.word_bytes)]
        found = long_word.decode(spoilt(word, places, rng), doubts)
        assert (found[0] if found else None) == expected


@pytest.mark.claim("Random words are never accepted")
def test_random_long_words_are_never_accepted(rng: np.random.Generator) -> None:
    """Catches: a check that is not held against the payload: 6 % of the short words lie within the code's reach."""
    for code in (WordCode(8, 26), WordCode(8, 17)):
        for _ in range(300):
            word = rng.bytes(code.word_bytes)
            assert code.decode(word, rng.random(code.word_bytes).tolist()) is None


def test_errors_with_erasures_beyond_capacity_are_not_corrected(rng: np.random.Generator) -> None:
    """Catches: the library's habit of mending more than 2 errors + erasures <= parity promise."""
    code, payload = WordCode(8, 17), rng.bytes(8)  # four bytes of parity, so two at most are erased
    word = code.encode(payload)
    for _ in range(200):
        places = rng.permutation(17)[:4]
        doubts = [math.inf if k in places[:2] else 0.0 for k in range(17)]
        found = code.decode(spoilt(word, places, rng), doubts)
        assert found is None or 2 * (found[1] - 2) + 2 <= 4


# The cells of the long code.

LONG = SpacingFamily()


def design(payload: bytes, axes: str = "x") -> Badge:
    return design_badge(Order("Ada", lens="50lpi", axes=axes, range_m=(0.8, 2.0)), payload)


def cell_readings(badge: Badge, *, front_scale: float = 1.0) -> list[list[CellReading]]:
    """What a perfect reader finds, from the drawn lines alone.

    A line shift of s moves the fringe by -2 pi s / p; the beat is that of the row's pitch under the sheet as it is.
    """
    found = []
    for grating in badge.gratings:
        assert grating.code is not None
        low, high = (0, 2) if grating.axis == "x" else (1, 3)
        middle = (grating.rect_mm[low] + grating.rect_mm[high]) / 2
        own = []
        for role, cell in zip(grating.code.roles, grating.cells, strict=True):
            beat = 1 / cell.pitch_mm - 1 / (badge.lens.pitch_mm * front_scale)
            shift = cell.edge_mm + cell.duty * cell.pitch_mm / 2 - middle
            phase = math.remainder(-2 * math.pi * shift / cell.pitch_mm, 2 * math.pi)
            phased = role == "phase"
            own.append(
                CellReading(math.nan, math.inf, phase, 0.02) if phased else CellReading(beat, SURE, math.nan, math.inf)
            )
        found.append(own)
    return found


def phase_places(badge: Badge) -> list[tuple[int, int]]:
    return [
        (g, c)
        for g, grating in enumerate(badge.gratings)
        if grating.code
        for c, role in enumerate(grating.code.roles)
        if role == "phase"
    ]


@pytest.mark.parametrize("axes", ["x", "xy"])
@pytest.mark.parametrize("size", [8, 16])
@pytest.mark.parametrize("front_scale", [0.992, 1.0, 1.008])
def test_cells_that_are_written_are_read(axes: str, size: int, front_scale: float, rng: np.random.Generator) -> None:
    """Catches: the sign of the shift, the order of cells or gratings, beats that need the true lens pitch."""
    for _ in range(3):
        payload = rng.bytes(size)
        badge = design(payload, axes)
        decoded = LONG.read(cell_readings(badge, front_scale=front_scale), badge.gratings)
        assert (decoded.payload, decoded.unclear, decoded.corrected) == (payload, 0, 0)
        assert decoded.beats_agree and decoded.margin > 0.9


def test_phases_are_quarters_of_a_turn_and_neighbours_differ_in_one_bit() -> None:
    """Catches: binary order around the circle, where the commonest misreading spoils two bits in place of one."""
    badge = design(bytes(range(8)))
    assert badge.gratings[0].code is not None
    word = WordCode(8, len(phase_places(badge)) // 4).encode(bytes(range(8)))
    readings = cell_readings(badge)
    symbol_at: dict[int, int] = {}
    for k, (g, c) in enumerate(phase_places(badge)[: 4 * len(word)]):
        quarter = readings[g][c].phase_rad / (math.pi / 2)
        assert quarter == pytest.approx(round(quarter), abs=1e-6)
        symbol = word[k // 4] >> (6 - 2 * (k % 4)) & 3
        assert symbol_at.setdefault(round(quarter) % 4, symbol) == symbol
    assert sorted(symbol_at.values()) == [0, 1, 2, 3]
    for place in range(4):
        assert (symbol_at[place] ^ symbol_at[(place + 1) % 4]).bit_count() == 1


def test_noise_within_the_budget_is_read_and_doubt_is_reported(rng: np.random.Generator) -> None:
    """Catches: a margin or a count of unclear cells that says nothing: at 0.3 rad an eighth of the cells is unclear."""
    payload = rng.bytes(8)
    badge = design(payload)
    for sd in (0.1, 0.3):
        noisy = [
            [replace(r, phase_rad=r.phase_rad + sd * rng.standard_normal(), phase_sd=sd / 3) for r in row]
            for row in cell_readings(badge)
        ]
        decoded = LONG.read(noisy, badge.gratings)
        assert decoded.payload == payload
        steps = sd / (math.pi / 2)
        assert decoded.margin == pytest.approx(1 - 2 * (0.674 * steps + steps / 3), abs=0.1)
        assert (decoded.unclear > 5) == (sd == 0.3)


def test_word_and_beats_must_be_of_one_badge() -> None:
    """Catches: a forger's page whose cells are Ada's and whose rows beat as another's; and beats that veto unread."""
    ada, bob = design(bytes(range(8))), design(bytes(range(1, 9)))
    mixed = cell_readings(ada)
    for k, role in enumerate(ada.gratings[0].code.roles):  # type: ignore[union-attr]
        if role != "phase":
            mixed[0][k] = cell_readings(bob)[0][k]
    levels = [
        [
            round(1000 * (1 / c.pitch_mm))
            for c, r in zip(b.gratings[0].cells, b.gratings[0].code.roles, strict=True)
            if r != "phase"
        ]  # type: ignore[union-attr]
        for b in (ada, bob)
    ]
    assert np.diff(levels[0]).tolist() != np.diff(levels[1]).tolist()
    decoded = LONG.read(mixed, ada.gratings)
    assert decoded.payload == bytes(range(8)) and not decoded.beats_agree
    vague = [[replace(r, frequency_sd=UNCLEAR_BEYOND_STEPS) if r.frequency_sd == SURE else r for r in mixed[0]]]
    assert LONG.read(vague, ada.gratings).beats_agree is None


def test_personal_beats_follow_from_the_payload_alone() -> None:
    """Catches: beats drawn by chance or from the name: the same payload must print the same badge for ever.

    Golden: SHA-256 over "moireid/beats/1/", a zero byte and the payload, by sha256sum: the rows from top to bottom have
    the levels of its first bytes, modulo 8, the middle one modulo 4.
    """
    payload = bytes(range(8))
    badge = design(payload)
    code = badge.gratings[0].code
    assert code is not None
    digest = hashlib.sha256(b"moireid/beats/1/\x00" + payload).digest()
    rows = [cell for cell, role in zip(badge.gratings[0].cells, code.roles, strict=True) if role != "phase"]
    levels = [
        (1 / cell.pitch_mm - 1 / badge.lens.pitch_mm - code.base_frequency_per_mm) / code.frequency_step_per_mm
        for cell in rows
    ]
    assert levels == pytest.approx([digest[0] % 8, digest[1] % 4, digest[2] % 8], abs=1e-6)
    phased = {cell.pitch_mm for cell, role in zip(badge.gratings[0].cells, code.roles, strict=True) if role == "phase"}
    assert phased == {rows[1].pitch_mm}
