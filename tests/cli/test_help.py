"""What a newcomer reads first: the help of every command, whole and no wider than a terminal."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from moireid.cli.main import ELSEWHERE, OF_LAB, moireid
from moireid.cli.removed import REMOVED
from moireid.simulate.cameras import CAMERAS
from moireid.simulate.effects.table import KINDS
from moireid.simulate.flaw_table import BUILDS, FLAWS
from moireid.simulate.forgeries.trajectories import KINDS as FORGERIES
from moireid.simulate.light import LIGHTS
from moireid.simulate.motion import NAMED
from moireid.simulate.recording.encode import RECIPES
from moireid.simulate.settings.places import SETTINGS

SOURCE = Path(__file__).parents[2] / "src" / "moireid"


def commands(group: click.Group = moireid, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The words of every command, groups too."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        yield (*path, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))


@pytest.mark.parametrize("words", [(), *commands()], ids=" ".join)
def test_help_fits_a_terminal_and_no_summary_is_cut(words: tuple[str, ...]) -> None:
    """Catches: a first sentence that the list of commands ends with an ellipsis; a table that is too wide; no -h."""
    done = CliRunner().invoke(moireid, [*words, "--help"], terminal_width=80)
    assert done.exit_code == 0 and "..." not in done.output.replace("[ARGS]...", "").replace("X,Y,...", "")
    assert max(map(len, done.output.splitlines())) <= 80
    assert CliRunner().invoke(moireid, [*words, "-h"], terminal_width=80).output == done.output


@pytest.mark.parametrize("name", OF_LAB)
def test_commands_of_the_lab_are_also_called_without_its_name(name: str) -> None:
    """Catches: `moireid bench` that is gone, or listed next to `moireid lab bench`."""
    short, whole = (CliRunner().invoke(moireid, [*words, name, "--help"]).stdout for words in ((), ("lab",)))
    assert short.partition("\n\n")[2] == whole.partition("\n\n")[2] != ""
    assert name not in moireid.list_commands(click.Context(moireid))


@pytest.mark.parametrize(("command", "distribution"), ELSEWHERE.items())
def test_a_command_that_is_not_installed_names_what_to_install(
    command: str, distribution: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: 'no such command' for one that the guides describe."""
    monkeypatch.setattr("moireid.cli.main.find_spec", lambda _: None)
    done = CliRunner().invoke(moireid, [command, "--help"])
    assert done.exit_code != 0 and f"needs {distribution}, which is not installed; install it with: " in done.stderr
    helped = CliRunner().invoke(moireid, ["--help"]).stdout
    assert command in helped.partition(f"In {distribution}, which is not installed")[2]


@pytest.mark.parametrize(
    ("typed", "meant"), [("verfy", "verify"), ("registy list", "registry"), ("registry lst", "list"), ("bnch", "bench")]
)
def test_a_mistyped_command_gets_the_nearest_one(typed: str, meant: str) -> None:
    """Catches: 'no such command' of a group whose commands are loaded one by one, without the one that was meant."""
    done = CliRunner().invoke(moireid, typed.split())
    assert done.exit_code == 2 and re.search(rf"[Dd]id you mean '?{meant}", done.stderr), done.stderr


#: Outside the commands: what prints whole commands to follow, the installer's own command, and a style sheet.
NAME_OPTIONS = {
    "bring_up.py", "assembly_words.py", "camera_page.py", "chart_page.py", "extras.py", "plots.py"
}  # fmt: skip


def test_only_commands_name_options() -> None:
    """Catches: a library error that says "add --overwrite" to someone who calls it from Python.

    `in_options` puts a command's options in the place of `overwrite=True`, `trust=...` or `(size_mm)`.
    """
    found = set()
    for path in (one for one in SOURCE.rglob("*.py") if SOURCE / "cli" not in one.parents):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        texts = (node for node in nodes if isinstance(node, ast.Constant) and id(node) not in docstrings)
        found |= {path.name for node in texts if re.search(r"(?<![\w-])--[a-z]", str(node.value))}
    assert found == NAME_OPTIONS


@pytest.mark.claim("What was removed says what to use instead")
@pytest.mark.parametrize(("words", "instead"), REMOVED.items())
def test_what_was_removed_says_what_to_use_instead(words: str, instead: str) -> None:
    """Catches: 'no such command' or 'no such option' for what once was; an entry for what still works."""
    done = CliRunner().invoke(moireid, [*words.split(), "value"])
    assert done.exit_code == 2 and done.stderr == f"Error: 'moireid {words}' was removed: {instead}\n"
    assert words not in [" ".join(path) for path in commands()]


def test_all_names_that_simulate_takes_are_in_its_help() -> None:
    """Catches: a kind that was added to the simulator and not to the help, where they are written again."""
    said = CliRunner().invoke(moireid, ["simulate", "--help"]).stdout
    words = set(re.findall(r"[a-z0-9_-]+", said))
    names = {*FLAWS, *BUILDS, *FORGERIES, *LIGHTS, *KINDS, *CAMERAS, *NAMED, *RECIPES, *SETTINGS}
    assert names <= words, names - words
