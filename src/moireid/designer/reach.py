"""The range of distances at which a board is read: near, all of it is in the picture; far, all is large enough.

Convention: metres between camera and badge; the camera of a design is `PHONE`.

The link budget is the probability that a badge is found and its identity read, by distance and receiver.

A film is read if its markers are found and followed, and if the phases of the cells are right in enough bytes.  Both
depend steeply on pixels: markers are lost below some 8 pixels, whatever the cells are.  The random conditions of a film
(its motion, its noise, where the coder spends its bits) scatter both thresholds, by the spreads below.

Convention: eight seconds of swaying, or of camera and badge moved against each other; a badge within the tolerances of
print and sheet.  Pixels are those of the film's file.
Source of the figures: 189 films of seven formats, promise and rate side by side; the power is that of
all receivers together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

from moireid.badge import Badge
from moireid.designer.grid import UNIFORM_ROWS, Grid
from moireid.designer.layout import Layout, as_marker_mm
from moireid.designer.order import DESIGN_FOCAL_PX, Pair
from moireid.errors import DesignError
from moireid.frames import own_rect
from moireid.idcodes.spacing import CELLS_PER_BYTE, PHASE_LEVELS
from moireid.idcodes.words import MAX_WORD_BYTES, WordCode

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

    Source of the markers' figures: the likeliest for 63 films each of all formats.
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


#: The picture of the camera that a design must suffice for.
DESIGN_IMAGE_PX = (1920, 1080)
#: Print scale may be off by 0.5 % and lens pitch by 0.3 %; both shift every beat by that share of 1/p_f.
PITCH_TOLERANCE = 0.008
#: Fewest fringes across the grating that fit and shading share without confusion, and pixels that a fringe needs.
MIN_FRINGES = 2.0
MIN_PX_PER_FRINGE = 5.0
#: Least spacing of levels, in fringes across the grating: a level's half step is then a fifth of a fringe.
MIN_STEP_FRINGES = 0.40
#: A uniform band of the pitch code that is lower than this has no profile of its own.
MIN_BAND_PX = 4.0
#: Poses err by the square of the distance over that of the page, so a verdict needs so much more motion.  Eight seconds
#: of swaying, in a film of crf 28, are accepted up to this distance, m, for a millimetre of the markers' extent (root
#: of width by height).  Source: films at the formats' far ends; the board at 1.5 m was
#: accepted, at 1.75 m in four films of six.
VERDICT_M_PER_MM = 0.0098


def fringe_length_mm(layout: Layout) -> float:
    """Length along which the fringes of the shortest field run."""
    fields = (own_rect(axis, rect) for axis, rect in layout.fields_mm)
    return min(high - low for low, _, high, _ in fields)


def check_range(
    range_m: Pair, layout: Layout, grid: Grid, lens_pitch_mm: float, levels: int, payload_bytes: int
) -> None:
    """The whole board must be in the picture at the near end, and everything large enough at the far end.

    Raises: DesignError that names the range that this board has, or a board that has one.
    """
    board = (layout.board_mm[2] - layout.board_mm[0], layout.board_mm[3] - layout.board_mm[1])
    near = max(side * DESIGN_FOCAL_PX / image for side, image in zip(board, DESIGN_IMAGE_PX, strict=True)) / 1000.0
    reaches = _reach_m(layout, grid, lens_pitch_mm, levels, payload_bytes)
    what = min(reaches, key=lambda name: reaches[name])
    near_m, far_m = math.ceil(100 * near) / 100, math.floor(100 * reaches[what]) / 100
    words = f"a board of {board[0]:g} x {board[1]:g} mm"
    if near_m > far_m:
        raise DesignError(
            f"{words} fits the picture from {near_m:.2f} m on, but its {what} are too small beyond {far_m:.2f} m; "
            "give a board such as 146x160",
            near_m=near_m,
            far_m=far_m,
            size_mm=(146.0, 160.0),
        )
    if range_m[0] < near_m or range_m[1] > far_m:
        raise DesignError(
            f"{words} is read at {near_m:.2f} to {far_m:.2f} m, not {range_m[0]:g} to {range_m[1]:g}: "
            f"nearer it overfills the picture, beyond its {what} are too small; choose a range within "
            f"{near_m:.2f}-{far_m:.2f} m",
            near_m=near_m,
            far_m=far_m,
        )


def _reach_m(layout: Layout, grid: Grid, lens_pitch_mm: float, levels: int, payload_bytes: int) -> dict[str, float]:
    """How far each part of the board can be read, metres."""
    width_mm, tolerance = fringe_length_mm(layout), PITCH_TOLERANCE / lens_pitch_mm
    fastest = 2 * tolerance + (MIN_FRINGES + (levels - 1) * MIN_STEP_FRINGES) / width_mm
    marker_mm = as_marker_mm(layout.markers)
    reaches = {
        "markers": found_reach_m(marker_mm),
        "fringes": DESIGN_FOCAL_PX / (fastest * MIN_PX_PER_FRINGE) / 1000,
    }
    cells = (grid.rows - UNIFORM_ROWS) * sum(grid.columns)
    if not grid.columns[0]:
        return reaches | {"rows": DESIGN_FOCAL_PX * grid.row_mm / MIN_BAND_PX / 1000}
    if grid.cell_mm <= 0:
        # Markers and margins alone are wider than the board.
        return reaches | {"cells": 0.0}
    return reaches | {"cells": Read(grid.cell_mm, math.inf, _word(payload_bytes, cells)).reach_m()}


def _word(payload_bytes: int, cells: int) -> WordCode:
    return WordCode(payload_bytes, min(cells // CELLS_PER_BYTE, MAX_WORD_BYTES))


def read_of(badge: Badge) -> Read | None:
    """The parts of a badge that are read (`Read`); None for one without phase cells."""
    phases = [
        cell
        for grating in badge.gratings
        if grating.code
        for cell, role in zip(grating.cells, grating.code.roles, strict=True)
        if role == "phase"
    ]
    if not phases:
        return None
    side_mm = min(cell.rect_mm[k + 2] - cell.rect_mm[k] for cell in phases for k in (0, 1))
    return Read(side_mm, as_marker_mm(badge.markers), _word((badge.payload_bits or 0) // 8, len(phases)))


def link_budgets(badge: Badge) -> list[tuple[float, LinkBudget]]:
    """Distance in metres and link budget at each end of the badge's range; none for a badge without phase cells.

    Convention and source: `Read.at`.
    """
    read = read_of(badge)
    if read is None or badge.range_m is None:
        return []
    return [(metres, read.at(metres)) for metres in dict.fromkeys(badge.range_m)]


def verdict_reach_m(badge: Badge) -> float:
    """Up to where eight seconds of swaying are enough for a verdict, m.  Source: `VERDICT_M_PER_MM`."""
    dark = badge.markers.dark_mm
    wide, high = (max(rect[k + 2] for rect in dark) - min(rect[k] for rect in dark) for k in (0, 1))
    return VERDICT_M_PER_MM * math.sqrt(wide * high)
