"""Backgrounds and borders: what fills a board around its pieces, and never what is read.

A background covers the free parts of the board in a light shade of the accent, whole or in stripes; a border is a line
near the board's edge, or bars at its upper and lower edge.  Both keep `AIR_MM` more than the white that the verifier
reads around markers and fringes (`clear.clear_zones`), and both are cut where they meet it.

Convention: page mm.
"""

from __future__ import annotations

import itertools
from typing import Literal

from moireid.artwork.clear import AIR_MM, BLEED_MM, clear_zones
from moireid.badge import Badge, Rect

Background = Literal["none", "tint", "stripes"]
Border = Literal["none", "line", "double", "bars"]
#: Distance and width of stripes; a border's distance from the board's edge, its width, the gap between two; bars, mm.
STRIPE_MM, STRIPE_WIDE_MM = 1.6, 0.5
EDGE_MM, LINE_MM, LINES_APART_MM, BAR_MM = 1.2, 0.35, 0.8, 2.0
#: A part of a border that is shorter is left out, mm.
LEAST_PART_MM = 3.0


def background_rects(badge: Badge, kind: Background) -> list[Rect]:
    """The rectangles of a background; those at the board's edge reach beyond it, where it is cut."""
    if kind == "none":
        return []
    x0, y0, x1, y1 = badge.outline_mm
    whole = (x0 - BLEED_MM, y0 - BLEED_MM, x1 + BLEED_MM, y1 + BLEED_MM)
    if kind == "tint":
        return without(whole, _kept_clear(badge))
    count = int((whole[3] - whole[1]) / STRIPE_MM)
    stripes = [
        (whole[0], whole[1] + k * STRIPE_MM, whole[2], whole[1] + k * STRIPE_MM + STRIPE_WIDE_MM) for k in range(count)
    ]
    return [part for stripe in stripes for part in without(stripe, _kept_clear(badge))]


def border_rects(badge: Badge, kind: Border) -> list[Rect]:
    """The rectangles of a border."""
    if kind == "none":
        return []
    x0, y0, x1, y1 = badge.outline_mm
    if kind == "bars":
        sides: list[Rect] = [
            (x0 - BLEED_MM, y0 - BLEED_MM, x1 + BLEED_MM, y0 + BAR_MM),
            (x0 - BLEED_MM, y1 - BAR_MM, x1 + BLEED_MM, y1 + BLEED_MM),
        ]
    else:
        sides = _outline(badge.outline_mm, EDGE_MM)
        if kind == "double":
            sides += _outline(badge.outline_mm, EDGE_MM + LINES_APART_MM)
    parts = [part for side in sides for part in without(side, _kept_clear(badge))]
    return [part for part in parts if max(part[2] - part[0], part[3] - part[1]) >= LEAST_PART_MM]


def without(rect: Rect, zones: list[Rect]) -> list[Rect]:
    """What is left of a rectangle outside of all zones, as rectangles that do not overlap."""
    edges = {rect[1], rect[3], *(edge for zone in zones for edge in (zone[1], zone[3]) if rect[1] < edge < rect[3])}
    rows = sorted(edges)
    left: list[Rect] = []
    for top, bottom in itertools.pairwise(rows):
        spans = [(rect[0], rect[2])]
        for zone in zones:
            if zone[1] < bottom and top < zone[3]:
                spans = [part for span in spans for part in _cut(span, zone[0], zone[2])]
        left += [(begin, top, end, bottom) for begin, end in spans]
    return left


def _cut(span: tuple[float, float], begin: float, end: float) -> list[tuple[float, float]]:
    parts = [(span[0], min(span[1], begin)), (max(span[0], end), span[1])]
    return [(one, other) for one, other in parts if other - one > 1e-6]


def _outline(board: Rect, inset: float) -> list[Rect]:
    """Four sides of a frame that do not overlap."""
    x0, y0, x1, y1 = board[0] + inset, board[1] + inset, board[2] - inset, board[3] - inset
    upright = (y0 + LINE_MM, y1 - LINE_MM)
    return [
        (x0, y0, x1, y0 + LINE_MM),
        (x0, y1 - LINE_MM, x1, y1),
        (x0, upright[0], x0 + LINE_MM, upright[1]),
        (x1 - LINE_MM, upright[0], x1, upright[1]),
    ]


def _kept_clear(badge: Badge) -> list[Rect]:
    board, reach = badge.outline_mm, 2 * BLEED_MM
    zones = []
    for _, (x0, y0, x1, y1) in clear_zones(badge):
        # A zone up to the board's side goes on beyond it, where a background is cut.
        x0, x1 = (x0 - AIR_MM, x1 + AIR_MM)
        x0 = board[0] - reach if x0 <= board[0] + AIR_MM else x0
        x1 = board[2] + reach if x1 >= board[2] - AIR_MM else x1
        zones.append((x0, y0 - AIR_MM, x1, y1 + AIR_MM))
    return zones
