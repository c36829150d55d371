"""What strangers' words may do to a terminal: nothing.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json

import click
import pytest
from click.testing import CliRunner

from moireid.cli.common import echo, fail, friendly, say, show_json, shown
from moireid.errors import MediaError

#: Clears the screen, turns the line round, ends the line in two ways, and is a control sequence of one byte.
HOSTILE = "a\x1b[2J\u202eb\nACCEPT\u2028c\x9b1md\U000e0041"


@pytest.mark.claim("Nothing that is printed steers the terminal")
@pytest.mark.parametrize("way", ["echo", "say", "fail", "error", "json"])
def test_nothing_that_is_printed_steers_the_terminal(way: str) -> None:
    """Catches: words of a film's process, in an error or a finding, that clear the screen and write a verdict."""

    @click.command()
    @friendly
    def command() -> None:
        if way == "error":
            raise MediaError(HOSTILE)
        {"echo": echo, "say": say, "fail": fail, "json": lambda text: show_json({"it": text})}[way](HOSTILE)

    done = CliRunner().invoke(command)
    assert not set("\x1b\u202e\u2028\x9b\U000e0041") & set(done.output)
    assert done.output.count("\n") == 1 and "\\u001b" in done.output and "\\u202e" in done.output
    if way == "json":
        assert json.loads(done.output) == {"it": HOSTILE}


def test_honest_names_are_shown_as_they_are_spelled() -> None:
    """Catches: names that are unreadable for the sake of safety."""
    for name in (
        "Zo\u00eb",
        "\u0645\u06cc\u200c\u0634\u0648\u062f",
        "\u5c71\u7530",
        "a\u00a0b",
        "\U0001f469\u200d\U0001f4bb",
    ):
        assert shown(name) == name
