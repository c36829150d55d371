"""Where words break into rows: at spaces, after hyphens, between Chinese, Japanese and Korean letters; and, as a last
resort, within a word.

A name is in no known language, so no dictionary of hyphenation fits it.  A word of Latin, Greek, Cyrillic, Armenian or
Georgian letters that is too wide for its room is divided with a hyphen into parts of even length, near its middle
where a vowel meets a consonant.  Words of scripts that join or stack their letters are never divided.

Convention: widths in em, shares of the letters' size.
"""

from __future__ import annotations

import itertools
import re
import unicodedata
from functools import lru_cache

from moireid.fabrication.text.shaping import clusters, shape_line

#: Marks a division; no name holds one (`moireid.names.INVISIBLE`).
SOFT = "\u00ad"
HYPHENS = "-\u2010\u2013\u00b7/"
#: Scripts, as Unicode's names of letters begin, whose words are divided with a hyphen.
_DIVIDED = ("LATIN", "GREEK", "CYRILLIC", "ARMENIAN", "GEORGIAN")
_VOWELS = frozenset("aeiouyæøœαεηιουωаеёиоуыэюяієїў")
#: The division is at most this many letters from the even one; each part keeps at least so many.
_AROUND, _LEAST_PART = 2, 3


@lru_cache(maxsize=2048)
def rows_of(words: str, count: int, typeface: str, bold: bool) -> tuple[tuple[str, ...], float] | None:
    """Words in that many rows, as even as can be, and the widest row's width; None where they have no such breaks."""
    if count == 1:
        return (_shown(words),), shape_line(_shown(words), typeface, bold=bold).width_em
    parts = _parts(words)
    if count > len(parts):
        return None
    wide = [shape_line(_shown(part.strip()), typeface, bold=bold).width_em for part in parts]
    low, high = max(wide), sum(wide) + len(wide)
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (low, middle) if len(_filled(parts, wide, middle)) <= count else (middle, high)
    rows = [_shown(row) for row in _filled(parts, wide, high)]
    if len(rows) != count:
        return None
    return tuple(rows), max(shape_line(row, typeface, bold=bold).width_em for row in rows)


def divided(words: str, count: int) -> str | None:
    """The words with their longest word divided into that many parts by soft hyphens, which `rows_of` breaks at.

    None where that word's script has no such division, or its parts would be too short.
    """
    words_apart = words.split(" ")
    longest = max(words_apart, key=len)
    letters = clusters(longest)
    if len(letters) < count * _LEAST_PART or not all(_divides(cluster) for cluster in letters):
        return None
    places = [0, *(_syllable_near(letters, round(k * len(letters) / count)) for k in range(1, count)), len(letters)]
    parts = ["".join(letters[one:other]) for one, other in itertools.pairwise(places)]
    words_apart[words_apart.index(longest)] = SOFT.join(parts)
    return " ".join(words_apart)


def _shown(row: str) -> str:
    """A row with a hyphen where it ends at a division."""
    return row.replace(SOFT, "") + ("-" if row.endswith(SOFT) and row[-2:-1] not in HYPHENS else "")


def _divides(cluster: str) -> bool:
    letter = cluster[0]
    return unicodedata.name(letter, "").startswith(_DIVIDED) or not letter.isalpha()


def _syllable_near(letters: list[str], even: int) -> int:
    """The place nearest to the even one with a vowel before it and a consonant after it; else the even one."""

    def vowel(place: int) -> bool:
        return unicodedata.normalize("NFD", letters[place].lower())[0] in _VOWELS

    near = sorted(range(even - _AROUND, even + _AROUND + 1), key=lambda place: (abs(place - even), place))
    return next((place for place in near if 0 < place < len(letters) and vowel(place - 1) and not vowel(place)), even)


def _parts(words: str) -> list[str]:
    """Where rows may begin: each part with the space that follows it."""
    parts: list[str] = []
    for word in re.findall(rf"[^ ]+? ?(?:(?<=[{re.escape(HYPHENS + SOFT)}])(?=[^ ])|(?<= )|$)", words):
        ideographs = [unicodedata.east_asian_width(letter) in "WF" for letter in word.strip()]
        parts += clusters(word) if len(word) > 1 and all(ideographs) else [word]
    # A space that followed an ideograph goes to the part before it.
    joined: list[str] = []
    for part in parts:
        if part == " " and joined:
            joined[-1] += part
        else:
            joined.append(part)
    return joined


def _filled(parts: list[str], wide: list[float], most: float) -> list[str]:
    """Rows that are filled one after the other up to that width."""
    rows, width = [""], 0.0
    for part, one in zip(parts, wide, strict=True):
        space = 0.3 if rows[-1].endswith(" ") else 0.0
        if rows[-1] and width + space + one > most:
            rows[-1] = rows[-1].strip()
            rows.append("")
            width = space = 0.0
        rows[-1] += part
        width += space + one
    rows[-1] = rows[-1].strip()
    return rows
