"""Variables of the environment that stand for options, and the path of a registry."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid.registry.engine import read_url


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The commands are called from a folder of the test."""
    monkeypatch.delenv("MOIREID_REGISTRY", raising=False)
    monkeypatch.chdir(tmp_path)


def done(*words: str) -> str:
    outcome = CliRunner().invoke(moireid, list(words))
    assert outcome.exit_code == 0, outcome.stderr
    return outcome.stdout


def refused(*words: str) -> str:
    outcome = CliRunner().invoke(moireid, list(words))
    assert outcome.exit_code != 0 and "Traceback" not in outcome.stderr
    return outcome.stderr


def test_an_option_comes_before_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a variable that beats an option, or that no command reads; a wrong value that is passed over; a trial
    print that issues a badge because a variable is set."""
    for name in ("environment", "option"):
        done("registry", "init", "--registry", f"{name}.sqlite3")
    monkeypatch.setenv("MOIREID_REGISTRY", str(tmp_path / "environment.sqlite3"))
    for words, name in (((), "environment"), (("--registry", "option.sqlite3"), "option")):
        assert f"{name}.sqlite3" in json.loads(done("registry", "list", "--json", *words))["registry"]
    monkeypatch.setenv("MOIREID_PAPER", "letter")
    for words, wide in (((), 215.9), (("--paper", "a4"), 210)):
        made = json.loads(done("print", "Ada", "--out", "a", "--mount", "none", "--json", "--overwrite", *words))
        assert made["issued"] is False
        assert json.loads((tmp_path / "a" / "badge.json").read_text())["page"]["width_mm"] == pytest.approx(wide)
    monkeypatch.setenv("MOIREID_PAPER", "a9")
    assert "'a9' is not one of 'a4', 'letter', 'a3'" in refused("print", "Ada", "--out", "b", "--mount", "none")


def test_a_plain_path_is_an_sqlite_file_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: the contract's plain path refused; a misspelt URL that makes a file of that name."""
    monkeypatch.setenv("HOME", str(tmp_path))
    for given in ("people.sqlite3", str(tmp_path / "people.sqlite3"), "~/people.sqlite3"):
        assert read_url(given) == read_url(f"sqlite:///{tmp_path / 'people.sqlite3'}")
    done("print", "Ada", "--out", "a", "--mount", "none", "--registry", "people.sqlite3")
    for words in (("registry", "list"), ("enroll", "a/badge.json"), ("registry", "audit")):
        assert "people" in done(*words, "--registry", "people.sqlite3", "--json")
    assert "no database URL" in refused("registry", "init", "--registry", "postgres:people")
    assert "no registry at" in refused("registry", "list", "--registry", "nothere.sqlite3")
