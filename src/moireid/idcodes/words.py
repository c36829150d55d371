"""Payload <-> code word, for both families: a check, and a Reed-Solomon code by the reedsolo package.

The word of the spacing family (`WordCode`) is over GF(256): the payload, then five bytes of its SHA-256, then as many
parity bytes as the badge has room for.  The chance of a wrong payload: a reading that has nothing to do with any badge
is tried at most `MAX_TRIES` times, with more of its weakest bytes erased each time.  Even if every try gave some word,
that word passes the check with probability 2^-40 = 9.1e-13.  So an undetected wrong payload has a probability below
20 * 9.1e-13 = 2e-11, where 1e-9 is allowed; the bounded distance of the code makes it smaller still.

The short word of the pitch family (`encode_word`, `decode_word`) is over GF(16): the payload, then the low byte of its
CRC-32, cut into 4-bit symbols, then two parity symbols.  The code has distance 3: it corrects one wrong symbol or two
erased ones.  The chance of a wrong payload: of all 16^10 words, 16^8 code words with their 1 + 10 * 15 neighbours
decode, which is 0.59 of them; the check byte passes one in 256 of those.  So random symbols decode to some payload with
probability 0.0023, and to one given payload with 1.4e-10 (tests measure the first).
"""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import reedsolo

from moireid.errors import CodeError

CHECK_BYTES = 5
#: Tries of one decoding, each with more of the weakest bytes erased.
MAX_TRIES = 20
#: Parity that must remain after erasures are filled, so that errors still show.
SPARE_PARITY = 2
MAX_WORD_BYTES = 255


@dataclass(frozen=True)
class WordCode:
    """The code of one badge: how many payload bytes, and how many bytes the whole word has."""

    payload_bytes: int
    word_bytes: int

    def __post_init__(self) -> None:
        if not self.payload_bytes + CHECK_BYTES + SPARE_PARITY < self.word_bytes <= MAX_WORD_BYTES:
            raise CodeError(
                f"a word of {self.word_bytes} bytes cannot carry {self.payload_bytes * 8} bits; it needs "
                f"{self.payload_bytes + CHECK_BYTES + SPARE_PARITY + 1} to {MAX_WORD_BYTES} bytes"
            )

    @property
    def parity_bytes(self) -> int:
        """Parity: this many erased bytes, or half as many wrong ones, can be corrected."""
        return self.word_bytes - self.payload_bytes - CHECK_BYTES

    def encode(self, payload: bytes) -> bytes:
        """The word that spells the payload.  Raises: CodeError where it has another length."""
        if len(payload) != self.payload_bytes:
            raise CodeError(
                f"a payload of {len(payload) * 8} bits does not fit a code of {self.payload_bytes * 8} bits"
            )
        return bytes(_codec(self.parity_bytes).encode(payload + check(payload)))

    def decode(self, word: bytes, doubts: Sequence[float], most_tries: int = MAX_TRIES) -> tuple[bytes, int] | None:
        """Payload and number of bytes corrected, or None where the word spells none.

        Parameters: doubts: one a byte, the larger the more doubtful; infinite for a byte that was not read at all.
        Source: generalised minimum distance decoding (Forney, 1966): the weakest bytes are erased, two more each try.
        Raises: CodeError where lengths do not fit.
        """
        if len(word) != self.word_bytes or len(doubts) != self.word_bytes:
            raise CodeError(f"a word has {self.word_bytes} bytes, got {len(word)} and {len(doubts)} doubts")
        weakest = sorted(range(self.word_bytes), key=lambda place: -doubts[place])
        lost = sum(doubt == float("inf") for doubt in doubts)
        most = self.parity_bytes - SPARE_PARITY
        tries = range(lost, most + 1, max(2, -(-(most - lost + 1) // MAX_TRIES)))
        for count in tries[:most_tries]:
            found = self._try(word, weakest[:count])
            if found:
                return found
        return None

    def _try(self, word: bytes, erased: list[int]) -> tuple[bytes, int] | None:
        try:
            data, full, _ = _codec(self.parity_bytes).decode(word, erase_pos=erased)
        except reedsolo.ReedSolomonError:
            return None
        payload = bytes(data[: self.payload_bytes])
        lost = set(erased)
        errors = sum(read != sent for k, (read, sent) in enumerate(zip(word, full, strict=True)) if k not in lost)
        # With errors as well as erasures, the library corrects more than the parity allows reliably.
        if 2 * errors + len(erased) > self.parity_bytes:
            return None
        if bytes(data[self.payload_bytes :]) != check(payload):
            return None
        return payload, sum(read != sent for read, sent in zip(word, full, strict=True))


def check(payload: bytes) -> bytes:
    """Five bytes of SHA-256 over the payload, under this code's own name."""
    return hashlib.sha256(b"moireid/word/1/" + payload).digest()[:CHECK_BYTES]


@cache
def _codec(parity_bytes: int) -> reedsolo.RSCodec:
    return reedsolo.RSCodec(parity_bytes)


PAYLOAD_BYTES = 3
SYMBOL_BITS = 4
PARITY_SYMBOLS = 2
#: Symbols in a word: 3 payload bytes and 1 check byte are 8 symbols, and two of parity.
WORD_SYMBOLS = (PAYLOAD_BYTES + 1) * 8 // SYMBOL_BITS + PARITY_SYMBOLS

_CODEC = reedsolo.RSCodec(PARITY_SYMBOLS, nsize=2**SYMBOL_BITS - 1, c_exp=SYMBOL_BITS)


def encode_word(payload: bytes) -> tuple[int, ...]:
    """The ten symbols, 0 to 15, that spell a 24-bit payload.  Raises: CodeError where it has not 3 bytes."""
    if len(payload) != PAYLOAD_BYTES:
        raise CodeError(
            f"a payload of {len(payload) * 8} bits does not fit the pitch code; give {PAYLOAD_BYTES * 2} hex digits "
            f"({PAYLOAD_BYTES * 8} bits)"
        )
    symbols = [nibble for byte in payload + _check(payload) for nibble in (byte >> 4, byte & 15)]
    return tuple(int(symbol) for symbol in _CODEC.encode(symbols))


def decode_word(symbols: Sequence[int | None]) -> tuple[bytes, int] | None:
    """Payload and number of symbols corrected, or None where the symbols (None: erased) are no code word.

    Raises: CodeError where there are not `WORD_SYMBOLS` of them.
    """
    if len(symbols) != WORD_SYMBOLS:
        raise CodeError(f"a word has {WORD_SYMBOLS} symbols, got {len(symbols)}")
    erased = [place for place, symbol in enumerate(symbols) if symbol is None]
    if len(erased) > PARITY_SYMBOLS:
        return None
    try:
        data, full, _ = _CODEC.decode([symbol or 0 for symbol in symbols], erase_pos=erased)
    except reedsolo.ReedSolomonError:
        return None
    octets = bytes(high << 4 | low for high, low in zip(data[::2], data[1::2], strict=True))
    payload = octets[:PAYLOAD_BYTES]
    changed = sum(read != sent for read, sent in zip(symbols, full, strict=True))
    # The library also corrects one error in addition to an erasure, which is not reliable with two parity symbols.
    beyond = 2 * (changed - len(erased)) + len(erased) > PARITY_SYMBOLS
    if beyond or octets[PAYLOAD_BYTES:] != _check(payload):
        return None
    return payload, changed


def _check(payload: bytes) -> bytes:
    """Low byte of the CRC-32 of the payload."""
    return bytes([zlib.crc32(payload) & 0xFF])
