"""Clear square markers of a picture, found by the kernel, for NumPy arrays."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.library import PictureStruct, address, library

Array = NDArray[np.float64]
#: Largest window of the threshold, px, and most steps below its mean: sums of a window have 16 bits.
MOST_WINDOW_PX, MOST_STEPS = 15, 30
#: Most cells of a code, across and down: a word has 64 bits.
MOST_CELLS = 8
#: Memory for the kernel begins at a multiple of this.
ALIGNED = 16


class SquareRulesStruct(ctypes.Structure):
    """`SquareRules` of squares.c."""

    _fields_ = (
        *((name, ctypes.c_int32) for name in ("window", "steps", "cells", "classes")),
        *((name, ctypes.c_int32) for name in ("most_wrong", "most_wrong_border")),
        ("least_px", ctypes.c_double),
        ("words", ctypes.c_void_p),
    )


#: `Square` of squares.c.
SQUARE = np.dtype([("corners", np.float64, 8), ("perimeter", np.float64), ("word", np.int32), ("unused", np.int32)])


class FoundSquares(NamedTuple):
    """Squares that show a word, and the work of finding them.

    Attributes: corners (M, 4, 2): of the outer edges, px, clockwise from the one that is up left; word (M,): numbers of
    words; runs: of dark pixels in the picture's rows; read: quadrangles whose cells were read.
    """

    corners: Array
    word: NDArray[np.int32]
    runs: int
    read: int


@dataclass(frozen=True, eq=False)
class SquareCodes:
    """The codes that squares may show.

    Attributes: words (classes, 4): each by four quarter turns, its cells row by row from the lowest bit; cells: of a
    code, across and down; most_wrong: cells that may be wrong; most_wrong_border: cells of the dark border likewise.
    """

    words: NDArray[np.uint64]
    cells: int
    most_wrong: int
    most_wrong_border: int

    def __post_init__(self) -> None:
        if not 1 <= self.cells <= MOST_CELLS or self.words.ndim != 2 or self.words.shape[1] != 4:
            raise ValueError(f"words {self.words.shape} of {self.cells} cells; at most {MOST_CELLS}, by four turns")
        address(self.words, np.uint64)

    def find(self, picture: PictureStruct, *, window: int, steps: int, least_px: float, most: int) -> FoundSquares:
        """Squares with sides of `least_px` or more on the average.

        Parameters: window: side of the threshold's window, odd, px; steps: of the picture's values by which dark pixels
            are below its mean; most: squares of each code, the largest.
        """
        if not (1 <= window <= MOST_WINDOW_PX and window % 2 and 1 <= steps <= MOST_STEPS and most >= 1):
            raise ValueError(f"a window of {window} px, {steps} steps and {most} squares cannot be searched by")
        if min(picture.width, picture.height) < 2:
            raise ValueError(f"a picture of {picture.width} x {picture.height} has no four pixels around a place")
        classes = len(self.words)
        rules = SquareRulesStruct(window, steps, self.cells, classes, self.most_wrong, self.most_wrong_border, least_px)
        rules.words = address(self.words, np.uint64)
        memory = memory_for(picture.width)
        found, counts, work = np.zeros((classes, most), SQUARE), np.zeros(classes, np.int32), np.zeros(2, np.int64)
        library().kernel_squares(
            ctypes.byref(picture),
            ctypes.byref(rules),
            ctypes.c_void_p(address(memory, np.uint8)),
            ctypes.c_void_p(address(found.view(np.uint8), np.uint8)),
            ctypes.c_void_p(address(counts, np.int32)),
            ctypes.c_int32(most),
            ctypes.c_void_p(address(work, np.int64)),
        )
        kept = found[np.arange(most) < counts[:, None]]
        return FoundSquares(kept["corners"].reshape(-1, 4, 2), kept["word"], int(work[0]), int(work[1]))


def memory_for(width: int) -> NDArray[np.uint8]:
    """Memory that the kernel needs for a picture of this width; it begins at a multiple of `ALIGNED`."""
    size = library().kernel_squares_room
    size.restype = ctypes.c_int64
    needed = int(size(ctypes.c_int32(width)))
    memory = np.empty(needed + ALIGNED, np.uint8)
    skipped = -address(memory, np.uint8) % ALIGNED
    return memory[skipped : skipped + needed]
