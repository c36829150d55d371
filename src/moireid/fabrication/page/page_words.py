"""Sets words in a rectangle, their room: a name, large and bold, and lines below it.

Convention: mm; x and baseline of a line on the page; `points` is the font's size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from PIL import Image, ImageFont

from moireid.artwork.placing import ArtPiece
from moireid.errors import SpecError
from moireid.fabrication.page.canvas import font_file
from moireid.fabrication.page.lettering import LINE_HEIGHT, PICTURE_DPI, font_for, name_picture, printable, set_name

MM_PER_POINT = 25.4 / 72
#: A line is at most this share of the name's size, and of a size by itself; the id's, and its share of its
#: room's height.
LINE_SHARE, LINE_POINTS, ID_POINTS, ID_SHARE = 0.5, 20.0, 8.0, 0.25
#: A name's size is at most this share of its room's height, so that names with and without lines look alike.
NAME_SHARE = 0.6
#: Smaller letters cannot be read; the id is scanned, or read from its file.
LEAST_POINTS, LEAST_ID_POINTS = 4.0, 2.5
#: Factor on a name's score for each row that it takes; most rows of a name (True) and of a line (False).
ROW_PENALTY, MOST_ROWS = 0.85, {True: 3, False: 2}
#: Height of a capital over the size of its letters; white between rows of one line, between lines, below a name.
CAPITAL_SHARE, ROW_GAP, LINE_GAP, NAME_GAP = 0.73, LINE_HEIGHT - 0.73, 0.75, 0.9
#: Sizes that are tried: each is this share of the one before.
STEP = 0.97
#: Shares of a room's height that words with tall signs are set in, tried in turns.
SHRINKING = (1.0, 0.85, 0.7, 0.55, 0.4)


@dataclass(frozen=True)
class SetWords:
    """One row as it is set: words in a font of the program, or a picture (black on white, `PICTURE_DPI`) of them.

    ascent_mm: from the baseline up to the picture's upper end.
    """

    words: str
    bold: bool
    points: float
    x_mm: float
    baseline_mm: float
    align: str
    picture: Image.Image | None = None
    ascent_mm: float = 0.0

    @property
    def ink_mm(self) -> tuple[float, float]:
        """Upper and lower end of the picture on the page."""
        assert self.picture is not None
        top = self.baseline_mm - self.ascent_mm
        return top, top + self.picture.height / PICTURE_DPI * 25.4


@dataclass(frozen=True)
class _Row:
    """A row before it has its place: its words and size, and the white above it, mm."""

    words: str
    bold: bool
    points: float
    gap_mm: float

    @property
    def height_mm(self) -> float:
        return CAPITAL_SHARE * self.points * MM_PER_POINT


def set_words(piece: ArtPiece, badge_id: str | None) -> list[SetWords]:
    """The rows of a piece of words or of an id, in the middle of its height.

    Parameters: badge_id: the identity, for a piece that is one.
    Raises: SpecError where words would be too small to be read.

    What no font here has is left out, as `lettering.set_name` says.  Signs above and below letters may need more than a
    row's height; the words are then set smaller.
    """
    _, y0, _, y1 = piece.rect_mm
    for share in SHRINKING:
        placed = _placed(piece, badge_id, share)
        if all(y0 - 1e-6 <= top and low <= y1 + 1e-6 for top, low in (one.ink_mm for one in placed if one.picture)):
            return placed
    raise SpecError(
        f"{(piece.name or piece.lines[0])[:40]!r} has more signs above and below its letters than there is room for; "
        "shorten it, or take a larger format"
    )


def _placed(piece: ArtPiece, badge_id: str | None, share: float) -> list[SetWords]:
    """The rows in that share of the room's height, about its middle."""
    x0, y0, x1, y1 = piece.rect_mm
    room = (x1 - x0, share * (y1 - y0))
    y0, y1 = (y0 + y1 - room[1]) / 2, (y0 + y1 + room[1]) / 2
    if piece.kind == "id":
        rows = _id_rows(badge_id, room)
    else:
        name = set_name(piece.name).words if piece.name else ""
        rows = _largest(name, tuple(filter(None, (set_name(line).words for line in piece.lines))), piece.points, room)
    y = y0 + (room[1] - _height_of(rows)) / 2
    x = {"left": x0, "center": (x0 + x1) / 2, "right": x1}[piece.align]
    placed = []
    for row in rows:
        y += row.gap_mm + row.height_mm
        picture, ascent_mm = _picture(row.words, row.points)
        placed.append(SetWords(row.words, row.bold, row.points, x, y, piece.align, picture, ascent_mm))
    return placed


def _largest(name: str, lines: tuple[str, ...], most: float, room: tuple[float, float]) -> list[_Row]:
    """Name and lines as large as the room allows; a name of fewer rows is preferred."""
    best: list[_Row] = []
    if not name and not lines:
        return best
    points, best_score = min(most, NAME_SHARE * room[1] / MM_PER_POINT) if name else min(most, LINE_POINTS), 0.0
    while points >= 0.5 * LEAST_POINTS:
        rows = _rows_at(name, lines, points, room)
        if rows is not None:
            score = points * ROW_PENALTY ** sum(row.bold for row in rows)
            if score > best_score:
                best, best_score = rows, score
        if points * ROW_PENALTY < best_score:
            break
        points *= STEP
    small = [row for row in best if row.points < LEAST_POINTS]
    if not best or small:
        whose = repr((small[0].words if small else name or lines[0])[:40])
        whose += f" with {len(lines)} lines" if not small and name and lines else ""
        raise SpecError(
            f"{whose} has no room on this badge: in {room[0]:.0f} x {room[1]:.0f} mm its letters would be smaller than "
            f"{LEAST_POINTS:g} points; shorten it, or take fewer lines, another template or a larger format"
        )
    return best


