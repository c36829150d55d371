"""Outlines of glyphs: as operators of a PDF, and as straight strokes.

Convention: x to the right, y up.
"""

from __future__ import annotations

from pathlib import Path

from moireid.badge import Point
from moireid.fabrication.text.fonts import face_of
from moireid.fabrication.text.shaping import ShapedLine, hb_font


def outline_of(font: Path, number: int) -> OutlinePen:
    """The outline of a font's glyph."""
    pen = OutlinePen()
    hb_font(font).draw_glyph_with_pen(number, pen)
    return pen


def line_strokes(line: ShapedLine, size_mm: float, x: float, y: float) -> list[tuple[Point, ...]]:
    """The letters of a line as closed paths of straight strokes, its baseline beginning at a place, mm."""
    loops: list[tuple[Point, ...]] = []
    for run in line.runs:
        scale = size_mm / face_of(run.font).upem
        for glyph in run.glyphs:
            left, low = x + glyph.x_em * size_mm, y + glyph.y_em * size_mm
            drawn = outline_of(run.font, glyph.number).loops()
            loops += [tuple((left + scale * u, low + scale * v) for u, v in loop) for loop in drawn]
    return loops


class OutlinePen:
    """Takes a glyph's outline as operators of a PDF, each with its figures in the font's units: m, l, c, h."""

    def __init__(self) -> None:
        self.steps: list[tuple[str, tuple[float, ...]]] = []

    def moveTo(self, to: tuple[float, float]) -> None:
        self.steps.append(("m", to))

    def lineTo(self, to: tuple[float, float]) -> None:
        self.steps.append(("l", to))

    def curveTo(self, *through: tuple[float, float]) -> None:
        self.steps.append(("c", tuple(value for point in through for value in point)))

    def qCurveTo(self, control: tuple[float, float], to: tuple[float, float]) -> None:
        """A quadratic curve as a cubic one: its inner points are two thirds of the way to the quadratic's."""
        start = self.steps[-1][1][-2:]
        first, second = ((p[0] + 2 / 3 * (control[0] - p[0]), p[1] + 2 / 3 * (control[1] - p[1])) for p in (start, to))
        self.curveTo(first, second, to)

    def closePath(self) -> None:
        self.steps.append(("h", ()))

    def loops(self) -> list[list[Point]]:
        """The closed paths, each curve as a straight stroke to its end."""
        found: list[list[Point]] = []
        for sign, values in self.steps:
            if sign == "m":
                found.append([])
            if values:
                found[-1].append((values[-2], values[-1]))
        return [[*loop, loop[0]] for loop in found]
