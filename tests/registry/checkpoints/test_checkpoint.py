"""Checkpoints that others hold, against everything that can be done to a registry.  Each test says what it
catches."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from kit.registries import badge_of, run, url_of
from kit.witnesses import consistent
from moireid.cli.main import moireid
from moireid.registry import open_registry
from moireid.registry.checkpoints.checkpoint import read_checkpoint


@pytest.fixture
def copies(tmp_path: Path) -> Path:
    folder = tmp_path / "copies"
    folder.mkdir()
    return folder


def codes(path: Path, *witnesses: object) -> list[str]:
    """What the audit finds, held against these checkpoints; its exit code agrees."""
    options = [word for one in witnesses for word in ("--since", one)]
    done = CliRunner().invoke(moireid, ["registry", "audit", "--registry", url_of(path), "--json", *map(str, options)])
    found = json.loads(done.stdout)
    assert done.exit_code == (0 if found["sound"] else 1)
    return [one["code"] for one in found["findings"]]


def noted(path: Path, out: Path) -> Path:
    """A checkpoint of the registry, written by the command."""
    run("registry", "checkpoint", "--out", out, "--registry", url_of(path))
    return out


@pytest.fixture
def grown(path: Path, copies: Path) -> Path:
    """A registry that grew from `early` to `late`, of which both checkpoints and files are kept; Bo is revoked last."""
    with open_registry(url_of(path), create=True) as registry:
        for name in ("Ada", "Bo"):
            registry.enroll(badge_of(name))
    noted(path, copies / "early")
    shutil.copy(path, copies / "early.sqlite3")
    with open_registry(url_of(path), create=False) as registry:
        registry.revoke("Bo", "lost")
    noted(path, copies / "late")
    return path


@pytest.fixture
def stranger(grown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From here on, what is done is done by a person who has seen nothing of the registry before."""
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "another person's"))


def test_a_registry_that_only_grew_holds(grown, copies):
    """Catches: a checkpoint that counts only while it is the newest."""
    assert codes(grown, copies / "early", copies / "late") == []
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Cy"))
    assert codes(grown, copies / "late") == []


@pytest.mark.claim("A fork is found with a kept checkpoint")
def test_forked_is_named(grown, copies, stranger):
    """Catches: a log as long as before, signed by the same key, in which something else was written."""
    shutil.copy(copies / "early.sqlite3", grown)
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Cy"))
    assert codes(grown) == [] and codes(grown, copies / "early") == []
    assert codes(grown, copies / "late") == ["forked"]
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Di"))
    assert codes(grown, copies / "early", copies / "late") == ["forked"]


def test_another_key_is_named(grown, copies):
    """Catches: a registry made anew, which is sound; a key that is put in the other one's place."""
    grown.unlink()
    with open_registry(url_of(grown), create=True) as registry:
        for name in ("Ada", "Bo", "Cy"):
            registry.enroll(badge_of(name))
    assert codes(grown) == [] and codes(grown, copies / "late") == ["key_replaced"]


@pytest.mark.parametrize(("old", "new"), [("\n4\n", "\n3\n"), ("date 2", "date 1"), ("date ", "dates ")])
def test_a_changed_checkpoint_is_refused(grown, copies, old, new):
    """Catches: a size, root or date that is believed without its signature."""
    text = (copies / "late").read_text()
    assert old in text
    (copies / "late").write_text(text.replace(old, new))
    refused = run("registry", "audit", "--since", copies / "late", "--registry", url_of(grown), code=2)
    assert refused.stderr.startswith("error: ") and refused.stderr.count("\n") == 1


@pytest.mark.parametrize("letters", ["_", "____", "-", "=", " "])
def test_a_root_in_other_letters_than_base64_has_is_no_checkpoint(grown, copies, letters):
    """Catches: `Incorrect padding` out of a decoder that passes over such letters; a root of fewer bytes."""
    origin, size, root, *rest = (copies / "late").read_text().split("\n")
    (copies / "late").write_text("\n".join([origin, size, letters + root[len(letters) :], *rest]))
    refused = run("registry", "audit", "--since", copies / "late", "--registry", url_of(grown), code=2)
    assert "is no checkpoint; give a file that" in refused.stderr


def test_a_checkpoint_proves_that_it_adds_to_an_earlier_one(grown, copies, tmp_path):
    """Catches: a proof of something else; a registry that signs what contradicts what it signed."""
    early = read_checkpoint(copies / "early")
    options = ("--registry", url_of(grown), "--since", copies / "early", "--json")
    said = json.loads(run("registry", "checkpoint", "--out", tmp_path / "new", *options).stdout)
    (proven,) = said["consistent_with"]
    proof = [bytes.fromhex(step) for step in proven["proof"]]
    assert consistent(proven["size"], bytes.fromhex(early.head.hash), said["size"], bytes.fromhex(said["root"]), proof)
    assert (proven["size"], said["size"]) == (3, 4) and said["fingerprint"] == early.fingerprint
    late = ("--since", copies / "late", "--registry", url_of(grown))
    (copies.parent / "seen.sqlite3").unlink()
    shutil.copy(copies / "early.sqlite3", grown)
    refused = run("registry", "checkpoint", "--out", tmp_path / "other", *late, code=2)
    assert "rolled back" in refused.stderr and not (tmp_path / "other").exists()
