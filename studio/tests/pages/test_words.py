"""What every page says must be true of every badge.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import re
from importlib import resources

import pytest

from moireid_studio.problems import PLAIN, plain

WEB = resources.files("moireid_studio")
WORDS = {
    f"{folder}/{entry.name}": entry.read_text(encoding="utf-8")
    for folder in ("templates", "static")
    for entry in WEB.joinpath(folder).iterdir()
    # The library of others has no words for visitors.
    if entry.name.endswith((".j2", ".js")) and entry.name != "three.js"
}


@pytest.mark.parametrize("name", WORDS)
def test_no_page_asks_for_corners_that_a_badge_may_not_have(name: str) -> None:
    """Catches: four markers asked of a badge with a frame, or words of the command line on a page."""
    text = WORDS[name]
    assert not re.search(r"four (markers|squares|corners)|(all|its) markers|marker in each corner", text)
    said = re.sub(
        r"<pre.*?</pre>|<style.*?</style>|var\(--\w+\)|{#.*?#}|//.*", "", text, flags=re.S if ".j2" in name else 0
    )
    assert not re.search(r"(?<![\w-])--[a-z]{3,}|print-your-badge", said)


def test_sentences_of_the_library_lose_the_words_of_the_command_line() -> None:
    """Catches: an option's name on a page, a sentence that is cut with it, a sentence without one that is changed."""
    output = {
        "give a board (--size) of 81 mm or more in height": "give a board of 81 mm or more in height",
        "take a thinner sheet, or another mount (--mount)": "take a thinner sheet, or another mount",
        "add it, or take the badge in portrait (--orientation portrait)": "add it, or take the badge in portrait",
        "by places of lines; leave out --code and --axes": "by places of lines; let the fringes sense motion sideways",
        "add --trust 0123": "add --trust 0123",
        "the name is empty; give the name": "the name is empty; give the name",
    }
    assert {sentence: plain(sentence) for sentence in output} == output
    assert all("--" not in words for _, words in PLAIN)
