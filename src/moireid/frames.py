"""The frame of a grating: along its axis, which its fringes sense, and along its lines.

Convention: own coordinates are mm, first along the axis, then along the lines.  For the axis "x" they are the page's
(x, y); for "y" they are (y, x), which is a reflection.  For a number, in degrees from 0 to below 180, they are those of
the page's frame turned by that angle from x towards y (y points down) about the page's centre:

    first  =  (x - x0) cos + (y - y0) sin + x0,    second = -(x - x0) sin + (y - y0) cos + y0,

with (x0, y0) half the page's width and height.  So a number of 0 is the axis "x", and rectangles of a turned grating
and of its cells are given in this frame: a piece of lens sheet, cut along and across its lenses and placed at an angle.
Rectangles of an "x" or "y" grating are the page's, (x0, y0, x1, y1); `own_rect` gives any of them in own order.
Source: rotation of the plane.  For "x" and "y" every figure comes out exactly as it went in.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

if TYPE_CHECKING:
    # A badge's types are read by commands that need no array, and NumPy takes a tenth of a second to load.
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

#: Directions beyond a half turn sense the same motion, with another sign.
HALF_TURN_DEG = 180.0
Axis = Literal["x", "y"] | Annotated[float, Meta(ge=0, lt=HALF_TURN_DEG)]
#: mm; what lies farther away is no badge.
Coordinate = Annotated[float, Meta(ge=-10_000, le=10_000)]
Rect = Annotated[tuple[Coordinate, Coordinate, Coordinate, Coordinate], Meta(description="left, top, right, bottom")]


@dataclass(frozen=True)
class OwnFrame:
    """One grating's frame.

    rows: the page's directions (x, y) in which the first and the second own coordinate rise; origin_mm: own coordinates
    of the page's origin.
    """

    rows: tuple[tuple[float, float], tuple[float, float]]
    origin_mm: tuple[float, float]

    @property
    def handed(self) -> float:
        """1 for a rotation, -1 for a reflection, by which a turn from x towards y changes its sign."""
        (a, b), (c, d) = self.rows
        return math.copysign(1.0, a * d - b * c)

    def places(self, page_mm: ArrayLike) -> Array:
        """Own coordinates (..., 2) of places on the page (..., 2), mm."""
        return self.directions(page_mm) + self.origin_mm

    def directions(self, page: ArrayLike) -> Array:
        """Own components (..., 2) of vectors of the page (..., 2), such as distances and tangents of views."""
        return self._of_each(page, lambda x, y, a, b: x * a + y * b)

    def spreads(self, page: ArrayLike) -> Array:
        """Standard deviations (..., 2) along the own axes of independent errors (..., 2) along the page's."""
        return self._of_each(page, lambda x, y, a, b: abs(x * a + y * b * 1j))

    def growths(self, page: ArrayLike) -> Array:
        """Growth (..., 2) along the own axes, as shares, of a page that grows by shares (..., 2) along x and y."""
        return self._of_each(page, lambda x, y, a, b: x * a * a + y * b * b)

    def _of_each(self, page: ArrayLike, mixed: Callable[[Array, Array, float, float], Array]) -> Array:
        import numpy as np

        x, y = np.moveaxis(np.asarray(page, float), -1, 0)
        return np.stack([mixed(x, y, a, b) for a, b in self.rows], axis=-1)

    def on_page(self, own_mm: ArrayLike) -> Array:
        """The inverse of `places`."""
        import numpy as np

        return self.vectors(np.asarray(own_mm, float) - self.origin_mm)

    def vectors(self, own: ArrayLike) -> Array:
        """The inverse of `directions`."""
        (a, b), (c, d) = self.rows
        return OwnFrame(((a, c), (b, d)), (0.0, 0.0)).directions(own)

    def corners_mm(self, own: Rect) -> Array:
        """Corners (4, 2) on the page of a rectangle in own order, one after the other round it."""
        return self.on_page([[own[i], own[j]] for i, j in ((0, 1), (2, 1), (2, 3), (0, 3))])

    def bounds_mm(self, own: Rect) -> Rect:
        """The upright rectangle of the page that holds a rectangle in own order."""
        (a, b), (c, d) = self.rows
        along, across = ([own[k] - self.origin_mm[k], own[k + 2] - self.origin_mm[k]] for k in (0, 1))
        x, y = ([u * one + v * other for u in along for v in across] for one, other in ((a, c), (b, d)))
        return min(x), min(y), max(x), max(y)


def own_frame(axis: Axis, page_mm: tuple[float, float]) -> OwnFrame:
    """The frame of a grating of that axis on a page of that size; conventions as in the module docstring."""
    if isinstance(axis, str):
        rows = ((1.0, 0.0), (0.0, 1.0)) if axis == "x" else ((0.0, 1.0), (1.0, 0.0))
        return OwnFrame(rows, (0.0, 0.0))
    cosine, sine = math.cos(math.radians(axis)), math.sin(math.radians(axis))
    x0, y0 = page_mm[0] / 2, page_mm[1] / 2
    return OwnFrame(((cosine, sine), (-sine, cosine)), (x0 - x0 * cosine - y0 * sine, y0 + x0 * sine - y0 * cosine))


def own_rect(axis: Axis, rect: Rect) -> Rect:
    """A `rect_mm` of a grating or cell of that axis in own order: low along the axis, low along the lines, high, high.

    It is its own inverse.
    """
    return (rect[1], rect[0], rect[3], rect[2]) if axis == "y" else rect


def axis_words(axis: Axis) -> str:
    """The direction in words, as it follows "along"."""
    return axis if isinstance(axis, str) else f"{axis:g}°"
