"""Words → glyphs with their places, in the order in which they are seen: direction, font, then HarfBuzz.

1. Levels: which letters run from right to left (`direction.py`).
2. Fonts: the first of the typeface's that has a whole word; where none has, letter by letter, each with its marks.
3. HarfBuzz joins, stacks and places the letters of each run of one level and font.
4. Runs in the order in which they are seen (rule L2 of the algorithm).

Convention: shares of the letters' size (em); x to the right from the line's start, y up from its baseline.
Source: Unicode Standard Annex 9; HarfBuzz.
"""

from __future__ import annotations

import itertools
import re
import unicodedata
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import uharfbuzz

from moireid.fabrication.text.direction import bidi_levels
from moireid.fabrication.text.fonts import face_of, find_font

#: Joiners and variation selectors only steer a shaper; a font needs no letter for them.
JOINERS = "\u200c\u200d\ufe0e\ufe0f"
SILENT = frozenset(JOINERS + " ")


@dataclass(frozen=True)
class Glyph:
    """One glyph: its number in the font, its place, and the letters that it stands for, from left to right."""

    number: int
    x_em: float
    y_em: float
    letters: str


@dataclass(frozen=True)
class GlyphRun:
    """Glyphs of one font and one direction, from left to right; backwards: they are read from right to left."""

    font: Path
    backwards: bool
    glyphs: tuple[Glyph, ...]


@dataclass(frozen=True)
class ShapedLine:
    """One line: its words as they are read, its runs from left to right; ink: reach above and below the baseline."""

    words: str
    runs: tuple[GlyphRun, ...]
    width_em: float
    ink_em: tuple[float, float]


@cache
def hb_font(font: Path) -> uharfbuzz.Font:
    """The font at a size of its units."""
    return uharfbuzz.Font(face_of(font))


@lru_cache(maxsize=4096)
def shape_line(words: str, typeface: str = "sans", *, bold: bool = False) -> ShapedLine:
    """The glyphs of a line in a typeface.

    What no font has is shown as the font's empty box: `lettering.set_name` takes it out before.
    """
    levels = bidi_levels(words)
    fonts = _fonts_of(words, typeface, bold)
    runs: list[tuple[int, Path, int, int]] = []
    for place, (level, font) in enumerate(zip(levels, fonts, strict=True)):
        if runs and runs[-1][:2] == (level, font):
            runs[-1] = (level, font, runs[-1][2], place + 1)
        else:
            runs.append((level, font, place, place + 1))
    x, top, low = 0.0, 0.0, 0.0
    shaped = []
    for level, font, begin, end in _as_seen(runs):
        glyphs, x, ink = _shape(words, begin, end, font, bool(level % 2), x)
        top, low = max(top, ink[0]), min(low, ink[1])
        shaped.append(GlyphRun(font, bool(level % 2), glyphs))
    return ShapedLine(words, tuple(shaped), x, (top, low))


def _as_seen(runs: list[tuple[int, Path, int, int]]) -> list[tuple[int, Path, int, int]]:
    """Runs in the order in which they are seen.  Source: UAX 9, L2."""
    runs = list(runs)
    for level in range(max((run[0] for run in runs), default=0), 0, -1):
        place = 0
        while place < len(runs):
            end = place
            while end < len(runs) and runs[end][0] >= level:
                end += 1
            runs[place:end] = runs[place:end][::-1]
            place = max(end, place + 1)
    return runs


def clusters(words: str) -> list[str]:
    """Letters, each with the marks, joiners and selectors that follow it, and what a joiner joins to it."""
    found: list[str] = []
    for letter in words:
        follows = letter in JOINERS or unicodedata.category(letter).startswith("M")
        if found and (follows or found[-1].endswith("\u200d")):
            found[-1] += letter
        else:
            found.append(letter)
    return found


def _needed(words: str) -> frozenset[int]:
    return frozenset(ord(letter) for letter in words if letter not in SILENT)


def _fonts_of(words: str, typeface: str, bold: bool) -> list[Path]:
    """The font of each letter."""
    first = find_font(frozenset(), typeface, bold)
    assert first is not None
    fonts: list[Path] = []
    for part in re.findall(r"[ ]+|[^ ]+", words):
        whole = (fonts or [first])[-1] if part.isspace() else find_font(_needed(part), typeface, bold)
        if whole is not None:
            fonts += [whole] * len(part)
            continue
        for cluster in clusters(part):
            fonts += [find_font(_needed(cluster), typeface, bold) or first] * len(cluster)
    return fonts


def _shape(
    words: str, begin: int, end: int, font: Path, backwards: bool, x: float
) -> tuple[tuple[Glyph, ...], float, tuple[float, float]]:
    """The glyphs of a run that begins at x, where it ends, and its ink's highest and lowest place."""
    buffer, face = uharfbuzz.Buffer(), hb_font(font)
    # With what is next to the run: an Arabic letter that another font sets still joins.
    buffer.add_codepoints([ord(letter) for letter in words], begin, end - begin)
    buffer.guess_segment_properties()
    buffer.direction = "rtl" if backwards else "ltr"
    uharfbuzz.shape(face, buffer)
    em, infos = face.face.upem, buffer.glyph_infos
    letters = _spelled(words, [info.cluster for info in infos], end, backwards=backwards)
    glyphs, top, low = [], 0.0, 0.0
    for info, place, spelled in zip(infos, buffer.glyph_positions, letters, strict=True):
        y = place.y_offset / em
        glyphs.append(Glyph(info.codepoint, x + place.x_offset / em, y, spelled))
        extents = face.get_glyph_extents(info.codepoint)
        if extents is not None and extents.height:
            top, low = max(top, y + extents.y_bearing / em), min(low, y + (extents.y_bearing + extents.height) / em)
        x += place.x_advance / em
    return tuple(glyphs), x, (top, low)


def _spelled(words: str, clusters_of: list[int], end: int, *, backwards: bool) -> list[str]:
    """The letters of each glyph: the first glyph that is read of a cluster has all of its letters, the others none."""
    starts = [*sorted(set(clusters_of)), end]
    until = dict(itertools.pairwise(starts))
    found = [""] * len(clusters_of)
    order = range(len(clusters_of))
    for k in reversed(order) if backwards else order:
        stop = until.pop(clusters_of[k], None)
        if stop is not None:
            letters = words[clusters_of[k] : stop]
            found[k] = _as_seen_letters(letters) if backwards else letters
    return found


def _as_seen_letters(letters: str) -> str:
    """Letters that run from right to left as they are seen; readers of PDFs turn them round."""
    from bidi.mirror import MIRRORED

    return "".join(MIRRORED.get(letter, letter) for letter in reversed(letters))
