"""Finds the person when a word has more errors than its parity can correct: compares it with the words of known people.

The chance of a wrong person.  A word is a payload of k' bytes with its check, k bytes in all, and the parity of a
Reed-Solomon code.  In such a code any k bytes of a random word are independent and uniform.  So a stranger's
reading agrees with a given person's word in some given m <= k bytes with probability 256^-m, and in at least m of n
bytes with C(n, m) 256^-m at most.  For the words of `PEOPLE` people this is multiplied by their number.  Beyond k bytes
the bound is that for k.  Payloads drawn at random or from a hash are random in this sense.  Payloads that were chosen
to look alike are not, but two different words of such a code agree in k - 1 bytes at most, and more than k are asked
for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from moireid.idcodes.words import CHECK_BYTES, WordCode

#: More people than any registry has, so that they need not be counted.
PEOPLE = 10**9
WRONG_PERSON = 1e-9
"""The chance of a wrong person, 0 to 1, that is allowed where a damaged word is compared with those of known people."""
#: Hex digits of a part of an id, and how many parts are looked up: a registry of a million holds 15 of each part.
PART_DIGITS, PARTS = 4, 4
#: Two words agree in fewer bytes than payload and check have.  This many more bytes must agree, so that a person is
#: not mistaken for another one with a similar id, even if the id was chosen for that.
LEAD = 3


@dataclass(frozen=True)
class PartialWord:
    """A word as it was read, with more errors than its parity can correct.

    It is compared with the words of people who are known.

    Parameters
    ----------
    code : WordCode
        The code of the badge: its payload bytes and its word bytes.
    octets : tuple of (int or None)
        The bytes as they were read, 0 to 255; None for a byte that was not read.
    beats_agree : callable
        From a payload to whether the beats that were read are those of that payload; None where none could be read.

    Notes
    -----
    Convention: `wrong_person` bounds the chance that a stranger is taken for one of a billion enrolled people.
    Source: any k bytes of a random Reed-Solomon word are uniform, so m given bytes agree with probability 256^-m.  The
    union bound over C(n, m) choices and over all people is in `moireid.idcodes.partial`.
    """

    code: WordCode
    octets: tuple[int | None, ...]
    beats_agree: Callable[[bytes], bool | None]

    def parts(self) -> dict[int, str]:
        """Read the first parts of the id: one may be right where the whole word is not.

        Returns
        -------
        dict of int to str
            Place 0 to 3 to the four lower-case hex digits that were read there; parts with a lost byte are left out.
        """
        found = {}
        for place in range(PARTS):
            octets = self.octets[2 * place : 2 * place + 2]
            if 2 * place + 2 <= self.code.payload_bytes and None not in octets:
                found[place] = bytes(octet for octet in octets if octet is not None).hex()
        return found

    def agreeing(self, payload: bytes) -> int:
        """Count the bytes in which the reading is the word of a payload.

        Parameters
        ----------
        payload : bytes
            The id of a known person.

        Returns
        -------
        int
            0 for a payload of another length.
        """
        if len(payload) != self.code.payload_bytes:
            return 0
        return sum(read == sent for read, sent in zip(self.octets, self.code.encode(payload), strict=True))

    def identifies(self, agreeing: int) -> bool:
        """Check whether so many equal bytes identify one person, also among people with similar ids.

        Parameters
        ----------
        agreeing : int
            As `agreeing` counts them.

        Returns
        -------
        bool
            True where the chance of a wrong person is at most `WRONG_PERSON`.
        """
        enough = self.code.payload_bytes + CHECK_BYTES + LEAD
        return agreeing >= enough and self.wrong_person(agreeing) <= WRONG_PERSON

    def wrong_person(self, agreeing: int) -> float:
        """Bound the chance that a stranger's badge agrees with any person's word in so many bytes.

        Parameters
        ----------
        agreeing : int
            As `agreeing` counts them.

        Returns
        -------
        float
            A probability, 0 to 1.

        Notes
        -----
        Source: the union bound of the class.
        """
        read = sum(octet is not None for octet in self.octets)
        counted = min(agreeing, self.code.payload_bytes + CHECK_BYTES)
        return min(1.0, PEOPLE * math.comb(read, counted) * 256.0**-counted)
