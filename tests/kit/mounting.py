"""What the tests of mounts share: places seen from the board's centre, sight lines as solids, badges of any size."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import manifold3d

from moireid.badge import Badge, Cell


def box(rect: tuple[float, ...], low: float, high: float, *, up: float = 0.0) -> Any:
    """A box over a rectangle of the frame, swept `up` mm towards the open top."""
    x0, y0, x1, y1 = rect
    return manifold3d.Manifold.cube((x1 - x0, y1 + up - y0, high - low)).translate((x0, y0, low))


def framed(rect: tuple[float, ...], badge: Badge) -> tuple[float, ...]:
    """A page rectangle seen from the board's centre, y up."""
    bx0, by0, bx1, by1 = badge.outline_mm
    cx, cy = (bx0 + bx1) / 2, (by0 + by1) / 2
    return rect[0] - cx, cy - rect[3], rect[2] - cx, cy - rect[1]


def sight_volume(rect: tuple[float, ...], level: float, angle_deg: float, *, up_and_down: bool) -> Any:
    """All that lies on a sight line to the rectangle from within that angle, up to 3 mm above it."""
    spread = 3.0 * math.tan(math.radians(angle_deg))
    x0, y0, x1, y1 = rect
    dy = spread if up_and_down else 0.0
    lower = [(x, y, level) for x in (x0, x1) for y in (y0, y1)]
    upper = [(x, y, level + 3.0) for x in (x0 - spread, x1 + spread) for y in (y0 - dy, y1 + dy)]
    return manifold3d.Manifold.hull_points(lower + upper)


def board_of(badge: Badge, width: float, height: float, *, margin: float = 5.0, lens_mm: float = 1.0) -> Badge:
    """A badge of another size, made by hand: markers in the corners, one grating between them."""
    marker = min(width, height) / 6
    field = (margin, margin + marker + 2, width - margin, height - margin - marker - 2)
    ends = [margin + marker / 2, width - margin - marker / 2, height - margin - marker / 2]
    centers = ((ends[0], ends[0]), (ends[1], ends[0]), (ends[1], ends[2]), (ends[0], ends[2]))
    return replace(
        badge,
        page_mm=(width, height),
        board_mm=None,
        lens=replace(badge.lens, thickness_mm=lens_mm, radius_mm=max(1.0, lens_mm)),
        gratings=(replace(badge.gratings[0], rect_mm=field, cells=(Cell(field, 0.52, margin, 0.5),), code=None),),
        markers=replace(badge.markers, size_mm=marker, centers_mm=centers),
    )
