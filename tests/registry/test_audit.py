"""The audit: each kind of tampering, and what it is found by.  What cannot be found is pinned here as well."""

from __future__ import annotations

import pytest

from kit.registries import badge_of, rows_of, tamper, url_of
from kit.witnesses import root_of
from moireid.registry import Registry, audit_findings, open_registry
from moireid.registry.log import leaf_of


@pytest.fixture
def ids(registry: Registry) -> dict[str, str]:
    """A registry of five entries: the key, Ada, Bo, figures of Ada, Bo revoked.  Returns the ids by name."""
    ids = {name: registry.enroll(badge_of(name)).id for name in ("Ada", "Bo")}
    registry.store_as_built(ids["Ada"], '{"tilt_rad": 0.01}')
    registry.revoke("Bo", "lost")
    return ids


def found(registry: Registry) -> list[tuple[str, str | None]]:
    """The findings as (code, subject), and that the report agrees with itself."""
    seen = registry.audit()
    assert seen.sound == (not seen.findings) and seen.found == len(seen.findings)
    assert all(finding.text for finding in seen.findings)
    return [(finding.code, finding.subject) for finding in seen.findings]


def test_sound_registry(registry, ids, url):
    """Catches: findings where there are none; counts of something else; a head that is not the last entry."""
    steps = []
    seen = registry.audit(progress=lambda done, total: steps.append((done, total)))
    assert seen.sound and seen.findings == [] and seen.fingerprint == registry.fingerprint
    assert (seen.records, seen.revoked, seen.entries) == (2, 1, 5)
    assert steps == [(7, 7)]
    entries = rows_of(url, "SELECT * FROM log ORDER BY seq")
    assert [entry["action"] for entry in entries] == ["init", "enroll", "enroll", "as_built", "revoke"]
    assert [entry["subject"] for entry in entries[1:]] == [ids["Ada"], ids["Bo"], ids["Ada"], ids["Bo"]]
    leaves = [leaf_of(entry["hash"]) for entry in entries]
    assert seen.head == registry.head() == f"5:{root_of(leaves).hex()}"


RECORDS: list[tuple[str, set[tuple[str, str | None]]]] = [
    ("UPDATE badges SET name_nfc = 'Eve' WHERE name_nfc = 'Ada'", {("record_signature", "Ada")}),
    ("UPDATE badges SET revoked_at = NULL, revoked_reason = NULL WHERE name_nfc = 'Bo'", {("record_signature", "Bo")}),
    ("UPDATE badges SET as_built = NULL", {("record_signature", "Ada")}),
    ("UPDATE badges SET badge = :junk WHERE name_nfc = 'Bo'", {("record_damaged", "Bo")}),
    ("DELETE FROM badges WHERE name_nfc = 'Ada'", {("record_missing", "Ada")}),
    ("DELETE FROM badges", {("record_missing", "Ada"), ("record_missing", "Bo")}),
]
LOG: list[tuple[str, set[tuple[str, str | None]]]] = [
    ("UPDATE log SET time = '2001-01-01T00:00:00Z' WHERE seq = 3", {("entry_hash", "3")}),
    ("UPDATE log SET record_sha256 = 'x' WHERE seq = 5", {("entry_hash", "5"), ("record_stale", "Bo")}),
    ("UPDATE log SET signature = 'x' WHERE seq = 3", {("entry_signature", "3")}),
    ("UPDATE log SET hash = 'x' WHERE seq = 3", {("entry_hash", "3"), ("head_hash", None)}),
    (
        "UPDATE log SET seq = 9 WHERE seq = 3",
        {("entry_missing", "4"), ("entry_missing", "9"), ("log_longer", None), ("record_stale", "Bo")},
    ),
    ("DELETE FROM log WHERE seq = 4", {("entry_missing", "5"), ("record_stale", "Ada")}),
    ("DELETE FROM log", {("log_cut", None), ("record_unlogged", "Ada"), ("record_unlogged", "Bo")}),
    ("DELETE FROM log WHERE seq = 5", {("log_cut", None), ("record_stale", "Bo")}),
    ("UPDATE authority SET head_hash = 'x'", {("head_signature", None)}),
    ("UPDATE authority SET head_signature = ''", {("head_signature", None)}),
]


@pytest.mark.slow
@pytest.mark.parametrize(("change", "codes"), RECORDS + LOG, ids=lambda case: case if isinstance(case, str) else "")
def test_each_kind_of_tampering_is_found(url, registry, ids, change, codes):
    """Catches: a part that is not checked; one fault that buries the others, or breeds more."""
    assert tamper(url, change, junk=b"junk", zeros="00" * 32) >= 1
    expected = {(code, ids.get(str(subject), subject)) for code, subject in codes}
    assert set(found(registry)) == expected


def test_public_key_put_in_another_ones_place_is_found(url, registry, ids, tmp_path):
    """Catches: a key that nothing binds to the log."""
    with open_registry(url_of(tmp_path / "eve.sqlite3"), create=True) as other:
        forged = other._ledger.authority.public_hex
    tamper(url, "UPDATE authority SET public_key = :key", key=forged)
    with open_registry(url, create=False) as opened:
        codes = [code for code, _ in found(opened)]
    assert codes == ["entry_signature"] * 5 + ["head_signature"] + ["record_signature"] * 2
    # The one that was open goes on with the key that it knows, and reports it.
    assert found(registry) == [("public_key", None)]


def test_findings_are_counted_beyond_those_kept(url, registry, monkeypatch):
    """Catches: a list that grows with the damage."""
    registry.enroll_many(badge_of("Ada", bytes([k, 0, 0])) for k in range(6))
    tamper(url, "UPDATE badges SET name_nfc = 'Eve'")
    monkeypatch.setattr(audit_findings, "KEPT", 4)
    seen = registry.audit()
    assert (len(seen.findings), seen.found, seen.sound) == (4, 6, False)
