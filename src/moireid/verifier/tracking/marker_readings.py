"""How often the markers of a page are read that looks less like the print than a followed page must.

A followed page must correlate with the print as `FOLLOWED_CORRELATION` says, or its smear is searched, and then its
markers: half as much work as decoding the frame.  A badge with a damaged marker, or a board that shows some of its
markers in false places, never correlates so.  Once its markers were found some times in a row where registration alone
had put the page, they are read in one frame of several.  In the others registration is enough, if all markers are
visible and the page correlates as it did.  Where it does not, its markers are read before a smear is searched.

A forger can read this source.  Leaving markers out of the other frames gains nothing, as the page must correlate there
as with them; and what is followed so leaves the budgets of searches to the other badges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.tracking.registration import Registration

Array = NDArray[np.float64]
#: Readings in a row that must agree with registration, and of how many each frame that shows the page clearly takes one
#: off; frames from one reading to the next.
AGREED, MOST_AGREED, READ_EVERY = 4, 8, 8
#: A reading agrees if it puts the page within this of where registration did, px, as both end at the same place.
SAME_PX = 0.5
#: A page correlates as it did if its correlation has fallen by no more than this since its markers were read.  Set by
#: hand: it spreads by 0.004 over a board with two false markers; a hand that smears a page takes more.
FALLEN = 0.01


@dataclass
class MarkerReadings:
    """The latest readings of one page's markers."""

    _agreed: int = 0
    _since: int = 0
    _correlation: float = math.inf

    @property
    def agree(self) -> bool:
        """Whether the markers were found where registration alone had put the page, some times in a row."""
        return self._agreed >= AGREED

    def suffice(self, registered: Registration | None) -> bool:
        """Whether a page that was registered from its expected place may be followed without a reading."""
        self._since += 1
        return (
            registered is not None
            and self.agree
            and self._since < READ_EVERY
            and registered.vague == (1.0, 1.0)
            and registered.correlation >= self._correlation - FALLEN
        )

    def note(self, read: Registration, apart_px: float | None) -> None:
        """Take a reading; apart_px: how far the page is from where registration alone had put it; None: nowhere."""
        if apart_px is not None:
            self._agreed = min(self._agreed + 1, MOST_AGREED) if apart_px <= SAME_PX else 0
        self._since, self._correlation = 0, read.correlation

    def fade(self) -> None:
        """Take a frame that shows the page as clearly as a followed one must be: soon none is remembered."""
        self._agreed = max(self._agreed - 1, 0)

    def forget(self) -> None:
        """Begin anew: the page was smeared, or is lost."""
        self._agreed = 0
