"""A list of people by command: what is wrong with it is all said before anything is made."""

from __future__ import annotations

import json
from pathlib import Path

from click.testing import CliRunner, Result

from moireid.cli.main import moireid

FAULTY = "name,portrait,payload\nAda,,\nBo,nothere.png,\n,b.png,\nCy,,zz\nDi,,,more\nEve,,\n"


def printed(folder: Path, text: str, *more: str) -> Result:
    """The outcome of a list, whose badges go into the folder `out`."""
    (folder / "people.csv").write_text(text, encoding="utf-8")
    small = ["--people", str(folder / "people.csv"), "--format", "a7", "--template", "conference"]
    return CliRunner().invoke(moireid, ["print", *small, "--out", str(folder / "out"), *more])


def test_all_rows_are_checked_and_all_faults_listed_before_any_is_made(tmp_path: Path) -> None:
    """Catches: one fault at each call, so that a list of a hundred needs ten calls; badges of the rows before it; a
    registry that is made for a list of which nothing is printed."""
    done = printed(tmp_path, FAULTY, "--registry", str(tmp_path / "people.sqlite3"))
    assert done.exit_code == 2 and {path.name for path in tmp_path.iterdir()} == {"people.csv"}
    faults = [line for line in done.stderr.splitlines() if line.startswith("fault: ")]
    assert [fault.split()[2] for fault in faults] == ["3", "4", "5", "6"]
    assert "nothere.png" in faults[0] and "name is empty" in faults[1] and "'zz'" in faults[2] and "cells" in faults[3]
    assert "4 rows of people.csv cannot be printed, and nothing was made" in done.stderr


def test_identities_that_someone_has_are_named_by_row_before_anything_is_made(tmp_path: Path) -> None:
    """Catches: a whole event that fails at its end as one badge is enrolled already; a revoked identity that is printed
    again; the very same badge refused, so that a lost page cannot be printed."""
    url, ids = str(tmp_path / "people.sqlite3"), ["00112233445566aa", "00112233445566bb", "00112233445566cc"]
    rows = [f"{name},{payload}" for name, payload in zip(["Ada", "Bo", "Cy"], ids, strict=True)]
    first = printed(tmp_path, "\n".join(["name,payload", *rows]), "--registry", url)
    assert first.exit_code == 0, first.stderr
    revoked = ["registry", "revoke", ids[1], "--reason", "lost", "--registry", url]
    assert CliRunner().invoke(moireid, revoked).exit_code == 0
    text = f"name,payload\nAda,{ids[0]}\nBo,{ids[1]}\nEve,{ids[2]}\nDi,\n"
    folder = tmp_path / "again"
    folder.mkdir()
    done = printed(folder, text, "--registry", url)
    assert done.exit_code == 2 and {path.name for path in folder.iterdir()} == {"people.csv"}
    faults = [line for line in done.stderr.splitlines() if line.startswith("fault: ")]
    assert len(faults) == 2 and "row 3" in faults[0] and "was revoked (lost)" in faults[0]
    assert "row 4" in faults[1] and "is held by 'Cy' already" in faults[1] and "making badges" not in done.stderr
    rest = printed(folder, f"name,payload\nAda,{ids[0]}\nDi,\n", "--registry", url, "--json")
    assert rest.exit_code == 0, rest.stderr
    assert [one["name"] for one in json.loads(rest.stdout)["people"]] == ["Ada", "Di"]


def test_unknown_columns_are_named_with_the_nearest_known_one(tmp_path: Path) -> None:
    """Catches: a misspelt column whose cells are on no badge, without a word."""
    done = printed(tmp_path, "name,titel,lien,Colour,portait\nAda,Dr,Speaker,teal,\n", "--json")
    (note,) = json.loads(done.stdout)["notes"]
    assert "columns 'titel', 'lien' (did you mean line?), 'portait' (did you mean portrait?); " in note
    assert "colour'" not in note and note in done.stderr


def test_each_badge_of_a_list_has_a_moving_preview(tmp_path: Path) -> None:
    """Catches: a folder of an event without what a single print gets, but for how to build it, one for all."""
    done = printed(tmp_path, "name\nAda\nEve\n", "--json")
    document = json.loads(done.stdout)
    assert done.exit_code == 0 and document["notes"] == []
    alone = CliRunner().invoke(moireid, ["print", "Ada", "--out", str(tmp_path / "a"), "--mount", "none"])
    assert alone.exit_code == 0
    names = {path.name for path in (tmp_path / "a").iterdir()} - {"assembly.pdf", "fringes.webp"}
    assert all({path.name for path in Path(one["folder"]).iterdir()} == names for one in document["people"])


def test_a_list_is_printed_again_by_the_identities_of_its_summary(tmp_path: Path) -> None:
    """Catches: an event whose pages are corrected in size and whose badges are all others then; identities of badges
    that were built, lost as a list is printed anew into their folder."""
    assert printed(tmp_path, "name\nAda\nBo\n").exit_code == 0
    out = tmp_path / "out"
    first = [(out / name / "badge.json").read_bytes() for name in ("001-ada", "002-bo")]
    summary = (out / "summary.csv").read_text(encoding="utf-8-sig")
    anew = printed(tmp_path, "name\nAda\nBo\n", "--overwrite")
    assert anew.exit_code == 0 and anew.stderr.count("was of another badge") == 2
    assert [next((out / name).glob("badge-*.json")).read_bytes() for name in ("001-ada", "002-bo")] == first
    again = printed(tmp_path, summary, "--overwrite", "--measured-scale", "0.99")
    assert again.exit_code == 0, again.stderr
    assert [(out / name / "badge.json").read_bytes() for name in ("001-ada", "002-bo")] == first
