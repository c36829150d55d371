"""Badges that stop to count, and count again.  Each test says what it catches."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kit.registries import badge_of, run, url_of
from moireid.errors import RegistryError, SpecError
from moireid.idcodes import specimen_of
from moireid.registry import People, Registry, claimed, holder_of, open_registry, people_of
from moireid.registry.bundle.held import Bundle


@pytest.fixture
def full(registry: Registry) -> Registry:
    """Three badges that were never measured, one of them revoked."""
    for name in ("Ada", "Bo", "Zo\u00eb"):
        registry.enroll(badge_of(name))
    registry.revoke("Bo", "lost on the train")
    return registry


def test_a_suspended_badge_counts_for_nothing_until_it_is_reinstated(full):
    """Catches: a suspension that only a list shows; one that is for good; one that leaves the record changed."""
    before = full.find("Zo\u00eb")
    full.by("Bob").suspend("Zo\u00eb", " mislaid ")
    barred = claimed(full, "Zo\u00eb").barred
    assert barred and (barred.code, barred.reason) == ("suspended", "mislaid")
    holder = holder_of(full, before.id)
    assert holder and holder.barred == barred and not people_of(full).holds(before.id)
    assert "mislaid" in barred.text
    full.by("Eve").reinstate(before.id)
    assert claimed(full, "Zo\u00eb").barred is None and people_of(full).holds(before.id)
    assert full.find("Zo\u00eb") == before
    done = [(entry.action, entry.actor) for entry in full.entries(before.id, 2)]
    assert done == [("reinstate", "Eve"), ("suspend", "Bob")] and full.audit().sound


def test_a_revocation_is_graver_than_a_suspension(full):
    """Catches: a reinstatement by which a revoked badge counts again; a state by which one is hidden."""
    full.suspend("Ada", "mislaid")
    full.revoke("Ada", "lost")
    barred = claimed(full, "Ada").barred
    assert barred and (barred.code, barred.reason) == ("revoked", "lost")
    for decide in (lambda: full.reinstate("Ada"), lambda: full.suspend("Bo", "again")):
        with pytest.raises(RegistryError, match="revoked already"):
            decide()


def test_a_bundle_says_it_and_is_of_no_other_version(full, tmp_path):
    """Catches: a bundle that takes a suspended badge for valid; one of another version, read by the rules of this."""
    later = tmp_path / "later.bundle"
    full.suspend("Ada", "mislaid")
    full.publish(later, specimen_of, days=7)
    whole = later.read_bytes()
    assert whole.startswith(b"moireid bundle 3 ")
    with Bundle(later) as bundle:
        assert bundle.claimed("Ada").barred == claimed(full, "Ada").barred and bundle.claimed("Zo\u00eb").barred is None
        holder = bundle.holder_of(badge_of("Ada").id)
        assert holder and holder.barred and not People(bundle.holder_of).holds(badge_of("Ada").id)
    later.write_bytes(whole.replace(b"bundle 3 ", b"bundle 4 ", 1))
    with pytest.raises(RegistryError, match="install a newer moireid"):
        Bundle(later)


def test_the_commands_suspend_and_reinstate(path: Path) -> None:
    """Catches: a command that does not reach the registry, or a record that does not show it."""
    with open_registry(url_of(path), create=True) as registry:
        registry.enroll(badge_of("Ada"))

    def said(*words: str, code: int = 0) -> str:
        return run("registry", *words, "--registry", url_of(path), code=code).output

    assert "is suspended since 20" in said("suspend", "Ada", "--reason", "mislaid")
    assert ": mislaid" in said("show", "Ada") and "Ada  suspended 20" in said("list")
    assert "suspended already" in said("suspend", "Ada", "--reason", "x", code=2)
    assert json.loads(said("reinstate", "Ada", "--json"))["suspended_at"] is None
    assert "suspended" not in said("show", "Ada") + said("list")


def test_a_badge_counts_through_its_last_day_and_no_longer(registry, monkeypatch):
    """Catches: a day too much or too little; a date that is stored and never compared."""
    ada = registry.enroll(badge_of("Ada"), expires="2090-05-03")
    assert ada.barred("2090-05-03") is None and ada.barred() is None and claimed(registry, "Ada").barred is None
    barred = ada.barred("2090-05-04")
    assert barred and (barred.code, barred.at) == ("expired", "2090-05-03") and "2090-05-03" in barred.text
    monkeypatch.setattr("moireid.registry.record.utc_now", lambda: "2090-05-04T00:00:00Z")
    assert claimed(registry, "Ada").barred == barred and not people_of(registry).holds(ada.id)
    holder = holder_of(registry, ada.id)
    assert holder and holder.barred == barred
    registry.suspend("Ada", "mislaid")
    suspended = claimed(registry, "Ada").barred
    assert suspended and suspended.code == "suspended"


def test_the_day_stays_as_it_was_issued(registry):
    """Catches: a second enrolment that moves the day, or passes over the one that was asked for."""
    ada = registry.enroll(badge_of("Ada"), expires="2090-05-03")
    assert registry.enroll(badge_of("Ada")) == registry.enroll(badge_of("Ada"), expires="2090-05-03") == ada
    registry.enroll(badge_of("Bo"))
    for name in ("Ada", "Bo"):
        with pytest.raises(RegistryError, match="which stays"):
            registry.enroll(badge_of(name), expires="2091-01-01")
        with pytest.raises(RegistryError, match="which stays"):
            registry.enroll_many([badge_of(name)], expires="2091-01-01")
    registry.enroll_many([badge_of("Cy"), badge_of("Di")], expires="2090-05-03")
    assert [one.expires for one in registry.records()] == ["2090-05-03", None, "2090-05-03", "2090-05-03"]


def test_since_when_a_revoked_badge_is_compromised(full, tmp_path):
    """Catches: a day that is not signed or not shown; one by which older films count again; a day to come."""
    for day in ("2090-01-01", "yesterday", "20260501"):
        with pytest.raises(SpecError, match="day of compromise"):
            full.revoke("Ada", "stolen", day)
    assert full.find("Ada").revoked_at is None
    revoked = full.revoke("Ada", "stolen", "2026-05-01")
    barred = claimed(full, "Ada").barred
    assert barred and (barred.code, barred.since) == ("revoked", "2026-05-01") and "2026-05-01" in barred.text
    full.publish(tmp_path / "people.bundle", specimen_of, days=7)
    with Bundle(tmp_path / "people.bundle") as bundle:
        assert full.find("Ada") == revoked and bundle.claimed("Ada").barred == barred
