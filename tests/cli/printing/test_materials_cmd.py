"""moireid materials: what it prints, which badges it takes, and what it refuses."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from moireid.cli.main import moireid
from moireid.materials import materials


def run(*more: str) -> Result:
    return CliRunner().invoke(moireid, ["materials", *more])


def test_without_badges_it_prints_the_table() -> None:
    """Catches: a product that the table on the terminal leaves out, or one without its source."""
    plain, listed = run(), run("--json")
    assert plain.exit_code == listed.exit_code == 0
    words = " ".join(plain.stdout.split())
    for row in materials():
        assert row.source in words and (row.label or row.article or "") in words, row
    assert len(json.loads(listed.stdout)["materials"]) == len(materials())


def test_a_format_and_a_number_give_list_and_files(tmp_path: Path) -> None:
    """Catches: an option that is not passed on; JSON that says other than the table; advice where it saves nothing."""
    options = ["--format", "a6", "--people", "40", "--sheet-size", "210x297"]
    plain = run(*options, "--out", str(tmp_path / "shop"))
    assert plain.exit_code == 0, plain.output
    made = {path.name for path in (tmp_path / "shop").iterdir()}
    assert made == {"shopping-list.pdf", "shopping-list.csv", "cutting-plan.pdf"}
    document = json.loads(run(*options, "--json").stdout)
    assert document["people"] == 40 and document["cutting"]["sheets"] == 11 and document["files"] == {}
    amounts = {line["key"]: line["quantity"] for line in document["lines"]}
    assert amounts["lens-sheet"] == 11 and amounts["holder"] == 42
    assert "  11 sheets  " in plain.stdout and "62 LPI" in plain.stdout and plain.stderr == ""
    assert "are assumed" in run("--format", "a6").stderr
    assert "give --sheet-size 210x297" in run(*options[:-1], "297x210").stderr


def test_badges_that_are_made_are_listed_as_their_format_is(tmp_path: Path) -> None:
    """Catches: advice after an event that lists another number, or badges of another size."""
    people = tmp_path / "list.csv"
    people.write_text("name\nAda Lovelace\nAlan Turing\nGrace Hopper\n", encoding="utf-8")
    printed = ["print", "--people", str(people), "--out", str(tmp_path / "event"), "--format", "cr80"]
    made = CliRunner().invoke(moireid, printed)
    advice = made.stdout.splitlines()[-1].removeprefix("What to buy: moireid materials ")
    assert made.exit_code == 0 and "--people 3" in advice and "75 LPI" in made.stdout, made.output
    found = json.loads(run(*shlex.split(advice), "--json").stdout)
    listed = json.loads(run("--format", "cr80", "--people", "3", "--json").stdout)
    assert found["lines"] == listed["lines"] and found["people"] == 3


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--people", "3"], "give --format or --badge"),
        (["--format", "a6", "--people", "0"], "0 people are not possible"),
        (["--format", "a6", "--sheet-size", "big"], "is not understood"),
        (["--format", "a6", "--sheet-size", "100x100"], "does not fit a sheet"),
        (["--badge", "a.json", "--format", "a6"], "give one of"),
        (["--badge", "nowhere.json"], "nowhere.json"),
    ],
)
def test_odd_input_is_refused_in_one_sentence(options: list[str], words: str, tmp_path: Path) -> None:
    """Catches: a traceback, an empty list, or a plan for what was not asked."""
    done = run(*options, "--out", str(tmp_path / "out"))
    assert done.exit_code == 2 and words in done.stderr, done.output
    assert len(done.stderr.strip().split("\n")) == 1 and not (tmp_path / "out").exists()
