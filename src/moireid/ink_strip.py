"""The strip of a pitch test sheet from which a picture shows by how much the printer widens lines.

Patches of fine and of coarse lines, of several shares of ink, lie between patches of paper and of solid ink.  A growth
of g adds g / p to the share of ink of lines of pitch p: three times as much to the fine ones as to the coarse ones.
Paper and ink give the ends of the camera's tone curve, and the patches of both pitches its bend.

Convention: page millimetres; widths and pitches are whole dots of the printer, so that no edge is rounded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from moireid.badge import Badge
from moireid.frames import Rect
from moireid.profiles import find_dot_mm

#: Ends of the strip are so far from the markers; its place below their middle, and its height, mm.
SIDE_GAP_MM, BELOW_MM, HIGH_MM = 4.0, 8.2, 4.6
#: Pitch of the fine lines, mm, about; those of the coarse and of the finest ones over it.
FINE_MM, COARSE_RATIO, FINEST_RATIO = 0.4233, 3, 0.4
#: At least so many dots of a fine line's pitch, so that its shares of ink can differ.
LEAST_DOTS = 4
#: Patches from left to right: kind, and share of ink as drawn; "paper" and "solid" have no lines.
PATCHES: tuple[tuple[str, float], ...] = (
    ("paper", 0.0),
    ("solid", 1.0),
    ("fine", 0.25),
    ("coarse", 0.7),
    ("fine", 0.5),
    ("finest", 0.25),
    ("coarse", 0.3),
    ("paper", 0.0),
    ("fine", 0.4),
    ("coarse", 0.5),
    ("solid", 1.0),
    ("finest", 0.5),
    ("fine", 0.6),
    ("coarse", 0.2),
    ("paper", 0.0),
    ("fine", 0.3),
    ("coarse", 0.8),
    ("finest", 0.375),
    ("solid", 1.0),
    ("paper", 0.0),
)
#: Of a patch's width, so much is free of its neighbours' blur.
INNER_SHARE = 0.78


@dataclass(frozen=True)
class InkPatch:
    """One patch: its rectangle, mm; pitch and width of its lines as drawn, mm, of pitch 0 where it has none."""

    kind: str
    rect_mm: Rect
    pitch_mm: float
    line_mm: float

    @property
    def lines_mm(self) -> list[Rect]:
        """What is drawn: the dark lines from left to right, the last one cut by the border; or all of a solid patch."""
        x0, y0, x1, y1 = self.rect_mm
        if not self.pitch_mm:
            return [self.rect_mm] if self.kind == "solid" else []
        begins = (x0 + k * self.pitch_mm for k in range(math.ceil((x1 - x0) / self.pitch_mm)))
        return [(begin, y0, min(begin + self.line_mm, x1), y1) for begin in begins]

    @property
    def inner_mm(self) -> Rect:
        """The part of which the mean is taken: a whole number of pitches, away from the patch's borders."""
        x0, y0, x1, y1 = self.rect_mm
        wide = INNER_SHARE * (x1 - x0)
        if self.pitch_mm:
            wide = max(1, int(wide / self.pitch_mm)) * self.pitch_mm
        middle, inset = (x0 + x1) / 2, (1 - INNER_SHARE) * (y1 - y0)
        return (middle - wide / 2, y0 + inset, middle + wide / 2, y1 - inset)

    def ink_share(self, growth_mm: float) -> float:
        """Share of the patch that is inked where lines grow by that much, 0 to 1."""
        if not self.pitch_mm:
            return float(self.kind == "solid")
        return min(max((self.line_mm + growth_mm) / self.pitch_mm, 0.0), 1.0)


def strip_rect_mm(chart: Badge) -> Rect:
    """Where the strip is: between the lower markers."""
    centers, half = chart.squares.centers_mm, chart.squares.size_mm / 2
    top = centers[3][1] + BELOW_MM
    return (centers[3][0] + half + SIDE_GAP_MM, top, centers[2][0] - half - SIDE_GAP_MM, top + HIGH_MM)


def ink_patches(chart: Badge) -> tuple[InkPatch, ...]:
    """The patches of a chart, from left to right."""
    dot_mm = find_dot_mm(chart)
    fine = max(LEAST_DOTS, round(FINE_MM / dot_mm))
    pitches = {"finest": max(2, round(FINEST_RATIO * fine)), "fine": fine, "coarse": COARSE_RATIO * fine}
    x0, y0, x1, y1 = strip_rect_mm(chart)
    wide = (x1 - x0) / len(PATCHES)
    patches = []
    for k, (kind, share) in enumerate(PATCHES):
        dots = pitches.get(kind, 0)
        line = max(1, round(share * dots)) * dot_mm if dots else 0.0
        patches.append(InkPatch(kind, (x0 + k * wide, y0, x0 + (k + 1) * wide, y1), dots * dot_mm, line))
    return tuple(patches)
