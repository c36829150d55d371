"""Which letters of a name or line are printed: all that a font of the program or of this machine has.

A letter that no font here has, such as emoji, is left out, and the user gets a note with what to install; a name of
which nothing is left is refused.  The id never replaces a name, and the badge file keeps the whole name, because
claims use it.
"""

from __future__ import annotations

import unicodedata
from functools import lru_cache

from moireid.errors import FabricationError
from moireid.fabrication.text.fonts import advice_for, find_font
from moireid.fabrication.text.shaping import JOINERS, SILENT, clusters


@lru_cache(maxsize=1024)
def set_name(name: str) -> tuple[str, tuple[str, ...]]:
    """How a name is printed on this machine, and its letters that no font here has, which are left out.

    Returns: no words where no font has a letter or digit of it.
    """
    missing = tuple(dict.fromkeys(letter for letter in name if not _printable(letter)))
    if not missing:
        return name, ()
    kept = [cluster for whole in clusters(name) for cluster in ([whole] if _printable(whole) else _parts_of(whole))]
    words = " ".join("".join(kept).strip(JOINERS).split())
    if not any(unicodedata.category(letter)[0] in "LN" for letter in words):
        return "", missing
    return words, missing


def _printable(cluster: str) -> bool:
    """Whether a font has a letter with its marks; the typefaces share their fonts for what one of them lacks."""
    needed = frozenset(ord(letter) for letter in cluster if letter not in SILENT)
    return find_font(needed, "sans", True) is not None


def _parts_of(cluster: str) -> list[str]:
    """What is printed of a letter with marks that no font has together; of a joined sign nothing: parts are others."""
    if "\u200d" in cluster:
        return []
    return [letter for letter in cluster if letter not in JOINERS and _printable(letter)]


def name_note(name: str) -> str | None:
    """One sentence about what the print leaves out of a name; None where it shows all of it.

    Raises: FabricationError where no font of this machine has a letter of it.
    """
    note = line_note(name, "; claims go on naming the whole name")
    if note is not None and not set_name(name)[0]:
        raise FabricationError(f"{line_note(name)}, or give the name in other letters, as a badge must bear one")
    return note


def line_note(line: str, more: str = "") -> str | None:
    """One sentence about what the print leaves out of a line below the name; None where it shows all of it."""
    printed, left_out = set_name(line)
    if not left_out:
        return None
    shows = f"shows {printed[:80]!r}" if printed else "shows nothing of it"
    return (
        f"the print leaves out of {line[:80]!r} what no font on this machine has ({_list_letters(left_out)}), "
        f"and {shows}{more}; to print all of it, install {advice_for(left_out[0])}"
    )


def _list_letters(letters: tuple[str, ...]) -> str:
    """At most three: letters as they are, signs such as emoji by their Unicode names."""
    names = [
        letter
        if unicodedata.category(letter).startswith("L")
        else unicodedata.name(letter, f"U+{ord(letter):04X}").lower()
        for letter in letters
    ]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
