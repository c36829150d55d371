"""Closed paths with rounded corners, moved by the laser's kerf with their arcs kept as arcs.

Convention: mm, y up; paths run anticlockwise, holes too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from moireid.badge import Point, Rect
from moireid.errors import FabricationError


@dataclass(frozen=True)
class Contour:
    """A closed path with rounded corners: one radius a corner, 0 for a sharp one; anticlockwise."""

    corners: tuple[Point, ...]
    radii_mm: tuple[float, ...]

    def grown(self, by_mm: float) -> Contour:
        """The same path moved outwards by `by_mm`, or inwards where that is negative; corners keep their centres.

        Raises: FabricationError where a rounded corner would turn inside out.
        """
        count, moved, radii = len(self.corners), [], []
        for k, (x, y) in enumerate(self.corners):
            before, after = _direction(self.corners[k - 1], (x, y)), _direction((x, y), self.corners[(k + 1) % count])
            turn = before[0] * after[1] - before[1] * after[0]
            along = 1.0 + before[0] * after[0] + before[1] * after[1]
            # The corner moves so that both its edges end up `by_mm` to the right of where they were.
            moved.append((x + by_mm * (before[1] + after[1]) / along, y - by_mm * (before[0] + after[0]) / along))
            radius = self.radii_mm[k] + (math.copysign(by_mm, by_mm * turn) if self.radii_mm[k] else 0.0)
            if radius < 0:
                raise FabricationError(
                    f"a corner of radius {self.radii_mm[k]:g} mm cannot be moved by {by_mm:g} mm; give "
                    "a smaller kerf_mm"
                )
            radii.append(radius)
        return Contour(tuple(moved), tuple(radii))

    def moved(self, dx: float, dy: float) -> Contour:
        """The same path elsewhere."""
        return replace(self, corners=tuple((x + dx, y + dy) for x, y in self.corners))

    def vertices(self) -> list[tuple[float, float, float]]:
        """Corners as (x, y, bulge): where an arc begins its bulge is the tangent of a quarter of its angle, else 0.

        Source: the DXF reference's LWPOLYLINE.
        """
        count = len(self.corners)
        points: list[tuple[float, float, float]] = []
        for k, (x, y) in enumerate(self.corners):
            radius = self.radii_mm[k]
            before, after = _direction(self.corners[k - 1], (x, y)), _direction((x, y), self.corners[(k + 1) % count])
            angle = math.atan2(before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1])
            if radius == 0 or angle == 0:
                points.append((x, y, 0.0))
                continue
            back = radius * math.tan(abs(angle) / 2)
            points.append((x - back * before[0], y - back * before[1], math.tan(angle / 4)))
            points.append((x + back * after[0], y + back * after[1], 0.0))
        # Where two roundings meet, as in a circle, the straight between them has no length.
        return [p for k, p in enumerate(points) if math.dist(p[:2], points[(k + 1) % len(points)][:2]) > 1e-9]

    def flat(self, steps: int = 16) -> tuple[Point, ...]:
        """The path as a polygon, mm, each arc in `steps` pieces."""
        vertices = self.vertices()
        points: list[Point] = []
        for k, (x, y, bulge) in enumerate(vertices):
            points.append((x, y))
            if bulge == 0:
                continue
            end_x, end_y, _ = vertices[(k + 1) % len(vertices)]
            # The centre lies on the chord's bisector, to its left for an arc that turns left by less than a half turn.
            offset = (1 - bulge * bulge) / (4 * bulge)
            cx, cy = (x + end_x) / 2 - (end_y - y) * offset, (y + end_y) / 2 + (end_x - x) * offset
            for step in range(1, steps):
                angle = 4 * math.atan(bulge) * step / steps
                cos, sin = math.cos(angle), math.sin(angle)
                points.append((cx + (x - cx) * cos - (y - cy) * sin, cy + (x - cx) * sin + (y - cy) * cos))
        return tuple(points)

    @property
    def bounds(self) -> Rect:
        """The corners' bounding box, which a rounded path touches too."""
        xs, ys = zip(*self.corners, strict=True)
        return (min(xs), min(ys), max(xs), max(ys))


def _direction(start: Point, end: Point) -> Point:
    length = math.dist(start, end)
    return (end[0] - start[0]) / length, (end[1] - start[1]) / length
