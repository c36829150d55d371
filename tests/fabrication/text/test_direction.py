"""The direction of letters, against python-bidi's other version, which takes all rules of Unicode's algorithm."""

from __future__ import annotations

import numpy as np
from bidi import get_display

from moireid.fabrication.text.direction import bidi_levels

#: Latin, Hebrew, Arabic, digits, spaces, brackets and signs.
LETTERS = "aB éאבמח12 (),-.[]/"


def as_seen(words: str) -> str:
    """The letters from left to right, by their levels (UAX 9, L2)."""
    levels, order = bidi_levels(words), list(range(len(words)))
    for level in range(max(levels), 0, -1):
        start = 0
        while start < len(order):
            end = start
            while end < len(order) and levels[order[end]] >= level:
                end += 1
            order[start:end] = order[start:end][::-1]
            start = max(end, start + 1)
    return "".join(words[place] for place in order)


def test_letters_at_random_have_the_order_of_another_implementation() -> None:
    """Catches: any rule that is left out or taken in another order."""
    rng = np.random.default_rng(1)
    for _ in range(3000):
        words = "".join(rng.choice(list(LETTERS), size=rng.integers(1, 15))).strip()
        if words:
            assert as_seen(words) == get_display(words), repr(words)
