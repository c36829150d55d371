"""The notes to a person who prints a badge.  Each test states what it would catch."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from PIL import Image

from moireid.cli.main import moireid


@pytest.fixture
def registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    return f"sqlite:///{tmp_path / 'people.sqlite3'}"


def printed(*words: str, out: Path) -> Result:
    outcome = CliRunner().invoke(moireid, ["print", *words, "--out", str(out), "--mount", "none", "--json"])
    assert outcome.exit_code == 0, outcome.stderr
    return outcome


def notes(outcome: Result) -> list[str]:
    """The notes of the JSON, which are those on stderr."""
    found = json.loads(outcome.stdout)["notes"]
    assert all(f"note: {note}" in outcome.stderr for note in found)
    return found


@pytest.mark.slow
def test_a_portrait_that_the_template_does_not_show_is_told(tmp_path: Path) -> None:
    """Catches: a picture that is lost without a word, for one person or for a list."""
    Image.new("RGB", (80, 100), "gray").save(tmp_path / "face.png")
    wear = ["--format", "a6", "--template", "webcam", "--portrait", str(tmp_path / "face.png")]
    assert any("webcam shows no portrait" in note for note in notes(printed("Ada", *wear, out=tmp_path / "a")))
    (tmp_path / "people.csv").write_text("name\nAda\nBo\n", encoding="utf-8")
    many = notes(printed("--people", str(tmp_path / "people.csv"), *wear, out=tmp_path / "b"))
    assert sum("webcam shows no portrait" in note for note in many) == 2 and many[0].startswith("row 2: ")


def test_no_file_that_was_read_is_replaced_and_no_registry_made_in_vain(registry: str, tmp_path: Path) -> None:
    """Catches: a logo that the preview is written over; a registry made for a list whose files are in the way."""
    out = tmp_path / "out"
    out.mkdir()
    Image.new("RGB", (300, 100), "teal").save(out / "preview.png")
    logo = (out / "preview.png").read_bytes()
    words = ["Ada", "--format", "a7", "--logo", str(out / "preview.png"), "--out", str(out), "--overwrite"]
    outcome = CliRunner().invoke(moireid, ["print", *words, "--mount", "none"])
    assert outcome.exit_code == 2 and "is a file that is read here" in outcome.stderr
    assert (out / "preview.png").read_bytes() == logo and sorted(out.iterdir()) == [out / "preview.png"]
    (tmp_path / "people.csv").write_text("name\nAda\n", encoding="utf-8")
    command = ["--people", str(tmp_path / "people.csv"), "--out", str(tmp_path / "event")]
    assert CliRunner().invoke(moireid, ["print", *command]).exit_code == 0
    again = CliRunner().invoke(moireid, ["print", *command, "--registry", registry])
    assert again.exit_code == 2 and "exists already" in again.stderr and not (tmp_path / "people.sqlite3").exists()


def test_the_range_suits_the_identity_that_was_given(tmp_path: Path) -> None:
    """Catches: a range that the program chose for 64 bits, and then refuses for 128."""
    words = ["Ada", "--axes", "xy", "--template", "court", "--payload", "00" * 15 + "01"]
    printed(*words, out=tmp_path / "a")
    assert json.loads((tmp_path / "a" / "badge.json").read_text(encoding="utf-8"))["payload_bits"] == 128


@pytest.mark.parametrize("kept", [False, True])
def test_the_identity_that_was_checked_is_the_one_that_is_printed(
    kept: bool, registry: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a badge that is checked, and another one of a new identity that is printed."""
    drawn: list[bytes] = []

    def draw(size: int) -> bytes:
        drawn.append(bytes([len(drawn) + 1]) * size)
        return drawn[-1]

    monkeypatch.setattr("moireid.issuing.random_payload", draw)
    outcome = printed("Ada", "--format", "a6", *(["--registry", registry] if kept else []), out=tmp_path / "a")
    assert [one.hex() for one in drawn] == [json.loads(outcome.stdout)["id"]]
