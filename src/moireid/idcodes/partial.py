"""Finds the person when a word has more errors than its parity can correct: compares it with the words of known people.

The chance of a wrong person.  A word is a payload of k' bytes with its check, k bytes in all, and the parity of a
Reed-Solomon code.  In such a code any k bytes of a random word are independent and uniform.  So a stranger's
reading agrees with a given person's word in some given m <= k bytes with probability 256^-m, in at least m of n bytes
with C(n, m) 256^-m at most, and with anybody's of `PEOPLE` with that many times more.  Beyond k bytes the bound is
that for k.  Payloads drawn by chance or from a hash are random in this sense.  Those that were chosen to look alike
are not, but two different words of such a code still agree in k - 1 bytes at most, and more than k are asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from moireid.idcodes.words import CHECK_BYTES, WordCode

#: More people than any registry has, so that they need not be counted.
PEOPLE = 10**9
#: The chance of a wrong person that is allowed.
WRONG_PERSON = 1e-9
#: Hex digits of a part of an id, and how many parts are looked up: a registry of a million holds 15 of each part.
PART_DIGITS, PARTS = 4, 4
#: Two words agree in fewer bytes than payload and check have.  This many more bytes must agree, so that nobody is
#: mistaken for a person with a similar id, even if the id was chosen for that.
LEAD = 3


@dataclass(frozen=True)
class PartialWord:
    """A word as it was read, None for bytes that were not; `beats_agree` tells of a payload's beat rows."""

    code: WordCode
    octets: tuple[int | None, ...]
    beats_agree: Callable[[bytes], bool | None]

    def parts(self) -> dict[int, str]:
        """The id's first parts as they read, by place: one of them may be right where the whole word is not."""
        found = {}
        for place in range(PARTS):
            octets = self.octets[2 * place : 2 * place + 2]
            if 2 * place + 2 <= self.code.payload_bytes and None not in octets:
                found[place] = bytes(octet for octet in octets if octet is not None).hex()
        return found

    def agreeing(self, payload: bytes) -> int:
        """Number of bytes in which the reading is the word of `payload`."""
        if len(payload) != self.code.payload_bytes:
            return 0
        return sum(read == sent for read, sent in zip(self.octets, self.code.encode(payload), strict=True))

    def tells(self, agreeing: int) -> bool:
        """Whether so many bytes tell one person from everybody else, strangers and those with a similar id alike."""
        enough = self.code.payload_bytes + CHECK_BYTES + LEAD
        return agreeing >= enough and self.wrong_person(agreeing) <= WRONG_PERSON

    def wrong_person(self, agreeing: int) -> float:
        """Chance that a stranger's badge agrees with somebody's word in so many bytes.  Source: module docstring."""
        read = sum(octet is not None for octet in self.octets)
        counted = min(agreeing, self.code.payload_bytes + CHECK_BYTES)
        return min(1.0, PEOPLE * math.comb(read, counted) * 256.0**-counted)