def _rows_at(name: str, lines: tuple[str, ...], points: float, room: tuple[float, float]) -> list[_Row] | None:
    """All rows with a name of that size, None where they do not fit."""
    rows: list[_Row] = []
    if name:
        broken = _broken(name, points, room[0], bold=True)
        if broken is None:
            return None
        rows += [_Row(row, True, points, k and ROW_GAP * points * MM_PER_POINT) for k, row in enumerate(broken)]
    size = max(min(LINE_SHARE * points, LINE_POINTS), min(LEAST_POINTS, points)) if name else points
    for number, line in enumerate(lines):
        while (broken := _broken(line, size, room[0], bold=False)) is None and size > 0.5 * LEAST_POINTS:
            size *= STEP
        if broken is None:
            return None
        first = NAME_GAP if number == 0 else LINE_GAP
        gaps = [first if rows else 0.0, *[ROW_GAP] * (len(broken) - 1)]
        rows += [_Row(row, False, size, gap * size * MM_PER_POINT) for row, gap in zip(broken, gaps, strict=True)]
    return rows if _height_of(rows) <= room[1] + 1e-9 else None


def _broken(words: str, points: float, room_mm: float, *, bold: bool) -> list[str] | None:
    """Words in rows that are no wider than the room, None where they do not fit `MOST_ROWS`; of even length."""
    parts = words.split()
    for count in range(1, MOST_ROWS[bold] + 1):
        rows = _even(parts, count)
        if rows is not None and all(width_mm(row, points, bold=bold) <= room_mm for row in rows):
            return rows
    return None


def _even(parts: list[str], count: int) -> list[str] | None:
    """Words in `count` rows, the longest as short as possible."""
    if count > len(parts):
        return None
    if count == 1:
        return [" ".join(parts)]
    splits = [
        [" ".join(parts[:k]), *rest]
        for k in range(1, len(parts) - count + 2)
        if (rest := _even(parts[k:], count - 1)) is not None
    ]
    return min(splits, key=lambda rows: max(map(len, rows)))


def _id_rows(badge_id: str | None, room: tuple[float, float]) -> list[_Row]:
    """The identity in one, two or three rows, whichever comes out largest."""
    digits = badge_id or ""
    half = (len(digits) + 1) // 2
    forms = [[f"moireid {digits}".strip()], ["moireid", digits], ["moireid", digits[:half], digits[half:]]]
    best, largest = forms[0], 0.0
    for rows in forms[: 3 if digits else 1]:
        wide = max(width_mm(row, 1.0, bold=False) for row in rows)
        high = (CAPITAL_SHARE + (len(rows) - 1) * LINE_HEIGHT) * MM_PER_POINT
        points = min(ID_POINTS, ID_SHARE * room[1] / MM_PER_POINT, room[0] / wide, room[1] / high)
        if points > 1.02 * largest:
            best, largest = rows, points
    if largest < LEAST_ID_POINTS:
        raise SpecError(
            f"the identity would be {largest:.1f} points high in {room[0]:.0f} x {room[1]:.0f} mm; give the template's "
            "id more room"
        )
    return [_Row(row, False, largest, k and ROW_GAP * largest * MM_PER_POINT) for k, row in enumerate(best)]


def _height_of(rows: list[_Row]) -> float:
    return sum(row.gap_mm + row.height_mm for row in rows)


def width_mm(words: str, points: float, *, bold: bool) -> float:
    """Width of a row in its font, mm; of the program's own font where that has the letters."""
    if printable(words):
        return float(_metrics(bold)(words)) * points * MM_PER_POINT
    return _shaped_width(words, font_for(words) or font_file(bold=bold)) * points * MM_PER_POINT


@lru_cache(maxsize=4096)
def _shaped_width(words: str, font: Path) -> float:
    """Width of words at a size of one, as Pillow's shaper sets them; nothing is drawn for it."""
    large = _font_of(font, 1000)
    left, _, right, _ = large.getbbox(words)
    return max(float(large.getlength(words)), right - min(left, 0)) / 1000


@lru_cache(maxsize=32)
def _font_of(font: Path, size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(font), size)


@cache
def _metrics(bold: bool) -> Callable[[str], float]:
    """Width of words at a size of one, as the PDF sets them."""
    from reportlab.pdfbase.ttfonts import TTFont

    font: Any = TTFont(f"moireid-{bold}", str(font_file(bold=bold)))
    return lambda words: float(font.stringWidth(words, 1.0))


def _picture(words: str, points: float) -> tuple[Image.Image | None, float]:
    """A picture of words that the PDF's own text cannot spell, and how far it reaches above the baseline, mm."""
    font = font_for(words)
    return (None, 0.0) if printable(words) or font is None else _picture_of(words, font, points)


# A page asks for the few pictures of a badge several times; those of a whole list would fill the memory.
@lru_cache(maxsize=8)
def _picture_of(words: str, font: Path, points: float) -> tuple[Image.Image, float]:
    picture = name_picture(words, font, (1e6, 1e6), points, PICTURE_DPI)
    # The picture has a pixel of white around its ink.
    above = 1 - _font_of(font, max(1, round(points / 72 * PICTURE_DPI))).getbbox(words, anchor="ls")[1]
    return picture, above / PICTURE_DPI * 25.4
