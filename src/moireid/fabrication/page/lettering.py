"""A person's name in its own script: which font can set it, and in how many lines.

PDF text is drawn letter by letter in the order given.  With the font that comes with the program this is right for
Latin, Greek and Cyrillic.  Other scripts join, stack or reorder their letters.  Pillow's shaper (Raqm) sets such names
with a font of this machine that has every letter, and they go on the page as a picture.  A letter that no font here
has, such as emoji, is left out, and the user gets a note; a name of which nothing is left is refused.  The id never
replaces a name, and the badge file keeps the whole name, because claims use it.
"""

from __future__ import annotations

import math
import os
import textwrap
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont, features

from moireid.errors import FabricationError
from moireid.fabrication.page.canvas import font_file

#: Where systems keep their fonts.
FONT_FOLDERS = (
    "/usr/share/fonts",
    "/usr/local/share/fonts",
    "~/.local/share/fonts",
    "~/.fonts",
    "/System/Library/Fonts",
    "/Library/Fonts",
    "~/Library/Fonts",
    os.path.join(os.environ.get("WINDIR", "C:/Windows"), "Fonts"),
)
#: Fonts with one of these words in their file name are not made for a name that is read from afar.
_UNFIT = ("italic", "oblique", "mono", "light", "thin", "condensed", "narrow", "emoji", "math")
#: Joiners and variation selectors only steer a shaper; a font needs no letter for them.
_JOINERS = "\u200c\u200d\ufe0e\ufe0f"
_SILENT = frozenset(_JOINERS + " ")
#: Dots per inch of a name that is set as a picture.
PICTURE_DPI = 1200
MOST_LINES, LINE_HEIGHT = 6, 1.25
#: A longer word is broken.
MOST_LETTERS = 30


def printable(words: str) -> bool:
    """Whether plain PDF text in the badge's own font spells the words right.

    That is: the font has every letter, none is read from right to left, and no mark goes on or around another letter.
    """
    if words.isascii():
        # True of nearly every list of names; then the packages that read fonts need not be imported.
        return True
    letters = font_letters(font_file(bold=True))
    return all(
        ord(letter) in letters
        and unicodedata.bidirectional(letter) not in ("R", "AL")
        and not unicodedata.category(letter).startswith("M")
        and letter not in _SILENT - {" "}
        for letter in words
    )


def font_for(words: str) -> Path | None:
    """A font that the words can be set in, the badge's own if it can; None where this machine has none.

    A machine always gives the same font: files are tried in the order of their names, bold ones first.
    """
    if printable(words):
        return font_file(bold=True)
    if not features.check("raqm"):
        return None
    needed = frozenset(ord(letter) for letter in words if letter not in _SILENT)
    return _first_with(needed)


@dataclass(frozen=True)
class SetName:
    """How a name is printed: its words, their font, and the letters that no font here has, which are left out."""

    words: str
    font: Path | None
    left_out: tuple[str, ...] = ()


@lru_cache(maxsize=1024)
def set_name(name: str) -> SetName:
    """How a name is printed on this machine; without words where no font has a letter or digit of it."""
    if (font := font_for(name)) is not None:
        return SetName(name, font)
    has = _most_of(name)
    # A joiner or a variation selector goes with the letter before it.
    kept, before = [], True
    for letter in name:
        before = before if letter in _SILENT - {" "} else has(letter)
        kept.append(letter if before else "")
    words = " ".join("".join(kept).strip(_JOINERS).split())
    missing = tuple(dict.fromkeys(letter for letter in name if letter not in _SILENT and not has(letter)))
    if not any(unicodedata.category(letter)[0] in "LN" for letter in words):
        return SetName("", None, missing)
    return SetName(words, font_for(words), missing)


def name_note(name: str) -> str | None:
    """One sentence about what the print leaves out of a name; None where it shows all of it.

    Raises: FabricationError where no font of this machine has a letter of it.
    """
    found = set_name(name)
    if not found.left_out:
        return None
    lacking = _list_letters(found.left_out)
    if found.font is None:
        raise FabricationError(
            f"no font on this machine has a letter of the name {name[:80]!r} ({lacking}), so the badge would bear no "
            "name; install a font for its script (such as Noto Sans), or give the name in other letters"
        )
    return (
        f"the print leaves out of {name[:80]!r} what no font on this machine has ({lacking}), and shows "
        f"{found.words[:80]!r}; claims go on naming the whole name"
    )


def line_note(line: str) -> str | None:
    """One sentence about what the print leaves out of a line below the name; None where it shows all of it."""
    found = set_name(line)
    if not found.left_out:
        return None
    shows = f"shows {found.words[:80]!r}" if found.words else "shows nothing of it"
    lacking = _list_letters(found.left_out)
    return f"the print leaves out of {line[:80]!r} what no font on this machine has ({lacking}), and {shows}"


