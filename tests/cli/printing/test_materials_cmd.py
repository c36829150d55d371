"""moireid materials: what it prints, which badges it takes, and what it refuses."""

from __future__ import annotations

import json
from codecs import BOM_UTF8
from pathlib import Path

from click.testing import CliRunner, Result

from moireid.cli.main import moireid
from moireid.materials import materials


def run(*more: str) -> Result:
    return CliRunner().invoke(moireid, ["materials", *more])


def test_a_format_and_a_number_give_list_and_files(tmp_path: Path) -> None:
    """Catches: an option that is not passed on; JSON that says other than the table; advice where it saves nothing."""
    options = ["--format", "a6", "--people", "40", "--sheet-size", "210x297"]
    plain = run(*options, "--out", str(tmp_path / "shop"))
    assert plain.exit_code == 0, plain.output
    made = {path.name for path in (tmp_path / "shop").iterdir()}
    assert made == {"shopping-list.csv", "cutting-plan.pdf"}
    # By the byte order mark, spreadsheets know UTF-8.
    assert (tmp_path / "shop" / "shopping-list.csv").read_bytes().startswith(BOM_UTF8)
    document = json.loads(run(*options, "--json").stdout)
    assert document["people"] == 40 and document["cutting"]["sheets"] == 11 and document["files"] == {}
    amounts = {line["key"]: line["quantity"] for line in document["lines"]}
    assert amounts["lens-sheet"] == 11 and amounts["holder"] == 42
    assert "  11 sheets  " in plain.stdout and "62 LPI" in plain.stdout and plain.stderr == ""
    assert "are assumed" in run("--format", "a6").stderr


def test_readme_has_the_distances_that_the_command_prints() -> None:
    """Catches: a table that was edited by hand, or that formats left behind; a list without distances."""
    readme = (Path(__file__).parents[3] / "README.md").read_text(encoding="utf-8")
    for row in json.loads(run("--json").stdout)["formats"]:
        name, _, _, *distances = row.values()
        assert f"| `{name}` | {' | '.join(distances)} |" in readme
        if name in ("a6", "board"):
            words = " ".join(run("--format", name).stdout.split())
            assert f"{distances[0]} (27 mm), {distances[1]} (50 mm)" in words
            assert ("move it more" in words) == (name == "board")


def test_without_badges_it_prints_the_table() -> None:
    """Catches: a product that the table on the terminal leaves out, or one without its source."""
    plain, listed = run(), run("--json")
    assert plain.exit_code == listed.exit_code == 0
    words = " ".join(plain.stdout.split())
    for row in materials():
        assert row.source in words and (row.label or row.article or "") in words, row
    assert len(json.loads(listed.stdout)["materials"]) == len(materials())
