"""moireid materials: what it prints, which badges it takes, and what it refuses."""

from __future__ import annotations

import json
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
    """Catches: an option that is not passed on; JSON that says other than the table; a price that is lost."""
    options = ["--format", "a6", "--people", "40", "--sheet-size", "210x297", "--price", "lens-sheet=4.5"]
    plain = run(*options, "--out", str(tmp_path / "shop"))
    assert plain.exit_code == 0, plain.output
    made = {path.name for path in (tmp_path / "shop").iterdir()}
    assert made == {"shopping-list.pdf", "shopping-list.csv", "cutting-plan.pdf", "cutting-plan.dxf"}
    document = json.loads(run(*options, "--json").stdout)
    assert document["people"] == 40 and document["cutting"]["sheets"] == 11 and document["files"] == {}
    amounts = {line["key"]: line["quantity"] for line in document["lines"]}
    assert amounts["lens-sheet"] == 11 and amounts["holder"] == 42 and document["total"] == 49.5
    assert f"{'11 sheets':>11}" in plain.stdout and "62 LPI" in plain.stdout
    assert "are assumed" not in plain.stderr and "are assumed" in run("--format", "a6").stderr


def test_the_other_direction_is_named_where_it_takes_fewer_sheets() -> None:
    """Catches: advice that is given where it costs sheets, or not where it saves some."""
    fewer = run("--format", "a6", "--people", "40", "--sheet-size", "297x210")
    assert fewer.exit_code == 0 and "give --sheet-size 210x297" in fewer.stderr
    assert "other side would be" not in run("--format", "a6", "--people", "40", "--sheet-size", "210x297").stderr


def test_an_event_is_counted_from_its_list_or_its_folder(tmp_path: Path) -> None:
    """Catches: a list whose heading counts as a person; a folder's badges designed anew, or of another size."""
    people = tmp_path / "list.csv"
    people.write_text("name\nAda Lovelace\nAlan Turing\nGrace Hopper\n", encoding="utf-8")
    listed = run("--event", str(people), "--format", "cr80", "--json")
    assert listed.exit_code == 0 and json.loads(listed.stdout)["people"] == 3, listed.output
    printed = ["print", "--people", str(people), "--out", str(tmp_path / "event"), "--format", "cr80"]
    made = CliRunner().invoke(moireid, printed)
    assert made.exit_code == 0 and f"moireid materials --event {tmp_path / 'event'}" in made.stdout, made.output
    assert "75 LPI" in made.stdout
    found = json.loads(run("--event", str(tmp_path / "event"), "--json").stdout)
    assert (found["people"], found["format"]) == (3, "cr80")
    assert found["lines"] == json.loads(listed.stdout)["lines"]
    one = run("--badge", str(tmp_path / "event" / "001-ada-lovelace" / "badge.json"), "--json")
    assert json.loads(one.stdout)["people"] == 1 and json.loads(one.stdout)["format"] == "cr80"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--people", "3"], "give --format, --badge or --event"),
        (["--format", "a6", "--people", "0"], "0 people are not possible"),
        (["--format", "a6", "--sheet-size", "big"], "is not understood"),
        (["--format", "a6", "--sheet-size", "10x10"], "is not sold"),
        (["--format", "a6", "--sheet-size", "100x100"], "does not fit a sheet"),
        (["--format", "a6", "--price", "lens-sheet"], "give KEY=AMOUNT"),
        (["--format", "a6", "--price", "gold=1"], "not on this list"),
        (["--format", "a6", "--event", "nowhere", "--people", "3"], "leave --people out"),
        (["--event", "."], "is no folder of an event"),
        (["--event", "nowhere.csv"], "give --format with a list"),
        (["--badge", "a.json", "--event", "b"], "give one of"),
        (["--badge", "a.json", "--format", "a6"], "give one of"),
        (["--badge", "nowhere.json"], "nowhere.json"),
    ],
)
def test_odd_input_is_refused_in_one_sentence(options: list[str], words: str, tmp_path: Path) -> None:
    """Catches: a traceback, an empty list, or a plan for what was not asked."""
    done = run(*options, "--out", str(tmp_path / "out"))
    assert done.exit_code == 2 and words in done.stderr, done.output
    assert len(done.stderr.strip().split("\n")) == 1 and not (tmp_path / "out").exists()
