"""Files whole or not at all, and outputs that are looked at before any work starts."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from moireid.errors import SpecError
from moireid.files import planned, whole_file, write_text


def tree(folder: Path) -> dict[str, bytes]:
    """Every file under a folder, hidden ones too, with its content."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_file_appears_only_when_it_is_whole(tmp_path: Path) -> None:
    """Catches: writing in place, where a reader meets half a file."""
    path = tmp_path / "badge.pdf"
    with whole_file(path) as temporary:
        assert (temporary.parent, temporary.suffix) == (tmp_path, ".pdf")
        assert temporary.name.startswith(".")
        temporary.write_bytes(b"half")
        assert not path.exists()
        temporary.write_bytes(b"half and half")
    assert tree(tmp_path) == {"badge.pdf": b"half and half"}


def test_no_output_replaces_what_is_read(tmp_path: Path) -> None:
    """Catches: names that are compared, where a link or another way of writing the path leads to the same file."""
    read = tmp_path / "people.bundle"
    read.write_text("read")
    (tmp_path / "soft").symlink_to(read)
    (tmp_path / "hard").hardlink_to(read)
    (tmp_path / "inner").mkdir()
    for name in ("people.bundle", "soft", "hard", "inner/../people.bundle"):
        with pytest.raises(SpecError, match="is a file that is read here"):
            planned([tmp_path / "new", tmp_path / name], overwrite=True, kept=[None, tmp_path / "none", read])
    planned([tmp_path / "new"], overwrite=False, kept=[read, tmp_path / "new"])


def test_the_bytes_reach_the_disk_before_the_name_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a name that a power cut leaves without its bytes."""
    path, synced = tmp_path / "a.txt", list[tuple[int, bool]]()
    monkeypatch.setattr(os, "fsync", lambda handle: synced.append((os.fstat(handle).st_size, path.exists())))
    write_text(path, "whole")
    assert synced == [(5, False)]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_what_breaks_off_leaves_nothing_behind(tmp_path: Path, error: type[BaseException]) -> None:
    """Catches: `except Exception`, which an interrupt passes by, and temporary files that nobody removes."""
    path = tmp_path / "a.json"
    path.write_text("old")
    with pytest.raises(error), whole_file(path) as temporary:
        temporary.write_text("ne")
        raise error
    assert tree(tmp_path) == {"a.json": b"old"}


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_rights_are_those_of_any_new_file(tmp_path: Path, mask: int) -> None:
    """Catches: the 0600 of a temporary file, which a print server could not read; a umask that is left changed."""
    before = os.umask(mask)
    try:
        write_text(tmp_path / "a.txt", "x")
        assert os.umask(mask) == mask
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o666 & ~mask


def test_plans_are_checked_one_and_all_before_anything_is_written(tmp_path: Path) -> None:
    """Catches: a check of the first output only."""
    (tmp_path / "b").write_text("mine")
    with pytest.raises(SpecError, match=r"b exists already; add overwrite=True"):
        planned([tmp_path / "a", tmp_path / "b"], overwrite=False)
    planned([tmp_path / "a", tmp_path / "b"], overwrite=True)
    with pytest.raises(SpecError, match="two outputs"):
        planned([tmp_path / "c", tmp_path / "c"], overwrite=True)
    assert tree(tmp_path) == {"b": b"mine"}


def test_outputs_that_cannot_be_are_refused(tmp_path: Path) -> None:
    """Catches: a folder replaced by a file, a file taken for a folder, an empty path taken for the current folder."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("mine")
    for path, words in (
        (tmp_path / "folder", "is a folder"),
        (tmp_path / "file/x", "cannot be made"),
        (tmp_path / "file/x/y.txt", "cannot be made"),
        (Path(""), "folder"),
    ):
        for overwrite in (False, True):
            with pytest.raises(SpecError, match=words):
                planned([path], overwrite=overwrite)
    assert tree(tmp_path) == {"file": b"mine"}
