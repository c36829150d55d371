"""`moireid enroll` and `moireid registry`: what they say, in words and in JSON, and how they leave."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kit.registries import badge_of, run, tamper, url_of
from moireid.registry import open_registry


@pytest.fixture
def badge_file(tmp_path: Path) -> Path:
    (tmp_path / "badge.json").write_text(badge_of("Ada").to_json(), encoding="utf-8")
    return tmp_path / "badge.json"


def run_json(*command: object, code: int = 0) -> dict:
    """What a command says with --json: one object on stdout and nothing else there."""
    return json.loads(run(*command, "--json", code=code).stdout)


def test_audit_that_finds_something(url, badge_file):
    """Catches: exit code 0 for a registry that does not hold; a page of findings on the terminal."""
    to = ("--registry", url)
    run("enroll", badge_file, *to)
    with open_registry(url, create=False) as registry:
        registry.enroll_many(badge_of("Bo", bytes([k, 0, 0])) for k in range(30))
    tamper(url, "UPDATE badges SET issued_at = '2001-01-01T00:00:00Z'")
    seen = run_json("registry", "audit", *to, code=1)
    assert (seen["sound"], seen["found"], len(seen["findings"])) == (False, 31, 31)
    assert set(seen["findings"][0]) == {"code", "text", "subject"}
    text = run("registry", "audit", *to, code=1).stdout
    assert "NOT SOUND" in text and text.count("✗") == 20 and "and 11 more" in text
    assert "tampered with" in run("registry", "show", "Ada", *to, code=2).stderr


def test_no_command_writes_over_its_own_registry(path, tmp_path):
    """Catches: a registry that is gone once a checkpoint, a bundle or an export was given its name."""
    with open_registry(url_of(path), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    before = path.read_bytes()
    for words in (("checkpoint", "--out"), ("publish", "--out"), ("export",)):
        done = run("registry", *words, path, "--registry", url_of(path), "--overwrite", code=2)
        assert "is a file that is read here" in done.output
    assert path.read_bytes() == before


def test_a_list_shows_the_sound_records_before_it_names_a_damaged_one(url):
    """Catches: one altered row that hides everyone; an altered row that is shown."""
    with open_registry(url, create=True) as registry:
        registry.enroll_many(badge_of(name) for name in ("Ada", "Bo", "Cy"))
    tamper(url, "UPDATE badges SET issued_at = '2001-01-01T00:00:00Z' WHERE name_nfc = 'Bo'")
    done = run("registry", "list", "--registry", url, code=2)
    assert [line.split()[-1] for line in done.stdout.splitlines()] == ["Ada", "Cy"]
    assert "tampered with" in done.stderr
