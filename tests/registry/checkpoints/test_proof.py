"""Proofs that a badge is in the log.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import json
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from kit.registries import badge_of, url_of
from moireid.cli.main import moireid
from moireid.errors import RegistryError
from moireid.registry import Registry, open_registry
from moireid.registry.checkpoints.proof import check_proof
from moireid.registry.record import Fault


def test_every_badge_of_the_log_is_proved(full: Registry) -> None:
    """Catches: a proof of another entry; of the issue where a revocation came later; a checkpoint of another log."""
    for record in full.records():
        found = check_proof(full.prove(record), "it")
        assert (found.record.name, found.record.id) == (record.name, record.id)
        assert (found.record.revoked_at, found.record.revoked_reason) == (record.revoked_at, record.revoked_reason)
        assert found.checkpoint.fingerprint == full.fingerprint and found.checkpoint.size == 6
    assert {check_proof(full.prove(one), "it").entry for one in full.records()} == {4, 5, 6}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "field", "value"),
    [
        ("record", "name", "Ada was in the log\n  authority: 00, the one that you trust"),
        ("record", "name", "Ada\x1b[8m"),
        ("record", "revoked_reason", "x\r"),
        ("entry", "time", "2026\n"),
        ("entry", "seq", float("inf")),
        ("entry", "seq", float("nan")),
        ("entry", "seq", 1.0),
        ("entry", "seq", 10**30),
        ("entry", "seq", -1),
    ],
)
def test_a_proof_writes_no_lines_of_its_own_and_ends_in_no_traceback(
    full: Registry, part: str, field: str, value: object
) -> None:
    """Catches: a name that fakes the line on its authority, or hides it; a number that is none."""
    document = json.loads(full.prove(next(full.records())))
    document[part][field] = value
    with pytest.raises(RegistryError, match="is no proof"):
        check_proof(json.dumps(document), "it")


def _smaller_log(document: dict[str, Any]) -> None:
    lines = document["checkpoint"].split("\n")
    document["checkpoint"] = "\n".join([lines[0], "7", *lines[2:]])


#: What is changed, and the part by which that is reported.
CHANGES: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "name": (lambda d: d["record"].update(name="Eve"), "record"),
    "revocation": (lambda d: d["record"].update(revoked_at=None), "record"),
    "time": (lambda d: d["entry"].update(time="2020-01-01T00:00:00Z"), "entry"),
    "place": (lambda d: d["entry"].update(seq=d["entry"]["seq"] - 1), "entry"),
    "step": (lambda d: d["proof"].__setitem__(0, "00" * 32), "entry"),
    "one step less": (lambda d: d["proof"].pop(), "entry"),
    "root": (_smaller_log, "checkpoint"),
    "key": (lambda d: d.update(public_key="11" * 32), "public_key"),
}


@pytest.mark.slow
@pytest.mark.parametrize("what", CHANGES)
def test_every_change_is_reported_by_its_part(full: Registry, what: str) -> None:
    """Catches: a part that no hash and no signature covers, or that no one compares."""
    change, code = CHANGES[what]
    document = json.loads(full.prove(full.find("Bo")))
    change(document)
    with pytest.raises(Fault) as caught:
        check_proof(json.dumps(document), "it")
    assert caught.value.code == code


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)
    with open_registry(url_of(tmp_path / "r.sqlite3"), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    return lambda *words: CliRunner().invoke(moireid, ["registry", *words])


def test_no_command_writes_over_its_own_registry(run: Callable[..., Result], tmp_path: Path) -> None:
    """Catches: a registry that is gone once a checkpoint, a proof, a bundle or an export was given its name."""
    before = (tmp_path / "r.sqlite3").read_bytes()
    to = ("--registry", "sqlite:///r.sqlite3", "--overwrite")
    for words in (("checkpoint", "--out"), ("prove", "Ada", "--out"), ("publish", "--out"), ("export",)):
        done = run(*words, "r.sqlite3", *to)
        assert done.exit_code == 2 and "is a file that is read here" in done.output, done.output
    assert (tmp_path / "r.sqlite3").read_bytes() == before


@pytest.mark.parametrize("text", ["", "[]", "{}", "no proof", '{"format": 1}', "[" * 10000])
def test_what_is_no_proof_is_bad_input(text: str) -> None:
    """Catches: a traceback, and "does not hold" of a file that is something else."""
    with pytest.raises(RegistryError, match="it is no proof"):
        check_proof(text, "it")


def test_the_commands_make_and_check_it(run: Callable[..., Result], tmp_path: Path) -> None:
    """Catches: a file that everybody may read, though it holds an identity; another authority that is believed."""
    made = run("prove", "Ada", "--out", "ada.proof", "--registry", "sqlite:///r.sqlite3", "--json")
    assert made.exit_code == 0, made.output
    assert stat.S_IMODE((tmp_path / "ada.proof").stat().st_mode) == 0o600
    trusted = json.loads(made.stdout)["fingerprint"]
    held = run("check-proof", "ada.proof", "--trust", trusted)
    assert held.exit_code == 0 and "HOLDS: badge" in held.output and "What came later" in held.output
    answer = json.loads(run("check-proof", "ada.proof", "--json").stdout)
    assert answer["holds"] and answer["badge"]["name"] == "Ada" and not answer["trusted"]
    other = run("check-proof", "ada.proof", "--trust", "ab" * 16)
    assert other.exit_code == 1 and "DOES NOT HOLD: it is signed by authority" in other.output
    text = (tmp_path / "ada.proof").read_text(encoding="utf-8")
    (tmp_path / "eve.proof").write_text(text.replace('"name": "Ada"', '"name": "Eve"'), encoding="utf-8")
    changed = run("check-proof", "eve.proof", "--json")
    assert changed.exit_code == 1 and json.loads(changed.stdout)["code"] == "record"
    assert run("check-proof", "none.proof").exit_code == 2
    assert run("prove", "Ada", "--out", "ada.proof", "--registry", "sqlite:///r.sqlite3").exit_code == 2
