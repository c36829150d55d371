"""Sets words in a rectangle, their room: a name, large and bold, and lines below it.

Convention: mm; x and baseline of a line on the page; `points` is the font's size.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from moireid.artwork.colours import Colour
from moireid.artwork.placing import LEAST_POINTS, READ_FROM_M, ArtPiece
from moireid.errors import SpecError
from moireid.fabrication.page.lettering import set_name
from moireid.fabrication.page.line_breaks import divided, rows_of
from moireid.fabrication.text.direction import begins_at_the_right
from moireid.fabrication.text.shaping import ShapedLine, shape_line

MM_PER_POINT = 25.4 / 72
#: A line is at most this share of the name's size, and of a size by itself; the id's, and its share of its
#: room's height.
LINE_SHARE, LINE_POINTS, ID_POINTS, ID_SHARE = 0.5, 20.0, 8.0, 0.25
#: A name's size is at most this share of its room's height, so that names with and without lines look alike.
NAME_SHARE = 0.6
#: The id is scanned, or read from its file.
LEAST_ID_POINTS = 2.5
#: Factor on a name's score for each row that it takes; most rows of a name (True) and of a line (False).
ROW_PENALTY, MOST_ROWS = 0.85, {True: 4, False: 3}
#: Height of a capital over the size of its letters; white between rows of one line, between lines, below a name.
CAPITAL_SHARE, ROW_GAP, LINE_GAP, NAME_GAP = 0.73, 0.52, 0.75, 0.9
#: Where lines have no room so, the white is this share of it.
TIGHT = 0.7
#: Ink above and below the baseline, over the size, that the white between rows and around words has room for; a row
#: with more (stacked marks) takes the height of its ink.
TALL, DEEP = 0.93, 0.32
#: Sizes that are tried: each is this share of the one before.
STEP = 0.97


@dataclass(frozen=True)
class SetWords:
    """One row as it is set: its glyphs, their size, the place of the baseline's start, and its colour."""

    line: ShapedLine
    points: float
    x_mm: float
    baseline_mm: float
    colour: Colour

    @property
    def words(self) -> str:
        """What the row says."""
        return self.line.words


@dataclass(frozen=True)
class _Row:
    """A row before it has its place: its glyphs and size, and the white above it, mm."""

    line: ShapedLine
    bold: bool
    points: float
    gap_mm: float

    @property
    def above_mm(self) -> float:
        top = self.line.ink_em[0]
        return (top if top > TALL else CAPITAL_SHARE) * self.points * MM_PER_POINT

    @property
    def below_mm(self) -> float:
        low = -self.line.ink_em[1]
        return (low if low > DEEP else 0.0) * self.points * MM_PER_POINT


@dataclass(frozen=True)
class _Setting:
    """Where and how words are set: width and height of their room, mm; typeface; most and least size; white."""

    room: tuple[float, float]
    typeface: str
    most: float
    least: float
    white: float = 1.0


def set_words(piece: ArtPiece, badge_id: str | None) -> list[SetWords]:
    """The rows of a piece of words or of an id, in the middle of its height.

    Parameters: badge_id: the identity, for a piece that is one.
    Raises: SpecError where words would be too small to be read; it says what to shorten, and to how many letters.

    What no font here has is left out, as `lettering.set_name` says.
    """
    x0, y0, x1, y1 = piece.rect_mm
    room = (x1 - x0, y1 - y0)
    if piece.kind == "id":
        rows = _id_rows(badge_id, room, piece.typeface, min(piece.least_points, LEAST_ID_POINTS))
    else:
        name = set_name(piece.name)[0] if piece.name else ""
        lines = tuple(filter(None, (set_name(line)[0] for line in piece.lines)))
        rows = _rows_in(name, lines, _Setting(room, piece.typeface, piece.points, piece.least_points))
    spare = room[1] - _height_of(rows)
    above, below = _beyond(rows)
    # Words that are read from the right begin there, where others begin at the left.
    mirrored = piece.align == "left" and begins_at_the_right(piece.name or "".join(piece.lines[:1]))
    align = "right" if mirrored else piece.align
    y = y0 + min(max(spare / 2, above), spare - below)
    placed = []
    for row in rows:
        y += row.gap_mm + row.above_mm
        spare = room[0] - row.line.width_em * row.points * MM_PER_POINT
        x = x0 + {"left": 0.0, "center": spare / 2, "right": spare}[align]
        placed.append(SetWords(row.line, row.points, x, y, piece.colour))
        y += row.below_mm
    return placed


def _rows_in(name: str, lines: tuple[str, ...], setting: _Setting) -> list[_Row]:
    """Name and lines as large as the room allows; a name of fewer rows is preferred, and one whose words are whole.

    Raises: SpecError as `set_words`.
    """
    if not name and not lines:
        return []
    best = _whole_or_divided(name, lines, setting)
    if best is None:
        raise _no_room(name, lines, setting)
    return best


def _whole_or_divided(name: str, lines: tuple[str, ...], setting: _Setting) -> list[_Row] | None:
    best = _largest(name, lines, setting)
    if best is None and lines:
        setting = replace(setting, white=TIGHT)
        best = _largest(name, lines, setting)
    for count in (2, 3):
        # Whichever is divided: the name's longest word, then those of the lines.
        shorter = divided(name, count) if name else None
        if best is None and shorter:
            best = _largest(shorter, lines, setting)
        if best is None and lines:
            broken = tuple(divided(line, count) or line for line in lines)
            best = _largest(name, broken, setting)
    return best


