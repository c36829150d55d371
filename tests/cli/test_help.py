"""What a newcomer reads first: the help of every command, whole and no wider than a terminal."""

from __future__ import annotations

from collections.abc import Iterator

import click
import pytest
from click.testing import CliRunner

from moireid.cli.main import SECTIONS, moireid
from moireid.cli.simulate_cmd import EFFECTS, FORGERIES, LIGHT_NAMES, simulate_command


def commands(group: click.Group = moireid, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The words of every command, groups too."""
    for name, command in group.commands.items():
        yield (*path, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))


@pytest.mark.parametrize("words", [(), *commands()], ids=" ".join)
def test_help_fits_a_terminal_and_no_summary_is_cut(words: tuple[str, ...]) -> None:
    """Catches: a first sentence that the list of commands ends with an ellipsis; a table wider than 80 columns."""
    done = CliRunner().invoke(moireid, [*words, "--help"], terminal_width=80)
    assert done.exit_code == 0 and "..." not in done.output.replace("[ARGS]...", "").replace("X,Y,...", "")
    assert max(map(len, done.output.splitlines())) <= 80


def test_every_command_stands_in_one_section() -> None:
    """Catches: a command that is registered and left out of the help, or listed twice."""
    listed = [command.name for commands in SECTIONS.values() for command in commands]
    assert sorted(map(str, listed)) == sorted(moireid.commands)


def test_the_kinds_of_forgeries_effects_and_lights_are_explained() -> None:
    """Catches: a kind that was added to the option and not to the table above the options."""
    words = (simulate_command.help or "").replace(",", " ").split()
    assert set(FORGERIES) | set(LIGHT_NAMES) | set(EFFECTS) <= set(words)
