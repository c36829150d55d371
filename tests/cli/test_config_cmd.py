"""What a user sets once: the file, what comes before it, and what a command makes of a wrong one."""

from __future__ import annotations

import json
import stat
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from moireid.cli.main import moireid
from moireid.registry.engine import default_url, read_url


@pytest.fixture(autouse=True)
def settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of the settings, which is not there, and the folder that the commands are called from."""
    monkeypatch.setenv("MOIREID_CONFIG", str(tmp_path / "user" / "config.toml"))
    monkeypatch.delenv("MOIREID_REGISTRY", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "user" / "config.toml"


def run(*words: str) -> Result:
    return CliRunner().invoke(moireid, list(words))


def done(*words: str) -> str:
    outcome = run(*words)
    assert outcome.exit_code == 0, outcome.stderr
    return outcome.stdout


def refused(*words: str) -> str:
    outcome = run(*words)
    assert outcome.exit_code != 0 and "Traceback" not in outcome.stderr
    return outcome.stderr


def shown() -> dict[str, tuple[str | None, str]]:
    rows = json.loads(done("config", "show", "--json"))["settings"]
    return {key: (row["value"], row["from"]) for key, row in rows.items()}


@pytest.mark.claim("An option beats the environment, that a file, that the default")
def test_option_then_environment_then_file_then_default(
    tmp_path: Path, settings: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a file that beats the environment, or either one that beats an option; a file that no command reads."""
    plain = default_url()
    for name in ("file", "environment", "option"):
        done("registry", "init", "--registry", f"{name}.sqlite3")

    def asked(*words: str) -> str:
        return str(json.loads(done("registry", "list", "--json", *words))["registry"])

    done("config", "set", "registry", "file.sqlite3")
    # From wherever the next command comes.
    monkeypatch.chdir(settings.parent)
    assert "file.sqlite3" in asked() and shown()["registry"][1] == "file"
    monkeypatch.setenv("MOIREID_REGISTRY", str(tmp_path / "environment.sqlite3"))
    assert "environment.sqlite3" in asked() and shown()["registry"][1] == "environment"
    assert "option.sqlite3" in asked("--registry", str(tmp_path / "option.sqlite3"))
    monkeypatch.delenv("MOIREID_REGISTRY")
    done("config", "unset", "registry")
    assert default_url() == plain and shown()["registry"] == (None, "default")


def test_print_takes_the_settings_and_enters_no_badge_by_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a setting that is shown and not used; a trial print that issues a badge because a variable is set."""
    done("config", "set", "paper", "letter")
    done("config", "set", "printer-dpi", "600")
    monkeypatch.setenv("MOIREID_REGISTRY", str(tmp_path / "people.sqlite3"))
    made = json.loads(done("print", "Ada", "--out", "a", "--mount", "none", "--json"))
    badge = json.loads((tmp_path / "a" / "badge.json").read_text())
    assert badge["page"]["width_mm"] == pytest.approx(215.9) and badge["print"]["dpi"] == 600
    assert made["issued"] is False and not (tmp_path / "people.sqlite3").exists()
    done("print", "Ada", "--out", "b", "--mount", "none", "--paper", "a4")
    assert json.loads((tmp_path / "b" / "badge.json").read_text())["page"]["width_mm"] == pytest.approx(210)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('papers = "a4"', "no such setting as 'papers' (did you mean paper?)"),
        ('paper = "a3"', "paper in {file}: 'a3' is not one of"),
        ("paper = [1]", "paper is neither a text nor a whole number"),
        ("paper = ", "{file} is no TOML"),
    ],
)
def test_a_file_that_was_written_by_hand_is_checked(settings: Path, text: str, words: str) -> None:
    """Catches: a traceback, or a wrong line that is passed over."""
    settings.parent.mkdir()
    settings.write_text(text, encoding="utf-8")
    assert words.format(file=settings) in refused("print", "Ada", "--out", "a", "--mount", "none")


def test_the_file_is_its_users_alone_and_hides_no_password_in_show(settings: Path) -> None:
    """Catches: a password of a database that other accounts can read, or that a screen shows; a text that TOML reads
    otherwise than it was given."""
    done("config", "set", "registry", "postgresql://ada:secret@host/people")
    done("config", "set", "actor", 'Ada "the" \\ Ünïcode')
    assert stat.S_IMODE(settings.stat().st_mode) == 0o600
    assert "secret" not in done("config", "show") and "secret" in settings.read_text(encoding="utf-8")
    assert shown()["actor"] == ('Ada "the" \\ Ünïcode', "file")


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
