"""Names that look alike: "Ada" in Cyrillic letters is another name, but looks the same as the Latin one.

Two names look alike if their skeletons are equal, or the skeletons of both in lower case and plain width.  Source:
Unicode Technical Standard 39, section 4, with the table of the package `confusable-homoglyphs` (Unicode 15.1); text
that is written from right to left is not reordered first.  Deviation: a run of spaces counts as one space.

The registry keeps both skeletons of each name in columns with an index.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from functools import cache
from importlib import resources

import msgspec

from moireid.names import INVISIBLE

#: The package sets one around what is written from right to left.
MARK = "\u200e"


def skeleton(name: str) -> str:
    """A name reduced to its looks: only to be compared with another name's skeleton, never to be shown."""
    seen = unicodedata.normalize("NFD", unicodedata.normalize("NFD", name).translate(_prototypes()))
    return " ".join(seen.split())


def folded_skeleton(name: str) -> str:
    """As `skeleton`, of the name in lower case and plain width: case and width hide who is meant, too."""
    plain = unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())
    return skeleton(plain)


def alike_within(names: Iterable[str]) -> list[tuple[str, str]]:
    """Pairs of names in a list that look alike: each name with the first one there that it looks like."""
    first: dict[str, str] = {}
    pairs = []
    for name in dict.fromkeys(unicodedata.normalize("NFC", one) for one in names):
        keys = {"seen " + skeleton(name), "folded " + folded_skeleton(name)}
        other = next((first[key] for key in sorted(keys, reverse=True) if key in first), None)
        if other is not None:
            pairs.append((name, other))
        for key in keys:
            first.setdefault(key, name)
    return pairs


@cache
def _prototypes() -> dict[int, str]:
    """Code point -> what it looks like, for `str.translate`."""
    # Of the package only its table is read, as its code loads a client of the web; and pair by pair, as that takes less
    # memory.
    packed = resources.files("confusable_homoglyphs").joinpath("confusables.json").read_bytes()
    pairs, read = msgspec.json.decode(packed, type=dict[str, msgspec.Raw]), msgspec.json.Decoder(list[dict[str, str]])
    table: dict[int, str] = {code: "" for first, last in INVISIBLE for code in range(first, last + 1)}
    for text, pair in pairs.items():
        others = read.decode(pair)
        source, target = text.replace(MARK, ""), others[0]["c"].replace(MARK, "")
        # The table has each pair in both directions, that of the standard's source first.  A source has one prototype,
        # a prototype mostly many sources.
        if len(others) == 1 and len(source) == 1 and (len(target) != 1 or table.get(ord(target)) != source):
            table[ord(source)] = target
    return table