def _largest(name: str, lines: tuple[str, ...], setting: _Setting) -> list[_Row] | None:
    best, best_score = None, 0.0
    most = min(setting.most, NAME_SHARE * setting.room[1] / MM_PER_POINT) if name else min(setting.most, LINE_POINTS)
    points = max(most, setting.least)
    while True:
        rows = _rows_at(name, lines, points, setting)
        if rows is not None:
            score = points * ROW_PENALTY ** sum(row.bold for row in rows)
            if score > best_score:
                best, best_score = rows, score
        if points <= setting.least or points * ROW_PENALTY < best_score:
            return best
        points = max(points * STEP, setting.least)


def _no_room(name: str, lines: tuple[str, ...], setting: _Setting) -> SpecError:
    """The error that names the longest of name and lines, and how many of its letters have room with the others."""
    whose = max((name, *lines), key=len)
    place = (name, *lines).index(whose)

    def fits(letters: int) -> bool:
        words = [name, *lines]
        words[place] = whose[:letters].strip() or whose[0]
        return _whole_or_divided(words[0], tuple(words[1:]), setting) is not None

    few, many = 0, len(whose)
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (middle, many) if fits(middle) else (few, middle)
    room, near_m = setting.room, setting.least / LEAST_POINTS * READ_FROM_M
    others = f" with {len(lines)} lines" if name and lines else ""
    shorten = f"shorten it to at most {few} letters, or take" if few else "give fewer or shorter lines, or take"
    return SpecError(
        f"{whose[:40]!r} of {len(whose)} letters{others} has no room on this badge: in {room[0]:.0f} x {room[1]:.0f} "
        f"mm letters would be smaller than {setting.least:.3g} points, the least that is read from {near_m:.2g} m; "
        f"{shorten} another template or a larger format"
    )


def _rows_at(name: str, lines: tuple[str, ...], points: float, setting: _Setting) -> list[_Row] | None:
    """All rows with a name of that size, None where they do not fit."""
    rows: list[_Row] = []
    if name:
        broken = _broken(name, points, setting, bold=True)
        if broken is None:
            return None
        rows += [_Row(row, True, points, k and ROW_GAP * points * MM_PER_POINT) for k, row in enumerate(broken)]
    size = max(min(LINE_SHARE * points, LINE_POINTS), setting.least) if name else points
    for number, line in enumerate(lines):
        while (broken := _broken(line, size, setting, bold=False)) is None and size > setting.least:
            size = max(size * STEP, setting.least)
        if broken is None:
            return None
        first = setting.white * (NAME_GAP if number == 0 else LINE_GAP)
        gaps = [first if rows else 0.0, *[ROW_GAP] * (len(broken) - 1)]
        rows += [_Row(row, False, size, gap * size * MM_PER_POINT) for row, gap in zip(broken, gaps, strict=True)]
    return rows if _height_of(rows) + sum(_beyond(rows)) <= setting.room[1] + 1e-9 else None


def _broken(words: str, points: float, setting: _Setting, *, bold: bool) -> list[ShapedLine] | None:
    """Words in rows that are no wider than the room, None where they do not fit `MOST_ROWS`; of even length."""
    for count in range(1, MOST_ROWS[bold] + 1):
        found = rows_of(words, count, setting.typeface, bold)
        if found is not None and found[1] * points * MM_PER_POINT <= setting.room[0]:
            return [shape_line(row, setting.typeface, bold=bold) for row in found[0]]
    return None


def _id_rows(badge_id: str | None, room: tuple[float, float], typeface: str, least: float) -> list[_Row]:
    """The identity in one, two or three rows, whichever comes out largest."""
    digits = badge_id or ""
    half = (len(digits) + 1) // 2
    forms = [[f"moireid {digits}".strip()], ["moireid", digits], ["moireid", digits[:half], digits[half:]]]
    best: list[ShapedLine] = []
    largest = 0.0
    for form in forms[: 3 if digits else 1]:
        rows = [shape_line(row, typeface) for row in form]
        wide = max(row.width_em for row in rows) * MM_PER_POINT
        high = (CAPITAL_SHARE + (len(rows) - 1) * (CAPITAL_SHARE + ROW_GAP)) * MM_PER_POINT
        points = min(ID_POINTS, ID_SHARE * room[1] / MM_PER_POINT, room[0] / wide, room[1] / high)
        if points > 1.02 * largest:
            best, largest = rows, points
    if largest < least:
        raise SpecError(
            f"the identity would be {largest:.1f} points high in {room[0]:.0f} x {room[1]:.0f} mm; give the template's "
            "id more room"
        )
    return [_Row(row, False, largest, k and ROW_GAP * largest * MM_PER_POINT) for k, row in enumerate(best)]


def _beyond(rows: list[_Row]) -> tuple[float, float]:
    """Ink above the first row's height and below the last one's, mm."""
    if not rows:
        return 0.0, 0.0
    first, last = rows[0], rows[-1]
    top = first.line.ink_em[0] * first.points * MM_PER_POINT
    low = -last.line.ink_em[1] * last.points * MM_PER_POINT
    return max(0.0, top - first.above_mm), max(0.0, low - last.below_mm)


def _height_of(rows: list[_Row]) -> float:
    return sum(row.gap_mm + row.above_mm + row.below_mm for row in rows)
