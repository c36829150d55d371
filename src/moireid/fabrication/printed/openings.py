"""The openings of a printed plate: ribs carry what lies on it, and most of its area need not be printed.

A full plate of 1.6 mm takes most of a mount's printing time.  Ribs of four lines of a 0.4 mm nozzle are printed as
outlines alone, without the slow, narrow filling between.

How far a card that curls comes out between two ribs is `s^2 / 8R`, the height of an arc of radius R over a chord s: at
R = 0.5 m, 0.08 mm.  A sheet bends about one direction only, so upright ribs alone keep it flat; those across keep the
plate stiff, and are half as many.

Convention: the frame of `sight`, mm.
"""

from __future__ import annotations

import math

from moireid.badge import Rect

#: Width of a rib, and the greatest width and height of an opening.
RIB_MM, MOST_WIDE_MM, MOST_HIGH_MM = 1.8, 18.0, 36.0
#: A smaller opening saves no time.
LEAST_OPENING_MM = 3.0


def parted(low: float, high: float, most_mm: float) -> list[tuple[float, float]]:
    """A length in equal openings of a greatest length, with ribs between; empty where there is room for none."""
    length = high - low
    if length < LEAST_OPENING_MM:
        return []
    count = max(1, math.ceil((length + RIB_MM) / (most_mm + RIB_MM)))
    each = (length - (count - 1) * RIB_MM) / count
    return [(low + k * (each + RIB_MM), low + k * (each + RIB_MM) + each) for k in range(count)]


def lattice(rect: Rect) -> list[Rect]:
    """Openings that fill a rectangle, with ribs between."""
    x0, y0, x1, y1 = rect
    return [
        (left, low, right, high)
        for low, high in parted(y0, y1, MOST_HIGH_MM)
        for left, right in parted(x0, x1, MOST_WIDE_MM)
    ]


def between(low: float, high: float, taken: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """What is left of a length between parts of it that are taken, which may overlap."""
    free, at = [], low
    for begin, end in sorted(taken):
        if begin > at:
            free.append((at, min(begin, high)))
        at = max(at, end)
    return [*free, (at, high)] if at < high else free
