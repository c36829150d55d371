"""A registry and its key backed up and restored elsewhere.  Each test says what it catches."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner

from kit.registries import badge_of
from moireid.cli.main import moireid
from moireid.registry import import_registry, open_registry


@pytest.fixture(params=["export", "sqlite"])
def way(request: pytest.FixtureRequest) -> str:
    """A backup by `registry export`, or by SQLite's own online backup."""
    return str(request.param)


def back_up(way: str, url: str, keys: Path, folder: Path) -> None:
    """Content and key in a folder."""
    folder.mkdir()
    shutil.copytree(keys, folder / "keys")
    if way == "export":
        with open_registry(url, create=False) as registry:
            registry.export_json(folder / "people.json")
        return
    source = url.removeprefix("sqlite:///")
    with closing(sqlite3.connect(source)) as live, closing(sqlite3.connect(folder / "people.sqlite3")) as copy:
        live.backup(copy)


def restore(way: str, folder: Path, place: Path) -> tuple[str, Path]:
    """The registry on another machine: its URL, and its keys folder."""
    place.mkdir()
    url = f"sqlite:///{place}/restored.sqlite3"
    shutil.copytree(folder / "keys", place / "keys")
    if way == "export":
        import_registry(folder / "people.json", url)
    else:
        shutil.copy(folder / "people.sqlite3", place / "restored.sqlite3")
    return url, place / "keys"


def test_a_backup_is_restored_elsewhere_and_one_that_is_too_old_is_noticed(
    way: str, path: Path, keys: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a backup without what writing needs; a restored registry that is not sound; a lost revocation that
    no one notices; a user's memory that a restore does not touch.
    """
    url = f"sqlite:///{path}"
    with open_registry(url, create=True) as registry:
        registry.enroll_many([badge_of("Ada"), badge_of("Bo")])
        registry.revoke("Bo", "stolen")
        first, head = registry.checkpoint()[0], registry.head()
    back_up(way, url, keys, tmp_path / "backup")
    with open_registry(url, create=False) as registry:
        registry.revoke("Ada", "lost after the backup")
        second = registry.checkpoint()[0]
    # The machine is gone, with its memory of what was seen.
    shutil.rmtree(path.parent)
    shutil.rmtree(keys)
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "new machine" / "seen.sqlite3"))
    elsewhere, new_keys = restore(way, tmp_path / "backup", tmp_path / "new machine")
    monkeypatch.setenv("MOIREID_KEYS", str(new_keys))
    with open_registry(elsewhere, create=False) as registry:
        assert registry.audit(head).sound and registry.audit(since=[first]).sound
        assert registry.find("Bo").revoked_reason == "stolen" and registry.find("Ada").revoked_at is None
        found = registry.audit(since=[first, second])
        assert [one.code for one in found.findings] == ["rolled_back"]
        # It can be written to, and goes on from where it was.
        registry.revoke("Ada", "revoked anew")
        assert registry.audit(since=[first]).sound
        # What is written now is another log than the one that was lost.
        registry.enroll(badge_of("Cy"))
        assert {one.code for one in registry.audit(since=[second]).findings} == {"forked"}


def test_a_backup_without_its_key_can_be_read_and_not_written(
    way: str, path: Path, keys: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: words that do not say what is missing; a registry that gets a new key without a word."""
    url = f"sqlite:///{path}"
    with open_registry(url, create=True) as registry:
        registry.enroll(badge_of("Ada"))
        fingerprint = registry.fingerprint
    back_up(way, url, keys, tmp_path / "backup")
    shutil.rmtree(tmp_path / "backup" / "keys")
    (tmp_path / "backup" / "keys").mkdir()
    elsewhere, new_keys = restore(way, tmp_path / "backup", tmp_path / "new machine")
    monkeypatch.setenv("MOIREID_KEYS", str(new_keys))
    done = CliRunner().invoke(moireid, ["registry", "revoke", "Ada", "--reason", "lost", "--registry", elsewhere])
    assert done.exit_code == 2 and f"{fingerprint}.pem" in done.stderr and "bring that file" in done.stderr
    with open_registry(elsewhere, create=False) as registry:
        assert registry.audit().sound and registry.fingerprint == fingerprint
    assert list(new_keys.iterdir()) == []
