"""The short word of the pitch family: a check byte, and a Reed-Solomon code over GF(16) by the reedsolo package.

A word is the payload, then the low byte of its CRC-32, cut into 4-bit symbols, then two parity symbols.  The code
has distance 3: it corrects one wrong symbol or two erased ones.

The chance of a wrong payload: of all 16^10 words, 16^8 code words with their 1 + 10 * 15 neighbours decode, which is
0.59 of them; the check byte passes one in 256 of those.  So random symbols decode to some payload with probability
0.0023, and to one given payload with 1.4e-10 (tests measure the first).
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import reedsolo

from moireid.errors import CodeError

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
    # The library also corrects one error beside an erasure, which is not reliable with two parity symbols.
    beyond = 2 * (changed - len(erased)) + len(erased) > PARITY_SYMBOLS
    if beyond or octets[PAYLOAD_BYTES:] != _check(payload):
        return None
    return payload, changed


def _check(payload: bytes) -> bytes:
    """Low byte of the CRC-32 of the payload."""
    return bytes([zlib.crc32(payload) & 0xFF])
