"""Films of badges that were revoked: the verdict by name.  Each test names what it would catch."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from kit.webbing import badge_film
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.idcodes import specimen_of
from moireid.registry import Registry, open_registry


@pytest.fixture(scope="module")
def film(ada: Badge, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return badge_film(ada, tmp_path_factory.mktemp("film") / "ada.mp4")


@pytest.fixture
def registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Registry]:
    """Of nobody; what is seen of it lies with the test."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as opened:
        yield opened


def judged(*words: object, code: int) -> str:
    done = CliRunner().invoke(moireid, [*map(str, words)])
    assert done.exit_code == code, done.output
    return done.stdout


@pytest.mark.claim("A revoked badge is rejected by every way in")
@pytest.mark.slow
def test_every_check_says_what_bars_the_badge(film, registry, ada, tmp_path):
    """Catches: a way in by which such a badge passes; a reason that is not named."""
    url, bundle = f"sqlite:///{tmp_path}/people.sqlite3", tmp_path / "bundle"
    (tmp_path / "badge.json").write_text(ada.to_json(), encoding="utf-8")
    registry.enroll(ada)
    ways = [
        ("verify", film, "--claim", ada.name, "--registry", url),
        ("verify", film, "--badge", tmp_path / "badge.json", "--registry", url),
        ("verify", film, "--claim", ada.name, "--bundle", bundle),
        ("identify", film, "--registry", url),
        ("identify", film, "--bundle", bundle),
    ]
    assert judged(*ways[0], code=0).startswith(f"ACCEPT: Genuine, and {ada.name}'s")
    registry.revoke(ada.name, "mislaid")
    registry.publish(bundle, specimen_of, days=40_000)
    for way in ways:
        printed = judged(*way, code=1)
        assert ": Revoked on " in printed and "mislaid" in printed
    found = json.loads(judged(*ways[0], "--json", code=1))
    assert found["verdict"] == "reject" and found["reasons"][-1]["code"] == "revoked"
