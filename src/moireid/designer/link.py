"""The link budget: the probability that a badge is found and its identity read, by distance and receiver.

A film is read if its markers are found and followed, and if the phases of the cells are right in enough bytes.  Both
depend steeply on pixels: markers are lost below some 8 pixels, whatever the cells are.  The random conditions of a film
(its motion, its noise, where the coder spends its bits) scatter both thresholds, by the spreads below.

Convention: eight seconds of swaying, or of camera and badge moved against each other; a badge within the tolerances of
print and sheet.  Pixels are those of the film's file.
Source of the figures: films of `benchmarks/link.py`, which prints promise and rate side by side; the power is that of
all receivers together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

from moireid.designer.request import DESIGN_FOCAL_PX
from moireid.idcodes.spacing import CELLS_PER_BYTE, PHASE_LEVELS
from moireid.idcodes.words import WordCode

#: A cell's phase error is `AT_RAD` at a receiver's `cell_px`, falls with this power of its pixels, and ends at a floor.
AT_RAD, POWER, FLOOR_RAD = 0.1, 3.2, 0.004
#: Spread of a film's phase error, as the standard deviation of its logarithm.
ERROR_SPREAD = 0.35
#: Doubtful bytes are erased, so a word bears errors larger by this than one that is read by hard decisions.  Measured:
#: half of the words of 26 and of 42 bytes are read at 0.45 rad, and by hard decisions at 0.43 rad.
SOFT_GAIN = 1.05
#: A range is promised as far as this share of films is read.
PROMISED_SHARE = 0.95
#: Films over whose spread the rate is averaged: quantiles of the normal distribution.
_QUANTILES = tuple(NormalDist().inv_cdf((k + 0.5) / 15) for k in range(15))


@dataclass(frozen=True)
class Receiver:
    """A camera and its coding.

    words: as in "read by"; focal_px: focal length in pixels of the file; cell_px: size of a cell with a phase error of
    `AT_RAD`, px; marker_px: size of a marker that half of the films find, px; marker_spread: spread of that size over
    films, as the standard deviation of its logarithm.

    Source of the markers' figures: the likeliest for 63 films each of all formats (`benchmarks/link.py`).
    """

    words: str
    focal_px: float
    cell_px: float
    marker_px: float
    marker_spread: float


#: A phone on a stand or in a still hand: 1080p, H.264 of crf 28.
PHONE = Receiver("a phone in 1080p", DESIGN_FOCAL_PX, 3.2, 8.3, 0.055)
#: A call: 720p at 1200 kbit/s, a frame in twenty lost.
CALL = Receiver("a call at 720p", 967.0, 3.05, 7.7, 0.1)
#: A clip of a chat program: 360 rows at 700 kbit/s, made small from a phone's film.
CHAT = Receiver("a chat program's clip", 483.0, 2.3, 6.6, 0.125)
RECEIVERS = (PHONE, CALL, CHAT)


@dataclass(frozen=True)
class LinkBudget:
    """Prediction at one distance: pixels of a cell's smaller side and of a marker, a cell's phase error in a typical
    film, the probability of a wrong cell there, and the share of films in which the whole payload is read.
    """

    cell_px: float
    marker_px: float
    phase_error_rad: float
    cell_error: float
    decode_probability: float


@dataclass(frozen=True)
class Read:
    """The parts of a badge that are read: smaller side of its cells and side of its markers, mm, and its word."""

    cell_mm: float
    marker_mm: float
    word: WordCode

    def at(self, metres: float, receiver: Receiver = PHONE) -> LinkBudget:
        """The budget at a distance.  Convention and source: module docstring; cells of one film err independently."""
        px_per_mm = receiver.focal_px / (1000 * metres)
        cell_px, marker_px = self.cell_mm * px_per_mm, self.marker_mm * px_per_mm
        error = AT_RAD * (receiver.cell_px / cell_px) ** POWER + FLOOR_RAD
        films = [error * math.exp(ERROR_SPREAD * quantile) / SOFT_GAIN for quantile in _QUANTILES]
        read = sum(_read_share(one, self.word) for one in films) / len(films)
        return LinkBudget(cell_px, marker_px, error, _wrong_cell(error), found_share(marker_px, receiver) * read)

    def reach_m(self, receiver: Receiver = PHONE, share: float = PROMISED_SHARE) -> float:
        """How far that share of films is read, m, to a millimetre."""
        low, high = 0.0, 100.0
        while high - low > 1e-3:
            middle = (low + high) / 2
            low, high = (middle, high) if self.at(middle, receiver).decode_probability >= share else (low, middle)
        return low


def found_share(marker_px: float, receiver: Receiver = PHONE) -> float:
    """Share of films in which markers of that size are found and followed.  Source: module docstring."""
    return NormalDist().cdf(math.log(marker_px / receiver.marker_px) / receiver.marker_spread)


def found_reach_m(marker_mm: float, receiver: Receiver = PHONE) -> float:
    """How far markers are found in `PROMISED_SHARE` of films, m."""
    least_px = receiver.marker_px * math.exp(receiver.marker_spread * NormalDist().inv_cdf(PROMISED_SHARE))
    return receiver.focal_px * marker_mm / least_px / 1000


def _wrong_cell(error_rad: float) -> float:
    return math.erfc(math.pi / PHASE_LEVELS / (error_rad * math.sqrt(2)))


def _read_share(error_rad: float, word: WordCode) -> float:
    """Probability that a word of cells with that phase error is read: at most half the parity bytes are wrong."""
    wrong_byte = 1 - (1 - _wrong_cell(error_rad)) ** CELLS_PER_BYTE
    most, count = word.parity_bytes // 2, word.word_bytes
    read = sum(math.comb(count, k) * wrong_byte**k * (1 - wrong_byte) ** (count - k) for k in range(most + 1))
    return min(read, 1.0)
