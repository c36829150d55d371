"""Which files of a mount lie in a folder afterwards: in part, replaced, for an event, and after a failure."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

import pypdfium2 as pdfium
import pytest
from click.testing import CliRunner, Result

from moireid.cli.main import moireid
from moireid.fabrication import package

SHEETS = {"badge.json", "badge.pdf", "preview.png", "fringes.webp", "assembly.pdf"}


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(moireid, ["print", *map(str, arguments)])


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def words_of(pdf: Path) -> str:
    document = pdfium.PdfDocument(pdf)
    text = "\n".join(page.get_textpage().get_text_range() for page in document)
    document.close()
    return text


@pytest.mark.slow
def test_what_cannot_be_made_is_left_out_and_reported(tmp_path: Path) -> None:
    """Catches: a good printed mount refused for the acrylic's sake, a part that is missing without a word, an assembly
    sheet of parts that do not exist."""
    out = tmp_path / "out"
    outcome = run("Ada", "--out", out, "--front", "mask", "--lens-thickness", "6", "--json")
    assert outcome.exit_code == 0, outcome.output
    assert names(out) == SHEETS | {"mount.step", "mount.stl", "mount.3mf", "mount.glb"}
    notes = [line for line in outcome.stderr.splitlines() if line.startswith("note:")]
    assert (
        len(notes) == 1
        and "no acrylic stack was made" in notes[0]
        and "give a spacer (--lens-thickness) of 4.9 mm or less" in notes[0]
    )
    document = json.loads(outcome.stdout)
    assert list(document["left_out"]) == ["acrylic"] and document["left_out"]["acrylic"] in notes[0]
    assert set(document["files"]) == names(out)
    words = words_of(out / "assembly.pdf")
    assert "mount.3mf" in words and "acrylic.dxf" not in words and "M3" not in words
    # The same spacer with a kerf: somebody wants the stack, and it cannot be.
    refused = run(
        "Ada", "--out", tmp_path / "new", "--front", "mask", "--lens-thickness", "6", "--mount-figure", "kerf_mm=0.2"
    )
    assert refused.exit_code == 2 and "give a spacer (--lens-thickness) of 4.9 mm or less" in refused.stderr
    assert not (tmp_path / "new").exists()


def test_files_of_the_badge_before_do_not_stay(tmp_path: Path) -> None:
    """Catches: an old mount next to a new badge that it does not fit, and a stranger's file taken for an old one."""
    removed = {"mount.step", "mount.stl", "mount-clip.stl", "mount.3mf", "acrylic.step", "acrylic.svg", "mount.glb"}
    removed |= {"acrylic-2mm.dxf", "acrylic-film-0.25mm.svg"}
    for name in (*removed, "badge.json", "holiday.jpg", "mount.obj"):
        (tmp_path / name).write_text("older")
    outcome = run("Ada", "--out", tmp_path, "--mount", "none", "--overwrite", "--json")
    assert outcome.exit_code == 0, outcome.output
    assert names(tmp_path) == SHEETS | {"holiday.jpg", "mount.obj"}
    assert {Path(path).name for path in json.loads(outcome.stdout)["removed"]} == removed
    assert all(f"{name} was removed" in outcome.stderr for name in removed)


def test_the_same_badge_is_printed_again_and_another_one_never_destroys_it(tmp_path: Path) -> None:
    """Catches: a page corrected in size of a new identity; the only copy of a badge replaced by that of another."""
    ada, again = tmp_path / "ada", tmp_path / "again"
    assert run("Ada", "--format", "a7", "--line", "Keynote", "--out", ada, "--mount", "none").exit_code == 0
    first, page = (ada / "badge.json").read_bytes(), (ada / "badge.pdf").read_bytes()
    scaled = run("--again", ada / "badge.json", "--measured-scale", "0.99", "--out", again, "--mount", "none")
    assert scaled.exit_code == 0 and "template and pictures are not in badge.json" in scaled.stderr
    assert (again / "badge.json").read_bytes() == first and (again / "badge.pdf").read_bytes() != page
    refused = run("--again", ada / "badge.json", "--paper", "letter", "--line", "New", "--out", tmp_path / "new")
    assert refused.exit_code == 2 and "leave --line and --paper out" in refused.stderr
    old_id = json.loads(first)["id"]
    # Into its own folder it is no other badge; a new one moves it aside.
    for who, kept in ((["--again", ada / "badge.json"], set()), (["Ada"], {f"badge-{old_id}.json"})):
        done = run(*who, "--out", ada, "--mount", "none", "--overwrite", "--json")
        assert done.exit_code == 0 and names(ada) == SHEETS | kept, done.stderr
    assert json.loads(done.stdout)["moved_aside"] == {str(ada / "badge.json"): str(ada / f"badge-{old_id}.json")}
    assert (ada / f"badge-{old_id}.json").read_bytes() == first and "was of another badge" in done.stderr


@pytest.mark.claim("Files are whole or absent: a failure changes nothing")
def test_a_failure_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: old files removed before the new ones are in place; an empty folder that is left; half of the files."""
    for name in ("mount.stl", "badge.json", "badge.pdf"):
        (tmp_path / name).write_text("older")

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path / "preview.png"))

    with monkeypatch.context() as broken:
        broken.setattr(package, "write_preview", full)
        late = run("Ada", "--out", tmp_path, "--mount", "none", "--overwrite")
        fresh = run("Ada", "--out", tmp_path / "a" / "b", "--mount", "none")
    for outcome in (late, fresh):
        assert outcome.exit_code == 2 and outcome.stderr.count("error:") == 1
        assert "No space left on device" in outcome.stderr and "free space" in outcome.stderr
    assert names(tmp_path) == {"mount.stl", "badge.json", "badge.pdf"}
    # The last step of moving fails, when all other files have their names.
    replace = Path.replace

    def stuck(self: Path, target: Path) -> Path:
        if Path(target) == tmp_path / "badge.json" and self.parent.name.startswith(".moireid-"):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(target))
        return replace(self, target)

    with monkeypatch.context() as broken:
        broken.setattr(Path, "replace", stuck)
        outcome = run("Ada", "--out", tmp_path, "--mount", "none", "--overwrite")
    assert outcome.exit_code == 2 and "Read-only file system" in outcome.stderr
    assert names(tmp_path) == {"mount.stl", "badge.json", "badge.pdf"}
    assert {(tmp_path / name).read_text() for name in names(tmp_path)} == {"older"}
