"""What looking for a badge costs, and how much of it a film may spend.

Time is no measure of it: a verdict must be the same on a slow machine and a fast one, and run after run.  So work is
counted in what a step does, in nanoseconds of a nominal machine on which a pixel takes `DECODED_NS` to decode.  Each
frame earns a share of its own decoding; a search is paid when it is done, and the next waits until as much is earned.
Looking that finds the badge where it was just now is part of measuring it, and pays `FOUND_SHARE`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

#: Work of decoding, a pixel.  Measured on films of a low bit rate, where it costs
#: least.
DECODED_NS = 1.5
#: Work of a search for markers: a pixel and window, a run of dark ones, and a quadrangle whose cells are read; and of
#: enlarging a part, a pixel.  Measured as above: on busy cores a search of a full room, of noise or an even wall takes
#: 1.1 to 1.3 of this.
CLEAR_NS, RUN_NS, READ_NS, ENLARGED_NS = 0.9, 30.0, 2e3, 0.6
#: Work of a search for frames: a pixel and window of the threshold, a pixel and window at which the thresholded picture
#: changes along its row, and the notches along one outline; and its work over that of the first two.
#: Measured as above: a search takes 0.9 to 1.35 of this, on white noise 0.2.
WINDOW_NS, CHANGE_NS, OUTLINE_NS, OUTLINED = 0.95, 43.0, 400e3, 1.6
#: Work of drawing a template, a fine sample; of smearing it, a sample, and a sample and step; of its solver, a sample;
#: of a step of registration, a sample; and of correlating, a block that is read, and a block and shift.
#: Measured as above, on markers of 50 to 100 px.
DRAWN_NS, SMEARED_NS, SMEAR_STEP_NS, SOLVED_NS, STEP_NS = 20.0, 15.0, 4.5, 450.0, 32.0
SOUGHT_NS, MATCHED_NS = 40.0, 1.0
#: Share that is paid where looking finds the badge where it was just now: a hand over two markers, or a badge that is
#: not held still, asks for it in each frame.  Not nothing, as else a film of such frames would have no bound.  Set so
#: that a badge in a hand at 1 m, which needs it in two frames of three, is followed through films of any length.
FOUND_SHARE = 0.125
#: Looking around a badge's place earns for each thirtieth of a second, but no more than this often for a frame.
USUAL_STEP_S, MOST_TIMES = 1 / 30, 5.0
#: One row in this many is looked at for changes.
EVERY_ROW = 16
#: Saved are at most the earnings of this many frames, ten seconds at 60 a second.  So a badge that is lost for a moment
#: is searched as closely as ever, and a long film has not saved for an hour's search.
SAVED_FRAMES = 600


@dataclass
class Purse:
    """What one kind of looking may still cost; it begins full.

    share: of the work of decoding that it may cost in the long run.
    Convention: a search may begin while nothing is owed, and its cost is owed afterwards.  So no search is too dear to
    be ever made, and what is earned bounds how often.
    """

    share: float
    _most: float = 0.0
    _spent: float = 0.0

    def earn(self, pixels: int, times: float = 1.0) -> None:
        """Earn a share of decoding a frame, so many times."""
        earned = self.share * DECODED_NS * pixels
        self._most, self._spent = SAVED_FRAMES * earned, max(self._spent - times * earned, 0.0)

    def pay(self, work_ns: float, *, found: bool = False) -> None:
        """Pay a search; found: whether it has found the badge where it was just now."""
        self._spent += FOUND_SHARE * work_ns if found else work_ns

    @property
    def open(self) -> bool:
        """Whether nothing is owed."""
        return self._spent <= self._most

    @property
    def ample(self) -> bool:
        """Whether half of what can be saved is left."""
        return self._spent <= self._most / 2


class Tool(Protocol):
    """What counts the work that it does."""

    work_ns: float


class Purses:
    """One purse for each kind of looking, so that one kind cannot use up what another needs.

    smeared: the smeared print of a page that the last frame showed; gone: of one that it did not; near: markers around
    the last place; glance: clear markers in the whole picture; wide: the whole picture closely, and a part of it
    enlarged.  Where no badge was seen for some seconds, only the last two are spent.
    Source: the shares are set by hand.  That of glances pays two or three a second in a room full of things, at 30
        frames a second, and that of close looks one in some seconds; a page in view and smeared needs most.
    """

    def __init__(self, tools: Sequence[Tool], glances: float, wide: float) -> None:
        """Parameters: tools: whose work is paid; glances, wide: shares for quick and close looks, as they cost."""
        self._tools = tools
        self.smeared, self.gone, self.near = Purse(0.20), Purse(0.05), Purse(0.10)
        self.glance, self.wide = Purse(glances), Purse(wide)

    def earn(self, pixels: int, step_s: float) -> None:
        """Earn for a frame of so many pixels, so long after the one before."""
        # A hand goes further between frames that are far apart, and the machine has as much more time.
        times = min(max(step_s / USUAL_STEP_S, 1.0), MOST_TIMES)
        for purse in (self.smeared, self.gone, self.near):
            purse.earn(pixels, times)
        for purse in (self.glance, self.wide):
            purse.earn(pixels)

    @property
    def work_ns(self) -> float:
        """Work of the tools so far."""
        return sum(tool.work_ns for tool in self._tools)


def clear_work_ns(picture: NDArray[np.uint8], runs: int, read: int) -> float:
    """Work of one window of a search for markers.  Parameters: runs, read: as `FoundSquares`."""
    return CLEAR_NS * picture.size + RUN_NS * runs + READ_NS * read


def outline_work_ns(picture: NDArray[np.uint8], windows: Sequence[int], counts: float, read: int) -> float:
    """Work of one search for frames.

    Parameters: windows, counts: of the threshold; read: outlines whose notches were read.
    Source: OpenCV thresholds the picture once for each window, and follows every outline.  Outlines are as long as
        there are pixels at which the thresholded picture changes.
    """
    return OUTLINED * picture.size * _outlined_ns(picture, windows, counts) + OUTLINE_NS * read


def _outlined_ns(picture: NDArray[np.uint8], windows: Sequence[int], counts: float) -> float:
    """Work of thresholding a picture by each window and of following the outlines, a pixel."""
    rows = picture[EVERY_ROW // 2 :: EVERY_ROW] if len(picture) > EVERY_ROW else picture
    work = 0.0
    for window in windows:
        dark = cv2.subtract(cv2.blur(rows, (window, 1)), rows) > counts
        work += WINDOW_NS + CHANGE_NS * float(np.mean(dark[:, 1:] != dark[:, :-1]))
    return work
