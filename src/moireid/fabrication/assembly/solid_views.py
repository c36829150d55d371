"""Solids as line drawings for the exploded views: build123d finds the visible edges, manifold3d the silhouette.

Convention: the view of `exploded`; places on the page are mm at life size, right and up.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from moireid.fabrication.assembly.exploded import ACROSS, TOWARD, UPWARD, Loop, Piece
from moireid.fabrication.solid_parts import SolidPart

#: How far off the viewer is, mm; the view is orthographic, so that this only has to be outside of all parts.
AWAY_MM = 2000.0
#: A curve is drawn in so many pieces.
CURVE_STEPS = 8
#: Points of a silhouette that are nearer than this to a straight line are left out, mm.
SIMPLE_MM = 0.02


def drawn_solids(parts: Sequence[SolidPart]) -> dict[str, Piece]:
    """Each part as it is drawn, by its name; takes some hundredths of a second a part."""
    return {part.name: _drawn(part) for part in parts}


def _drawn(part: SolidPart) -> Piece:
    shape = part.shape
    edges, _ = shape.project_to_viewport(tuple(AWAY_MM * value for value in TOWARD), UPWARD, (0, 0, 0))
    turned = part.solid.transform([[*ACROSS, 0.0], [*UPWARD, 0.0], [*TOWARD, 0.0]])
    silhouette = turned.project().simplify(SIMPLE_MM).to_polygons()
    box = shape.bounding_box()
    corners = tuple((x, y) for x in (box.min.X, box.max.X) for y in (box.min.Y, box.max.Y))
    outlines = tuple(tuple((float(u), float(v)) for u, v in loop) for loop in silhouette)
    return Piece(outlines, tuple(_points(edge) for edge in edges), box.min.Z, box.max.Z, corners)


def _points(edge: Any) -> Loop:
    """A line's ends, or points along a curve."""
    if edge.geom_type.name == "LINE":
        places = [tuple(vertex) for vertex in edge.vertices()]
    else:
        places = [tuple(edge.position_at(k / CURVE_STEPS)) for k in range(CURVE_STEPS + 1)]
    return tuple((float(x), float(y)) for x, y, _ in places)
