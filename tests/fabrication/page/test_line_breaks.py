"""Where words break into rows."""

from __future__ import annotations

import re

import pytest

from moireid.artwork.placing import ArtPiece
from moireid.errors import SpecError
from moireid.fabrication.page.line_breaks import rows_of
from moireid.fabrication.page.page_words import set_words


def rows(words: str, count: int) -> tuple[str, ...] | None:
    found = rows_of(words, count, "sans", True)
    return None if found is None else found[0]


@pytest.mark.parametrize(
    ("words", "count", "expected"),
    [
        ("Ada Lovelace", 2, ("Ada", "Lovelace")),
        ("Jean-Luc Picard", 2, ("Jean-Luc", "Picard")),
        ("Jean-Luc", 2, ("Jean-", "Luc")),
        ("Maria von Hohenstein-Wittgenstein", 3, ("Maria von", "Hohenstein-", "Wittgenstein")),
        ("山田太郎", 2, ("山田", "太郎")),
        ("Ada", 2, None),
        ("محمد", 2, None),
    ],
)
def test_words_break_at_spaces_hyphens_and_between_ideographs(
    words: str, count: int, expected: tuple[str, ...] | None
) -> None:
    """Catches: a hyphen that is lost or begins a row; a word that is cut; a name without spaces that never breaks."""
    assert rows(words, count) == expected


def test_a_name_that_is_too_long_is_refused_with_how_many_letters_have_room() -> None:
    """Catches: letters of four points without a word; a number of letters that does not fit either, or far too few."""
    room = (0.0, 0.0, 30.0, 8.0)
    name = "Maximiliana Theodora Prinzessin von und zu Hohenstaufen Wittelsbach"
    with pytest.raises(SpecError, match=r"smaller than 7 points.*from 0.4 m; shorten it to at most \d+ letters") as no:
        set_words(ArtPiece("words", room, name=name), None)
    most = int(re.findall(r"at most (\d+) letters", str(no.value))[0])
    assert 20 <= most < len(name)
    assert min(row.points for row in set_words(ArtPiece("words", room, name=name[:most].strip()), None)) >= 7.0
    with pytest.raises(SpecError, match="at most"):
        set_words(ArtPiece("words", room, name=name[: most + 12]), None)
