"""Registries whose checkpoints witnesses sign, and readers who ask for them.

Each test names the wrong implementation, or the attack by those who run the registry, that it catches.
"""

from __future__ import annotations

import json
import shutil
import time
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from click.testing import Result

from kit.registries import badge_of, run, url_of
from kit.witnesses import Witness
from moireid.api.asking import ClaimContext, claim_context
from moireid.cli.common import report_standing
from moireid.cli.witness_options import WitnessCheck
from moireid.errors import RegistryError
from moireid.registry import holder_of, open_registry, public_view
from moireid.registry.checkpoints.checkpoint import read_checkpoint
from moireid.registry.checkpoints.cosignature import witness_keys
from moireid.registry.checkpoints.note import VerifierKey


class Witnesses:
    """Three witnesses whom readers know."""

    def __init__(self) -> None:
        self.all = [Witness(f"witness.example/w{number}") for number in (1, 2, 3)]
        self.keys = [one.key for one in self.all]

    def first(self, count: int) -> tuple[VerifierKey, ...]:
        return witness_keys(self.keys[:count])

    def sign(self, checkpoint: Path, count: int = 3) -> Path:
        """Have the first of them add their lines."""
        for one in self.all[:count]:
            one.sign(checkpoint)
        return checkpoint


@pytest.fixture
def witnesses() -> Witnesses:
    return Witnesses()


@pytest.fixture
def grown(path: Path) -> Path:
    """A registry with two people, three entries."""
    with open_registry(url_of(path), create=True) as registry:
        for name in ("Ada", "Bo"):
            registry.enroll(badge_of(name))
    return path


def noted(path: Path, out: Path) -> Path:
    run("registry", "checkpoint", "--out", out, "--registry", url_of(path))
    return out


def code_with(path: Path, checkpoint: Path, asked: tuple[VerifierKey, ...]) -> str | None:
    """The code by which a reader who asks for witnesses is refused; None if they are not."""
    with open_registry(url_of(path), create=False) as registry:
        try:
            registry.require_witnesses(asked, read_checkpoint(checkpoint))
        except RegistryError as error:
            assert "\n" not in str(error) and ";" in str(error)
            return str(error.details["code"])
    return None