def _most_of(name: str) -> Callable[[str], bool]:
    """A test for printed letters: those that plain text or a shaper can set in the font that has most of them."""
    if not features.check("raqm"):
        return printable
    needed = frozenset(ord(letter) for letter in name if letter not in _SILENT)
    fonts = (font_file(bold=True), *system_fonts())
    best = max(fonts, key=lambda font: len(needed & font_letters(font)))
    return lambda letter: letter in _SILENT or ord(letter) in font_letters(best)


def _list_letters(letters: tuple[str, ...]) -> str:
    """At most three: letters as they are, signs such as emoji by their Unicode names."""
    names = [
        letter
        if unicodedata.category(letter).startswith("L")
        else unicodedata.name(letter, f"U+{ord(letter):04X}").lower()
        for letter in letters
    ]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def lines_for(
    words: str, width_mm: Callable[[str], float], room_mm: tuple[float, float], line_mm: float
) -> tuple[list[str], float]:
    """How to break words so that they come out as large as a room allows, and their scale then, at most 1.

    Parameters: width_mm: of a line at full size; room_mm: width and height; line_mm: height of a line at full size.
    """
    longest = max(map(len, words.split()))
    # Words are kept whole, unless one is so long that its letters would be tiny.
    least = longest if longest <= MOST_LETTERS else 1
    best: tuple[list[str], float] = ([words], 0.0)
    for count in range(1, MOST_LINES + 1):
        letters = max(math.ceil(len(words) / count), least)
        lines = textwrap.wrap(words, letters) if count > 1 else [words]
        while len(lines) > count:
            letters += 1
            lines = textwrap.wrap(words, letters)
        share = min(1.0, room_mm[0] / max(map(width_mm, lines)), room_mm[1] / (line_mm * len(lines)))
        if share > best[1] + 1e-9:
            best = lines, share
    return best


def name_picture(words: str, font: Path, room_mm: tuple[float, float], points: float, dpi: float) -> Image.Image:
    """The words as a grey picture, black on white, as large as `points` or as the room allows."""
    px_per_mm = dpi / 25.4
    full = ImageFont.truetype(str(font), max(1, round(points / 72 * dpi)))
    lines, share = lines_for(
        words, lambda line: full.getlength(line) / px_per_mm, room_mm, LINE_HEIGHT * points / 72 * 25.4
    )
    text, scratch = "\n".join(lines), ImageDraw.Draw(Image.new("L", (1, 1)))
    while True:
        set_in = full.font_variant(size=max(1, int(full.size * share)))
        gap = (LINE_HEIGHT - 1) * set_in.size
        box = scratch.multiline_textbbox((0, 0), text, font=set_in, spacing=gap, align="center")
        # Signs that are stacked above and below the letters make the text taller than its lines.
        if set_in.size == 1 or (
            box[2] - box[0] <= room_mm[0] * px_per_mm + 1 and box[3] - box[1] <= room_mm[1] * px_per_mm + 1
        ):
            break
        share *= 0.95
    picture = Image.new("L", (math.ceil(box[2] - box[0]) + 2, math.ceil(box[3] - box[1]) + 2), 255)
    place = (1 - math.floor(box[0]), 1 - math.floor(box[1]))
    ImageDraw.Draw(picture).multiline_text(place, text, fill=0, font=set_in, spacing=gap, align="center")
    return picture


@lru_cache(maxsize=1024)
def _first_with(needed: frozenset[int]) -> Path | None:
    """The first font with all of these letters; the badge's own, which has Arabic and Hebrew, before the system's."""
    fonts = (font_file(bold=True), *system_fonts())
    return next((font for font in fonts if needed <= font_letters(font)), None)


@cache
def system_fonts() -> tuple[Path, ...]:
    """The fonts of this machine, those fit for a name first, then by file name."""
    found = [
        path
        for folder in FONT_FOLDERS
        for path in Path(folder).expanduser().rglob("*")
        if path.suffix.lower() in (".ttf", ".otf", ".ttc")
    ]

    def order(path: Path) -> tuple[bool, bool, bool, str, str]:
        name = path.name.lower()
        return any(word in name for word in _UNFIT), "bold" not in name, "sans" not in name, name, str(path)

    return tuple(sorted(found, key=order))


@cache
def font_letters(font: Path) -> frozenset[int]:
    """Code points that a font has outlines for; none where it cannot be read, or holds coloured pictures alone."""
    from fontTools.ttLib import TTFont, TTLibError

    try:
        with TTFont(font, lazy=True, fontNumber=0) as file:
            drawn = any(table in file for table in ("glyf", "CFF ", "CFF2"))
            return frozenset(file.getBestCmap() or ()) if drawn else frozenset()
    except (OSError, TTLibError, AssertionError, KeyError, ValueError):
        # A badge can be printed although some font on the machine is broken.
        return frozenset()
