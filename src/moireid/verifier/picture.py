"""One picture of a film, whose brightness is worked out where it is read; and light and its coded counts.

Turning a whole 1080p picture into counts costs a fifth of decoding it, and a followed badge covers a twentieth of it.
"""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.library import PictureStruct, picture_struct

Box = tuple[int, int, int, int]  #: Left, top, right, bottom, px; right and bottom are the first beyond it.
#: Cameras code light by about the power of 2.2 (sRGB).  The law holds for light, so counts are turned back into light;
#: on coded counts the fringe's phase would move 1 % too little.
CODING_POWER = 2.2
LINEAR_COUNTS = (255.0 * (np.arange(256) / 255.0) ** CODING_POWER).astype(np.float32)


def counts_of(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Light, (...,), in the unit of `LINEAR_COUNTS`, coded as a picture's counts."""
    counts = np.rint(255.0 * (np.clip(light, 0.0, 255.0) / 255.0) ** (1 / CODING_POWER))
    return np.asarray(counts, np.uint8)


@lru_cache(maxsize=16)
def _tables(levels: bytes | None, kind: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Counts of each coded byte, and its light in the unit of `LINEAR_COUNTS`, (256,).  A film has one such pair."""
    counts = np.arange(256, dtype=np.float32) if levels is None else np.frombuffer(levels, kind).astype(np.float32)
    return counts, LINEAR_COUNTS[np.clip(counts, 0, 255).astype(np.uint8)]


class Picture:
    """Brightness (height, width), 0 black to 255 white, kept as it was coded.

    Convention: `part` gives counts of a part, `whole` those of all of it, which are kept.
    """

    def __init__(self, coded: NDArray[np.uint8], levels: NDArray[Any] | None = None, contrast: float = 0.0) -> None:
        """Parameters: coded (height, width); levels (256,): counts of each coded value, None if they are the same;
        contrast: coded steps of one count, where counts are in proportion to them, 0 where they are not.
        """
        self._coded, self._levels = coded, levels
        self.contrast = 1.0 if levels is None else contrast

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self._coded.shape[0], self._coded.shape[1]

    @property
    def size(self) -> int:
        """Number of pixels."""
        return self._coded.size

    @cached_property
    def whole(self) -> NDArray[Any]:
        """Counts of the whole picture, (height, width)."""
        return self.part((0, 0, self.shape[1], self.shape[0]))

    @cached_property
    def struct(self) -> PictureStruct:
        """The picture as the kernel takes it."""
        return picture_struct(self._coded, self._tables[0])

    @cached_property
    def in_light(self) -> Picture:
        """The picture in the unit of `LINEAR_COUNTS`; for a picture in counts."""
        return Picture(self._coded, self._tables[1])

    @cached_property
    def _tables(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        levels = self._levels
        return _tables(None, "") if levels is None else _tables(levels.tobytes(), levels.dtype.str)

    def part(self, box: Box, kind: type[Any] | None = None) -> NDArray[Any]:
        """Counts of a part, which lies within the picture; kind: of number, None for that in which they are kept."""
        coded = self.coded(box)
        if self._levels is None:
            return np.array(coded, kind)
        return np.asarray(cv2.LUT(coded, self._levels if kind is None else self._levels.astype(kind)))

    def coded(self, box: Box) -> NDArray[Any]:
        """A part as it was coded, a view."""
        left, top, right, bottom = box
        return self._coded[top:bottom, left:right]

    def mirrored(self) -> Picture:
        """The picture with left and right swapped; the principal point, its centre, stays."""
        return Picture(np.ascontiguousarray(self._coded[:, ::-1]), self._levels, self.contrast)


def as_picture(luma: Picture | NDArray[Any]) -> Picture:
    """The picture itself, or one whose counts are those of an array."""
    return luma if isinstance(luma, Picture) else Picture(luma)


class Frame:
    """One picture of a film.

    Parameters
    ----------
    index : int
        Its number, from 0.
    time_s : float
        Its time, s.
    luma : array (height, width) of uint8, or Picture
        Brightness, 0 black to 255 white.
    """

    def __init__(self, index: int, time_s: float, luma: Picture | NDArray[np.uint8]) -> None:
        """Take a picture with its number and time."""
        self.index, self.time_s = index, time_s
        self.picture = as_picture(luma)

    @property
    def luma(self) -> NDArray[np.uint8]:
        """Brightness of the whole picture, (height, width) of uint8."""
        return self.picture.whole

    def at(self, time_s: float) -> Frame:
        """The same picture at another time."""
        return Frame(self.index, time_s, self.picture)
