"""Export and import.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import json

import pytest

from kit.registries import badge_of, state_of, tamper, url_of
from moireid.errors import RegistryError
from moireid.registry import Import, import_registry, open_registry, schema

# Export.


def test_export_is_plain_json_with_everything_in_it(full, exported):
    """Catches: a file that only we can read; figures lost on the way; something private in it."""
    document = json.loads(exported.read_text(encoding="utf-8"))
    assert list(document) == [
        *("format", "version", "public_key", "head_seq", "head_hash", "head_signature"),
        *("records", "log"),
    ]
    assert (document["format"], document["version"]) == ("moireid registry", 7)
    assert f"{document['head_seq']}:{document['head_hash']}" == full.head()
    by_id = {record.id: record for record in full.records()}
    assert [item["id"] for item in document["records"]] == sorted(by_id)
    for item in document["records"]:
        record = by_id[item["id"]]
        assert item["badge"] == json.loads(record.badge.to_json())
        assert item["as_built"] == (json.loads(record.as_built) if record.as_built else None)
        times = (item["issued_at"], item["revoked_at"], item["as_built_at"])
        assert times == (record.issued_at, record.revoked_at, record.as_built_at)
        assert (item["name_nfc"], item["revoked_reason"]) == (record.name, record.revoked_reason)
    assert [entry["seq"] for entry in document["log"]] == [1, 2, 3, 4, 5, 6]
    assert "PRIVATE" not in exported.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE badges SET name_nfc = 'Eve'",
        "UPDATE log SET time = 'x' WHERE seq = 4",
        "DELETE FROM log WHERE seq = 6",
        "UPDATE authority SET head_seq = 4",
    ],
)
def test_unsound_registry_is_not_exported(url, full, tmp_path, change):
    """Catches: a backup that no one can restore; half a file."""
    tamper(url, change)
    with pytest.raises(RegistryError, match="tampered with or is damaged"):
        full.export_json(tmp_path / "out" / "people.json")
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.usefixtures("machines")
def test_export_is_one_state(url, full, tmp_path, monkeypatch):
    """Catches: records of one moment and a log of another, where somebody enrolls between two pages."""
    if url.startswith("sqlite"):
        url = url.replace("people.sqlite3", "people.sqlite3?timeout=0.05")
    monkeypatch.setattr(schema, "PAGE", 2)
    monkeypatch.setattr("moireid.registry.export_file.STEP", 1)
    refused = []

    def meanwhile(done: int, total: int | None) -> None:
        with open_registry(url, create=False) as other:
            try:
                other.enroll(badge_of("Bo", bytes([done, 0, 0])))
            except RegistryError as error:
                refused.append(str(error))

    full.export_json(tmp_path / "people.json", progress=meanwhile)
    assert import_registry(tmp_path / "people.json", url_of(tmp_path / "copy.sqlite3")) == Import(3, 0, 0)
    # SQLite lets the writers wait, PostgreSQL lets them write.
    assert all("locked" in text for text in refused) and full.count() + len(refused) == 6


# Import into an empty registry.


@pytest.mark.claim("An export is restored whole, signatures and all")
@pytest.mark.parametrize("prepared", ["absent", "of another key", "awaiting"])
def test_import_makes_a_copy(url, full, exported, target, prepared):
    """Catches: signing anew on import; a registry that must not exist, or must; records without their history."""
    if prepared != "absent":
        open_registry(target, create=True, make_authority=prepared == "of another key").close()
    assert import_registry(exported, target) == Import(3, 0, 0)
    assert state_of(target) == state_of(url)
    with open_registry(target, create=False) as copy:
        assert list(copy.records()) == list(full.records()) and copy.audit().sound
        assert copy.fingerprint == full.fingerprint


# Import into a registry that holds something.


def test_another_authoritys_export_is_refused(full, exported, target):
    """Catches: records under a key that does not sign them; a registry replaced by another."""
    with open_registry(target, create=True) as other:
        other.enroll(badge_of("Di"))
        before = state_of(target)
        with pytest.raises(RegistryError, match=f"of {full.fingerprint}; import it into an empty registry"):
            other.import_json(exported)
        assert state_of(target) == before


def test_copy_catches_up_without_the_private_key(url, full, exported, target, monkeypatch, tmp_path):
    """Catches: a copy that can never be brought up to date where the key is not; entries signed anew."""
    import_registry(exported, target)
    full.enroll(badge_of("Di"))
    full.revoke("Ada", "left")
    full.export_json(exported, overwrite=True)
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "elsewhere"))
    assert import_registry(exported, target) == Import(1, 1, 2)
    assert state_of(target) == state_of(url)
    assert import_registry(exported, target) == Import(0, 0, 4)


@pytest.mark.usefixtures("machines")
def test_copies_that_both_grew_are_forks(url, full, exported, target, tmp_path):
    """Catches: a log that takes in what another signed in the place of its own; half of an import."""
    import_registry(exported, target)
    full.suspend("Ada", "mislaid")
    with open_registry(target, create=False) as copy:
        copy.enroll(badge_of("Ed"))
        full.export_json(tmp_path / "a.json")
        copy.export_json(tmp_path / "b.json")
        for registry, at, file in ((full, url, "b.json"), (copy, target, "a.json")):
            before = state_of(at)
            with pytest.raises(RegistryError) as caught:
                registry.import_json(tmp_path / file)
            assert caught.value.details["code"] == "forked" and state_of(at) == before


def test_records_go_on_under_a_new_key(full, tmp_path, keys):
    """Catches: a registry whose key was lost that is lost with it; figures, revocations or erased ids left behind."""
    full.erase("Zo\u00eb")
    full.export_json(tmp_path / "all.json")
    for key in keys.iterdir():
        key.unlink()
    new = url_of(tmp_path / "new.sqlite3")
    assert import_registry(tmp_path / "all.json", new, new_key=True).added == 2
    with open_registry(new, create=False) as registry:
        assert registry.audit().sound and registry.fingerprint != full.fingerprint and registry.key_here is not None
        same = list(registry.records())
        assert same == list(full.records()) and {one.name for one in same} == {"Ada", "Bo"}
        with pytest.raises(RegistryError, match="was erased"):
            registry.enroll(badge_of("Zo\u00eb"))
    with pytest.raises(RegistryError, match="is not empty"):
        import_registry(tmp_path / "all.json", new, new_key=True)
