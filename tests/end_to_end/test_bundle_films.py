"""A film judged by a bundle, and by the registry that it was made of.  Each test names what it would catch."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from kit.report_faults import faults
from kit.webbing import badge_film
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.designer import Order, design_badge
from moireid.idcodes import specimen_of
from moireid.registry import Registry, open_registry


@pytest.fixture(scope="module")
def film(ada: Badge, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return badge_film(ada, tmp_path_factory.mktemp("film") / "ada.mp4")


@pytest.fixture
def registry(ada: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Registry]:
    """Ada, whose film it is, and Sarah; what is seen of them lies with the test."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as opened:
        opened.enroll(ada)
        opened.enroll(design_badge(Order("Sarah Example", lens="50lpi"), bytes(range(8))))
        yield opened


def verified(film: Path, claim: str, *options: object) -> dict[str, Any]:
    done = CliRunner().invoke(moireid, ["verify", str(film), "--claim", claim, "--json", *map(str, options)])
    assert done.exit_code in (0, 1, 3), done.output
    return json.loads(done.stdout)


@pytest.mark.slow
def test_a_bundle_judges_as_the_registry_does(film, registry, ada, tmp_path):
    """Catches: a specimen that is read otherwise; a seal that nobody opens; a report without its registry."""
    registry.publish(tmp_path / "bundle", specimen_of, days=7)
    online = verified(film, ada.name, "--registry", f"sqlite:///{tmp_path}/people.sqlite3")
    offline = verified(film, ada.name, "--bundle", tmp_path / "bundle", "--trust", registry.fingerprint)
    assert online["verdict"] == offline["verdict"] == "accept"
    assert (online["claim_source"], offline["claim_source"]) == ("registry", "bundle")
    for report in (online, offline):
        assert faults(report) == []
        assert (report["registry"]["fingerprint"], report["registry"]["head"]) == (
            registry.fingerprint,
            registry.head(),
        )
        assert report["identity"]["decoded_id"] == report["identity"]["claimed_id"] == ada.id
        assert report["badge"]["name"] == ada.name
    assert online["registry"]["expires"] is None and offline["registry"]["expires"]
    assert offline["identity"]["expected_beat_period_mm"] == online["identity"]["expected_beat_period_mm"]
    assert offline["invariant"]["gain_ratio"] == pytest.approx(online["invariant"]["gain_ratio"], abs=0.01)


def shown(film: Path, claim: str, *options: object) -> str:
    return CliRunner().invoke(moireid, ["verify", str(film), "--claim", claim, *map(str, options)]).stdout


@pytest.mark.slow
def test_a_badge_that_no_seal_opens_for_is_nobody_s(film, ada, tmp_path, monkeypatch):
    """Catches: a seal that opens for any identity; a badge of no one that is reported as someone's."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    with open_registry(f"sqlite:///{tmp_path}/other.sqlite3", create=True) as opened:
        opened.enroll(design_badge(Order("Sarah Example", lens="50lpi"), bytes(range(8))))
        opened.publish(tmp_path / "bundle", specimen_of, days=7)
    report = shown(film, "Sarah Example", "--bundle", tmp_path / "bundle")
    assert report.startswith("REJECT: Genuine, but held by no one in this bundle, and not Sarah Example's")


def identified(film: Path, *options: object) -> tuple[int, str, str]:
    done = CliRunner().invoke(moireid, ["identify", str(film), *map(str, options)])
    return done.exit_code, done.stdout, done.output


@pytest.mark.slow
def test_a_bundle_finds_whose_badge_it_is(film, registry, ada, tmp_path):
    """Catches: a specimen that reads no identity; a name without the bundle's date; a revoked person who is found."""
    bundle = tmp_path / "bundle"
    registry.publish(bundle, specimen_of, days=7)
    code, report, _ = identified(film, "--bundle", bundle, "--trust", registry.fingerprint, "--json")
    document = json.loads(report)
    assert code == 0 and (document["found_id"], document["found_name"]) == (ada.id, ada.name)
    assert document["registry"]["expires"] and document["registry"]["fingerprint"] == registry.fingerprint
    code, report, _ = identified(film, "--bundle", bundle)
    assert code == 0 and f"Genuine, and {ada.name}'s" in report and "in a bundle that counts until" in report
    registry.revoke(ada.name, "lost on the train")
    registry.publish(bundle, specimen_of, days=7, overwrite=True)
    code, report, _ = identified(film, "--bundle", bundle)
    assert code == 1 and "Revoked on" in report and "lost on the train" in report
