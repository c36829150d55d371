"""Letters that no one sees.  Each test names the wrong implementation it would catch."""

from __future__ import annotations

import unicodedata

import pytest

from moireid.designer.order import clean_name
from moireid.errors import SpecError
from moireid.names import encoded_twice, hidden_letters, hidden_words, line_fault, line_of


@pytest.mark.parametrize(
    "letter",
    "\u200b\u200c\u200d\u200e\u200f\u202e\u2066\u2069\u00ad\u034f\u061c\u3164\uffa0\u115f\ufe0f\ufeff\u2060\U000e0041\u180b",
)
def test_a_letter_that_nobody_sees_is_named(letter: str) -> None:
    """Catches: a kind of them forgotten; one let through at the end or the beginning."""
    for name in (f"Ada{letter} Lovelace", f"Ada{letter}", f"{letter}Ada"):
        assert hidden_letters(name) == [unicodedata.name(letter, f"U+{ord(letter):04X}")]
    assert hidden_words(f"A{letter}{letter}da") is not None


@pytest.mark.parametrize(
    "name",
    [
        "Ada Lovelace",
        "Zo\u00eb",
        # Ali-Reza in Persian: the non-joiner keeps the last letter of Ali apart.
        "\u0639\u0644\u06cc\u200c\u0631\u0636\u0627",
        # Sri in Sinhala: a joiner after the sign that takes the vowel away.
        "\u0dc1\u0dca\u200d\u0dbb\u0dd3",
        "Ada \u2764\ufe0f",
        "Ada \U0001f468\u200d\U0001f469\u200d\U0001f467",
        "Ada \U0001f3f3\ufe0f\u200d\U0001f308",
        "\u1820\u180b",
        # Bengali ra, joined to a ya below it.
        "\u09b0\u200d\u09cd\u09af\u09be\u09ac",
        "\u05d3\u05d1",
    ],
)
def test_what_a_name_is_spelled_with_stays(name: str) -> None:
    """Catches: people of Persian, Sinhala or Mongolian names who are asked to spell them wrong."""
    assert hidden_letters(name) == [] and hidden_words(name) is None


@pytest.mark.parametrize("line", ["Rep\u200borter", "\u202eretropeR", "\x1b[31mOwner", "x" * 201, "\u200d", 7, None])
def test_lines_are_as_plain_as_names(line: object) -> None:
    """Catches: a line of somebody's file that passes for another, moves the cursor of a terminal, or fills a screen."""
    assert line_fault(line) is not None and line_of({"lines": [line, "Reporter"]}) is None
    assert line_fault("Reporter, Neues Öffentliches") is None and line_of({"lines": ["Reporter "]}) == "Reporter"


def test_letters_that_were_encoded_twice_are_recognised() -> None:
    """Catches: a name printed as a broken program stored it; a right name of the same signs refused."""
    assert encoded_twice("Jos\u00c3\u00a9") == "José" and encoded_twice("Zoë".encode().decode("latin-1")) == "Zoë"
    for name in ("José", "Ã", "Ana Sá", "Łukasz", "Nguyễn Ái", "山田", "Ada"):
        assert encoded_twice(name) is None, name
    with pytest.raises(SpecError, match="encoded twice, and is probably 'José'"):
        clean_name("Jos\u00c3\u00a9")
    assert line_fault("Jos\u00c3\u00a9") is not None
