"""Which letters of a line run from right to left: Unicode's bidirectional algorithm.

python-bidi takes the steps; its version in Python gives levels, but leaves out the rule of paired brackets, which is
added here.  A test compares what comes out with python-bidi's other version, which has it.

Source: Unicode Standard Annex 9, rules P2 to I2 without those of signs that set a direction, which no name holds
    (`moireid.names`).
"""

from __future__ import annotations

import unicodedata
from typing import Any


def bidi_levels(words: str) -> list[int]:
    """The embedding level of each letter: odd where it runs from right to left."""
    if all(ord(letter) < 0x590 for letter in words):
        return [0] * len(words)
    from bidi import algorithm

    # Joiners go with the letter before them (X9); the steps do not know them.
    joiner = [unicodedata.bidirectional(letter) in ("BN", "") for letter in words]
    storage: dict[str, Any] = algorithm.get_empty_storage()
    spelled = "".join(letter for letter, silent in zip(words, joiner, strict=True) if not silent)
    storage["base_level"] = algorithm.get_base_level(spelled)
    storage["base_dir"] = ("L", "R")[storage["base_level"]]
    algorithm.get_embedding_levels(spelled, storage)
    algorithm.calc_level_runs(storage)
    algorithm.resolve_weak_types(storage)
    _resolve_brackets(storage["chars"], storage["base_dir"])
    algorithm.resolve_neutral_types(storage, False)
    algorithm.resolve_implicit_levels(storage, False)
    found, levels = iter(storage["chars"]), [storage["base_level"]]
    for silent in joiner:
        levels.append(levels[-1] if silent else next(found)["level"])
    return levels[1:]


def begins_at_the_right(words: str) -> bool:
    """Whether a line is read from right to left, by its first letter that has a direction (UAX 9, P2)."""
    kinds = (unicodedata.bidirectional(letter) for letter in words)
    return next((kind != "L" for kind in kinds if kind in ("L", "R", "AL")), False)


def _resolve_brackets(letters: list[dict[str, Any]], base: str) -> None:
    """Give both brackets of a pair the direction of what is within them.  Source: UAX 9, N0."""
    strong = {"L": "L", "R": "R", "AL": "R", "EN": "R", "AN": "R"}
    for begin, end in _bracket_pairs(letters):
        within = {strong.get(letter["type"]) for letter in letters[begin + 1 : end]} - {None}
        if not within:
            continue
        before = next((strong[one["type"]] for one in reversed(letters[:begin]) if one["type"] in strong), base)
        letters[begin]["type"] = letters[end]["type"] = base if base in within else before


def _bracket_pairs(letters: list[dict[str, Any]]) -> list[tuple[int, int]]:
    """The places of opening and closing brackets that belong together, in the order of the opening ones (BD16)."""
    from bidi.mirror import MIRRORED

    waiting: list[tuple[str, int]] = []
    pairs = []
    for place, letter in enumerate(letters):
        sign, kind = letter["ch"], unicodedata.category(letter["ch"])
        if letter["type"] != "ON" or sign not in MIRRORED:
            continue
        if kind == "Ps":
            waiting.append((MIRRORED[sign], place))
        elif kind == "Pe" and any(sign == closing for closing, _ in waiting):
            while waiting:
                closing, begin = waiting.pop()
                if closing == sign:
                    pairs.append((begin, place))
                    break
    return sorted(pairs)
