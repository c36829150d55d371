"""Names that look alike: "Ada" in Cyrillic letters is another name, and no eye tells it from the Latin one.

Two names look alike where their skeletons are equal.  Source: Unicode Technical Standard 39, section 4, with the table
of the package `confusable-homoglyphs` (Unicode 15.1); what is written from right to left is not laid out first.
Deviation: spaces count as one, whatever their number.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from functools import cache

#: Code points that are drawn as nothing (Default_Ignorable_Code_Point), first and last of each range.
INVISIBLE = (
    (0x00AD, 0x00AD),
    (0x034F, 0x034F),
    (0x061C, 0x061C),
    (0x115F, 0x1160),
    (0x17B4, 0x17B5),
    (0x180B, 0x180F),
    (0x200B, 0x200F),
    (0x202A, 0x202E),
    (0x2060, 0x206F),
    (0x3164, 0x3164),
    (0xFE00, 0xFE0F),
    (0xFEFF, 0xFEFF),
    (0xFFA0, 0xFFA0),
    (0xFFF0, 0xFFF8),
    (0x1BCA0, 0x1BCA3),
    (0x1D173, 0x1D17A),
    (0xE0000, 0xE0FFF),
)
#: The package sets one around what is written from right to left.
MARK = "\u200e"


def skeleton(name: str) -> str:
    """What of a name the eye sees: only to be compared with another name's skeleton, never to be shown."""
    seen = unicodedata.normalize("NFD", unicodedata.normalize("NFD", name).translate(_prototypes()))
    return " ".join(seen.split())


def alike_among(names: Iterable[str], known: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """For each name that looks like a known one of other letters: the ids of those.

    Parameters: known: id and name of all who are enrolled.
    """
    wanted: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        wanted.setdefault(skeleton(name), []).append(name)
    found: dict[str, list[str]] = {}
    for badge_id, other in known:
        for name in wanted.get(skeleton(other), ()):
            if unicodedata.normalize("NFC", name) != other:
                found.setdefault(name, []).append(badge_id)
    return found


@cache
def _prototypes() -> dict[int, str]:
    """Code point -> what it looks like, for `str.translate`."""
    from confusable_homoglyphs.confusables import confusables_data

    table: dict[int, str] = {code: "" for first, last in INVISIBLE for code in range(first, last + 1)}
    for text, others in confusables_data.items():
        source, target = text.replace(MARK, ""), others[0]["c"].replace(MARK, "")
        # Each pair stands there from both sides, that of the standard's source first.  A source has one prototype, a
        # prototype mostly many sources.
        if len(others) == 1 and len(source) == 1 and (len(target) != 1 or table.get(ord(target)) != source):
            table[ord(source)] = target
    return table
