"""Reading a picture at places of the page, and an even sample of a film's frames.

Only the part of a picture around the places is turned into counts.  `EvenSample` is bounded, for a film of unknown
length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import truediv

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.picture import Box, Picture

Array = NDArray[np.float64]


def hull_of(rect: Sequence[float]) -> Array:
    """Corners of a rectangle (left, top, right, bottom) of the page, (3, 4), as a warp takes them."""
    x0, y0, x1, y1 = rect
    return np.array([[x0, x1, x1, x0], [y0, y0, y1, y1], [1.0, 1.0, 1.0, 1.0]])


def part_around(picture: Picture, warp: Array, hull: Array) -> tuple[Box, Array]:
    """The part of a picture in which all places within a hull lie, and the warp into it.

    Convention: places beyond the picture lie beyond the part on the same side.
    """
    bounds = _bounds(warp, hull)
    box = _box(bounds, 1, picture) if bounds else (0, 0, picture.shape[1], picture.shape[0])
    return box, _from_corner(warp, box)


def determinant(matrix: Array) -> float:
    """Determinant of a 3 x 3 matrix.  Written out, it takes a fifth of NumPy's time."""
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    return float(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def within_picture(picture: Picture, warp: Array, hull: Array) -> bool:
    """Whether all places within a hull lie within the picture."""
    bounds = _bounds(warp, hull)
    return bounds is not None and _within(bounds, (0, 0, picture.shape[1], picture.shape[0]))


def inverse(matrix: Array) -> Array | None:
    """Inverse of a 3 x 3 matrix, by its cofactors; None if there is none."""
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    first, second, third = e * i - f * h, f * g - d * i, d * h - e * g
    whole = a * first + b * second + c * third
    if not whole:
        return None
    cofactors = (
        (first, c * h - b * i, b * f - c * e),
        (second, a * i - c * g, c * d - a * f),
        (third, b * g - a * h, a * e - b * d),
    )
    return np.asarray(np.array(cofactors) / whole)


def _bounds(warp: Array, hull: Array) -> tuple[float, float, float, float] | None:
    """Left, top, right, bottom of a hull under a warp; None if the horizon crosses it."""
    xs, ys, ws = (warp @ hull).tolist()
    if not (min(ws) > 0 or max(ws) < 0):
        return None
    across, down = list(map(truediv, xs, ws)), list(map(truediv, ys, ws))
    return min(across), min(down), max(across), max(down)


def _within(bounds: tuple[float, float, float, float], box: Box) -> bool:
    """Whether each place has four pixels of a box around it."""
    left, top, right, bottom = bounds
    return left >= box[0] and top >= box[1] and right < box[2] - 1 and bottom < box[3] - 1


def _box(bounds: tuple[float, float, float, float], margin_px: int, picture: Picture) -> Box:
    """The pixels around some bounds, and a margin, as far as the picture goes; it holds one pixel at least."""
    height, width = picture.shape
    left, top, right, bottom = bounds
    x0, x1 = (int(min(max(at, 0), width - 1)) for at in (left - margin_px, right + 1 + margin_px))
    y0, y1 = (int(min(max(at, 0), height - 1)) for at in (top - margin_px, bottom + 1 + margin_px))
    return x0, y0, x1 + 1, y1 + 1


def _from_corner(warp: Array, box: Box) -> Array:
    """The warp in pixels counted from a box's corner: single precision resolves only 1e-4 px at 2000 px."""
    moved = warp.copy()
    moved[0] -= box[0] * warp[2]
    moved[1] -= box[1] * warp[2]
    return moved


#: Most frames kept: all of 8 s at 60 frames a second, every second one of 16 s, and so on.
SAMPLE_FRAMES = 512


@dataclass
class EvenSample:
    """Keeps every `stride`-th item offered; if it is full, it drops every second one and doubles the stride.

    So once it has been full, it always holds more than half of `limit` items, evenly spread over all that were offered.
    """

    limit: int = SAMPLE_FRAMES
    stride: int = 1
    offered: int = 0
    items: list[NDArray[np.float32]] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)

    def offer(self, item: NDArray[np.float32]) -> None:
        """Offer the next item, which is kept or skipped."""
        if not self.numbers or self.offered - self.numbers[-1] >= self.stride:
            self.items.append(item)
            self.numbers.append(self.offered)
        self.offered += 1
        if len(self.items) > self.limit:
            self.items, self.numbers = self.items[::2], self.numbers[::2]
            self.stride *= 2

    def thin(self, kept: Sequence[int]) -> None:
        """Forget all items offered but those of these numbers, which are numbered from 0 again."""
        place = {number: k for k, number in enumerate(kept)}
        left = [k for k, number in enumerate(self.numbers) if number in place]
        self.items, self.numbers = [self.items[k] for k in left], [place[self.numbers[k]] for k in left]
        self.offered, self.stride = len(kept), max(self.stride // 2, 1)

    def drop(self, count: int) -> None:
        """Forget the first `count` items offered; the rest are numbered from 0 again."""
        kept = [k for k, number in enumerate(self.numbers) if number >= count]
        self.items = [self.items[k] for k in kept]
        self.numbers = [self.numbers[k] - count for k in kept]
        self.offered -= count

    @property
    def places(self) -> NDArray[np.int64]:
        """Numbers of the items that are kept, (K,)."""
        return np.array(self.numbers, np.int64)
