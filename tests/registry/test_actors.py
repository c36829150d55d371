"""Who did what.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from kit.registries import badge_of, rows_of, tamper
from moireid.cli.main import moireid
from moireid.errors import RegistryError
from moireid.registry.keys import account


def test_each_entry_names_who_did_it(registry):
    """Catches: the actor of the opening kept for all; an order of the log that is not its own."""
    registry.enroll(badge_of("Ada"))
    registry.by("Bob at the desk").revoke("Ada", "lost")
    done = [(entry["seq"], entry["action"], entry["actor"]) for entry in registry.entries()]
    assert done == [(3, "revoke", "Bob at the desk"), (2, "enroll", account()), (1, "init", account())]
    assert [entry["seq"] for entry in registry.entries("Ada", 1)] == [3]
    assert registry.audit().sound


def test_no_one_can_change_who_it_was(registry, url):
    """Catches: an actor outside of what is hashed."""
    registry.by("Bob").enroll(badge_of("Ada"))
    assert tamper(url, "UPDATE log SET actor = 'Eve' WHERE seq = 2") == 1
    assert [finding.code for finding in registry.audit().findings] == ["entry_hash"]


def test_the_log_keeps_no_secret(registry, url):
    """Catches: a token in the place of a name, in the table or in the message; a name that is no line."""
    for wrong in ("moireid_Zm9v", "token moireid_Zm9v", " ", "a\x00b", "x" * 201):
        with pytest.raises(RegistryError) as caught:
            registry.by(wrong)
        assert "Zm9v" not in str(caught.value)
    registry.enroll(badge_of("Ada"))
    assert {row["actor"] for row in rows_of(url, "SELECT actor FROM log")} == {account()}


def test_the_command_says_who_did_what(tmp_path, keys):
    """Catches: --actor that is not handed on; a log that shows another badge."""
    url = f"sqlite:///{tmp_path}/r.sqlite3"
    for name in ("Ada", "Bo"):
        (tmp_path / f"{name}.json").write_text(badge_of(name).to_json(), encoding="utf-8")
        command = ["enroll", str(tmp_path / f"{name}.json"), "--registry", url, "--actor", f"{name}'s friend"]
        assert CliRunner().invoke(moireid, command).exit_code == 0
    answer = json.loads(CliRunner().invoke(moireid, ["registry", "log", "Ada", "--registry", url, "--json"]).stdout)
    assert [(entry["action"], entry["actor"]) for entry in answer["entries"]] == [("enroll", "Ada's friend")]
    lines = CliRunner().invoke(moireid, ["registry", "log", "--registry", url]).stdout.splitlines()
    assert [line.rpartition("  ")[2] for line in lines] == ["Bo's friend", "Ada's friend", "Ada's friend"]
