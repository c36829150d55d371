"""Typefaces, and the fonts that each is set in: its own, those of other scripts, then those of this machine.

The program brings Latin, Greek, Cyrillic, Arabic, Hebrew, Devanagari, Bengali, Tamil, Thai, Armenian, Georgian and
Ethiopic (`fonts/`, made by `.ci/fonts.py`), and DejaVu by matplotlib for signs.  Chinese, Japanese and Korean would
take 16 MB, so they are taken from the machine, as every other script is.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import uharfbuzz

TYPEFACES = ("sans", "serif", "slab")
OWN_FOLDER = Path(__file__).parent / "fonts"
#: The fonts of each typeface, in the order in which they are asked; those of all typefaces follow.
_OWN = {
    "sans": ("NotoSans",),
    "serif": ("NotoSerif", "NotoNaskhArabic", "NotoSerifHebrew", "NotoSerifDevanagari"),
    "slab": ("RobotoSlab", "NotoSerif"),
}
_FOR_ALL = (
    "NotoSans",
    "NotoSansArabic",
    "NotoSansHebrew",
    "NotoSansDevanagari",
    "NotoSansBengali",
    "NotoSansTamil",
    "NotoSansThai",
    "NotoSansArmenian",
    "NotoSansGeorgian",
    "NotoSansEthiopic",
)
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
#: What to install for letters from these code points on, up to the second: scripts that no shipped font has.
_PACKAGES = (
    (0x2E80, 0x9FFF, "Noto Sans CJK (on Debian and Ubuntu: fonts-noto-cjk)"),
    (0xAC00, 0xD7FF, "Noto Sans CJK (on Debian and Ubuntu: fonts-noto-cjk)"),
    (0xF900, 0xFAFF, "Noto Sans CJK (on Debian and Ubuntu: fonts-noto-cjk)"),
    (0x1F000, 0x1FAFF, "Noto Emoji, a font of emoji in black (coloured ones are not printed)"),
    (0x20000, 0x3FFFF, "Noto Sans CJK (on Debian and Ubuntu: fonts-noto-cjk)"),
)
_ANY_PACKAGE = "a Noto font of its script (on Debian and Ubuntu: fonts-noto-core)"


@cache
def plot_fonts() -> Path:
    """The folder of the DejaVu fonts that matplotlib ships, without importing it, which takes a quarter of a second."""
    spec = importlib.util.find_spec("matplotlib")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent / "mpl-data/fonts/ttf"


@cache
def own_font(name: str, *, bold: bool) -> Path:
    """The file of a shipped font, such as NotoSans."""
    stem = f"{name}-{'Bold' if bold else 'Regular'}"
    return next(path for path in (OWN_FOLDER / f"{stem}.ttf", OWN_FOLDER / f"{stem}.otf") if path.exists())


@cache
def shipped_fonts(typeface: str, bold: bool) -> tuple[Path, ...]:
    """The fonts that come with the program, in the order in which a typeface asks them."""
    names = dict.fromkeys((*_OWN[typeface], *_FOR_ALL))
    dejavu = plot_fonts() / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")
    return (*(own_font(name, bold=bold) for name in names), dejavu)


def fonts_for(typeface: str, bold: bool) -> Iterable[Path]:
    """All fonts in the order in which a typeface asks them; the machine's are looked for last, and only then."""
    yield from shipped_fonts(typeface, bold)
    yield from system_fonts(bold)


def find_font(letters: frozenset[int], typeface: str, bold: bool) -> Path | None:
    """The first font that has all of these code points, None where there is none.

    A machine always gives the same font: the typeface's in their order, then the machine's by their names, bold ones
    first.
    """
    key = (letters, typeface, bold)
    if key not in _found:
        _found[key] = next((font for font in fonts_for(typeface, bold) if letters <= font_letters(font)), None)
    return _found[key]


_found: dict[tuple[frozenset[int], str, bool], Path | None] = {}


@cache
def system_fonts(bold: bool) -> tuple[Path, ...]:
    """The fonts of this machine, those fit for a name of that weight first, then by file name."""
    found = [
        path
        for folder in FONT_FOLDERS
        for path in Path(os.path.expanduser(folder)).rglob("*")
        if path.suffix.lower() in (".ttf", ".otf", ".ttc")
    ]

    def order(path: Path) -> tuple[bool, bool, bool, str, str]:
        name = path.name.lower()
        other_weight = ("bold" in name) != bold
        return any(word in name for word in _UNFIT), other_weight, "sans" not in name, name, str(path)

    return tuple(sorted(found, key=order))


@cache
def face_of(font: Path) -> uharfbuzz.Face:
    """A font's file, read; of a collection, its first font."""
    return uharfbuzz.Face(uharfbuzz.Blob.from_file_path(str(font)))


@cache
def font_letters(font: Path) -> frozenset[int]:
    """Code points that a font has outlines for; none where it cannot be read, or holds coloured pictures alone."""
    try:
        face = face_of(font)
        drawn = {"glyf", "CFF ", "CFF2"} & set(face.table_tags)
        return frozenset(face.unicodes) if drawn else frozenset()
    except (OSError, ValueError, RuntimeError, uharfbuzz.HarfBuzzError):
        # A badge can be printed although some font on the machine is broken.
        return frozenset()


def advice_for(letter: str) -> str:
    """What to install so that a letter can be printed."""
    code = ord(letter)
    return next((what for first, last, what in _PACKAGES if first <= code <= last), _ANY_PACKAGE)