@pytest.fixture
def stranger(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A reader who has seen nothing of any registry."""
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "stranger"))
    return tmp_path / "stranger"


def test_signatures_that_others_added_count(grown, witnesses, tmp_path):
    """Catches: a note with lines of strangers that is refused; one signature that counts as two; a missing one that
    counts."""
    out = witnesses.sign(noted(grown, tmp_path / "one.checkpoint"), 2)
    Witness("stranger.example/w9").sign(out)
    words = [word for key in witnesses.keys for word in ("--witness-key", key)]
    audit = ("registry", "audit", "--since", out, "--registry", url_of(grown))
    seen = json.loads(run(*audit, *words[:4], "--json").stdout)["witnessed"]
    assert seen["size"] == 3 and set(seen["signers"]) == {"witness.example/w1", "witness.example/w2"}
    assert "witnesses have seen 3 of 3 entries" in run(*audit, *words[:4]).stdout
    assert "not_witnessed" in run(*audit, *words, "--json", code=1).stdout
    assert code_with(grown, out, witnesses.first(2)) is None
    assert code_with(grown, out, witnesses.first(3)) == "not_witnessed"


@pytest.mark.claim("Two registries for two readers are refused for who asks for witnesses")
def test_a_split_view_is_refused(grown, witnesses, tmp_path, stranger):
    """Attack: two readers are shown two logs, each signed by the registry's own key."""
    shutil.copy(grown, other := tmp_path / "other.sqlite3")
    with open_registry(url_of(grown), create=False) as registry:
        registry.revoke("Bo", "lost")
    true = witnesses.sign(noted(grown, tmp_path / "true"))
    stranger.unlink()
    with open_registry(url_of(other), create=False) as registry:
        registry.enroll(badge_of("Cy"))
    assert code_with(other, noted(other, tmp_path / "own"), witnesses.first(2)) == "not_witnessed"
    assert code_with(other, true, witnesses.first(2)) == "forked"
    # A fork that is longer than what the witnesses have seen.
    with open_registry(url_of(other), create=False) as registry:
        registry.enroll(badge_of("Di"))
    assert code_with(other, true, witnesses.first(2)) == "forked"


@pytest.mark.claim("A state from before a revocation passes no longer than its cosignatures count")
def test_a_rollback_passes_no_longer_than_signatures_count(grown, witnesses, tmp_path, stranger, monkeypatch):
    """Attack: the state of before a revocation is put back, with the checkpoint of that day."""
    witnesses.sign(noted(grown, tmp_path / "early"))
    shutil.copy(grown, early := tmp_path / "early.sqlite3")
    with open_registry(url_of(grown), create=False) as registry:
        registry.revoke("Bo", "lost")
    witnesses.sign(noted(grown, tmp_path / "late"))
    stranger.unlink()
    assert code_with(early, tmp_path / "late", witnesses.first(2)) == "rolled_back"
    # This is what is left to the attacker: a few days.
    assert code_with(early, tmp_path / "early", witnesses.first(3)) is None
    now = time.time()
    monkeypatch.setattr("moireid.registry.checkpoints.cosignature.time.time", lambda: now + 8 * 86400)
    assert code_with(early, tmp_path / "early", witnesses.first(3)) == "not_witnessed"


def test_what_no_witness_has_seen_is_not_relied_on(grown, witnesses, tmp_path):
    """Attack: a badge is entered for one reader alone, after the checkpoint; catches: a lost revocation."""
    out = witnesses.sign(noted(grown, tmp_path / "one"))
    check = WitnessCheck(out, witnesses.first(3))
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Cy"))
        registry.revoke("Bo", "lost")
        cy = registry.find("Cy").id

    def claim(name: str) -> AbstractContextManager[ClaimContext]:
        return claim_context(name, None, url_of(grown), None, None, report_standing, check.require)

    with claim("Ada") as (found, look_up):
        assert found.barred is None
        with pytest.raises(RegistryError) as unseen:
            look_up({"identity": {"verdict": "mismatch", "decoded_id": cy}, "badge": {"id": "0" * 16}})
    assert unseen.value.details["code"] == "not_witnessed"
    with pytest.raises(RegistryError, match="witnesses have seen 3"), claim("Cy"):
        pass
    with claim("Bo") as (found, _):
        assert found.barred is not None
    with open_registry(url_of(grown), create=False) as registry:
        assert holder_of(registry, cy) is not None


def test_a_registry_that_is_exchanged_after_the_check_is_found(grown, witnesses, tmp_path, stranger, monkeypatch):
    """Attack: the file is exchanged for a fork between the check and the look-up, by a reader who remembers nothing."""
    shutil.copy(grown, fork := tmp_path / "fork.sqlite3")
    for path, names in ((grown, ["Cy"]), (fork, ["Cy", "Di"])):
        with open_registry(url_of(path), create=False) as registry:
            for name in names:
                registry.enroll(badge_of(name))
        stranger.unlink()
    out = witnesses.sign(noted(grown, tmp_path / "one"))
    monkeypatch.setattr("moireid.registry.rollback.recall", lambda place: (None, {}))
    with open_registry(url_of(grown), create=False) as registry:
        registry.require_witnesses(witnesses.first(3), read_checkpoint(out))
        shutil.copy(fork, grown)
        with pytest.raises(RegistryError) as refused:
            registry.check_newest(registry.find("Ada"))
    assert refused.value.details["code"] == "forked"


def test_a_checkpoint_of_a_stranger_does_not_count(grown, witnesses, tmp_path):
    """Catches: a checkpoint of another registry that proves something."""
    out = witnesses.sign(noted(grown, tmp_path / "one"))
    with open_registry(url_of(tmp_path / "b.sqlite3"), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    assert code_with(tmp_path / "b.sqlite3", out, witnesses.first(3)) == "key_replaced"


def _published(grown: Path, out: Path, *options: object, code: int = 0) -> Result:
    return run("registry", "publish", "--out", out, "--registry", url_of(grown), "--overwrite", *options, code=code)


def bundle_code(bundle: Path, asked: tuple[VerifierKey, ...]) -> str | None:
    """The code by which a claim in a bundle is refused to a reader who asks for witnesses; None if it is not."""
    claimed = claim_context("Ada", None, None, bundle, None, report_standing, WitnessCheck(None, asked).require)
    try:
        with claimed as (found, _):
            assert found.barred is None
    except RegistryError as error:
        assert "\n" not in str(error) and ";" in str(error)
        return str(error.details["code"])
    return None


def test_a_bundle_holds_what_witnesses_signed(grown, witnesses, tmp_path, monkeypatch):
    """Catches: cosignatures that are checked and not kept; a bundle whose witnesses count for ever, or for anyone."""
    out = tmp_path / "people.bundle"
    _published(grown, out, "--checkpoint", witnesses.sign(noted(grown, tmp_path / "one"), 2))
    assert bundle_code(out, witnesses.first(2)) is None
    assert bundle_code(out, witnesses.first(3)) == "not_witnessed"
    now = time.time()
    monkeypatch.setattr("moireid.registry.checkpoints.cosignature.time.time", lambda: now + 8 * 86400)
    assert bundle_code(out, witnesses.first(2)) == "not_witnessed"


def test_a_checkpoint_of_another_log_is_not_published(grown, witnesses, tmp_path):
    """Catches: a bundle that every reader with witnesses refuses, made from a checkpoint of last week, of a stranger's
    registry, or one that was changed."""
    early = witnesses.sign(noted(grown, tmp_path / "early"))
    with open_registry(url_of(tmp_path / "b.sqlite3"), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    other = noted(tmp_path / "b.sqlite3", tmp_path / "other")
    changed = tmp_path / "changed"
    changed.write_text(early.read_text(encoding="utf-8").replace("\n3\n", "\n4\n", 1), encoding="utf-8")
    with open_registry(url_of(grown), create=False) as registry:
        registry.revoke("Bo", "lost")
    for wrong, said in ((early, "3 log entries"), (other, "its key was replaced"), (changed, "changed or is damaged")):
        done = _published(grown, tmp_path / "x", "--checkpoint", wrong, code=2)
        assert said in done.stderr and done.stderr.count("\n") == 1 and not (tmp_path / "x").exists()


def test_a_bundle_with_the_checkpoint_of_another_log_is_refused(grown, witnesses, tmp_path, stranger, monkeypatch):
    """Attack: the registry's own key signs a bundle over a log for one reader, with the witnesses' true checkpoint."""
    true = witnesses.sign(noted(grown, tmp_path / "true")).read_text(encoding="utf-8")
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Cy"))
    made = public_view.BundleContent
    monkeypatch.setattr(public_view, "BundleContent", lambda checkpoint, *rest: made(true, *rest))
    _published(grown, tmp_path / "false.bundle")
    assert bundle_code(tmp_path / "false.bundle", witnesses.first(3)) == "forked"


@pytest.mark.parametrize(
    "command", [["verify", "x.mp4", "--claim", "Ada"], ["identify", "x.mp4"], ["attest", "check", "x"]]
)
def test_readers_refuse_half_a_request(command, witnesses, tmp_path):
    """Catches: a reader who believes that witnesses are asked for, while they are not."""
    key = ["--witness-key", witnesses.keys[0]]
    assert "--checkpoint" in run(*command, *key, code=2).stderr
    assert "--witness-key" in run(*command, "--checkpoint", "x", code=2).stderr
    assert "--bundle" in run(*command, *key, "--checkpoint", "x", "--bundle", "b", code=2).stderr
