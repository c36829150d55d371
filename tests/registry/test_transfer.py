"""Export and import.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import sqlite3

import pytest

from kit.registries import badge_of, state_of, tamper, url_of
from moireid.errors import RegistryError
from moireid.registry import engine, import_registry, open_registry, transfer

# Export.


def test_an_export_is_a_registry_that_can_be_read(full, exported, monkeypatch, tmp_path):
    """Catches: figures lost on the way; a file that only an import can read; something private in it."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "elsewhere"))
    with open_registry(url_of(exported), create=False) as copy:
        assert list(copy.records()) == list(full.records()) and copy.head() == full.head() and copy.audit().sound
        with pytest.raises(RegistryError, match="can only be read here"):
            copy.enroll(badge_of("Di"))


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
        full.export(tmp_path / "out" / "people.sqlite3")
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.usefixtures("machines")
def test_export_is_one_state(url, full, tmp_path, monkeypatch):
    """Catches: records of one moment and a log of another, where somebody enrolls between two tables."""
    if url.startswith("sqlite"):
        url = url.replace("people.sqlite3", "people.sqlite3?timeout=0.05")
    refused, rows_of = [], transfer.pages

    def meanwhile(*query):
        with open_registry(url, create=False) as other:
            try:
                other.enroll(badge_of("Bo", bytes([len(refused), other.count(), 0])))
            except RegistryError as error:
                refused.append(str(error))
        return rows_of(*query)

    monkeypatch.setattr(transfer, "pages", meanwhile)
    full.export(tmp_path / "copy.sqlite3")
    monkeypatch.undo()
    assert import_registry(tmp_path / "copy.sqlite3", url_of(tmp_path / "other.sqlite3")) == 3
    # SQLite lets the writers wait, PostgreSQL lets them write.
    assert all("locked" in text for text in refused) and full.count() + len(refused) == 6


# Import into an empty registry.


@pytest.mark.claim("An export is restored whole, signatures and all")
def test_import_makes_a_copy(url, full, exported, target):
    """Catches: signing anew on import; records without their history."""
    assert import_registry(exported, target) == 3
    assert state_of(target) == state_of(url)
    with open_registry(target, create=False) as copy:
        assert list(copy.records()) == list(full.records()) and copy.audit().sound
        assert copy.fingerprint == full.fingerprint


CHANGES = {
    "name": "UPDATE badges SET name_nfc = 'Eve' WHERE name_nfc = 'Ada'",
    "unrevoked": "UPDATE badges SET revoked_at = NULL, revoked_reason = NULL",
    "record dropped": "DELETE FROM badges WHERE name_nfc = 'Ada'",
    "entry dropped": "DELETE FROM log WHERE seq = 6",
    "end cut": "DELETE FROM log WHERE seq = 6; UPDATE authority SET head_seq = 5",
    "another key": f"UPDATE authority SET public_key = '{'00' * 32}'",
    "no head": "DELETE FROM authority",
    "bytes": "UPDATE log SET actor = X'FF00'",
    "no text": "UPDATE badges SET issued_at = CAST(X'FF00' AS TEXT)",
    "version": "UPDATE schema_version SET version = 99",
    "no table": "DROP TABLE log",
}


@pytest.mark.parametrize("change", [*CHANGES, "cut", "text"])
def test_a_changed_file_changes_nothing(exported, url, tmp_path, change):
    """Catches: a part of the file that is believed; half of it imported; an error of the parser or the driver."""
    with open_registry(url_of(tmp_path / "target.sqlite3"), create=True) as registry:
        before = state_of(registry.shown_url)
        if change in CHANGES:
            with sqlite3.connect(exported) as database:
                database.executescript(CHANGES[change])
        else:
            exported.write_bytes(exported.read_bytes()[:5000] if change == "cut" else b"{}")
        with pytest.raises(RegistryError) as caught:
            import_registry(exported, registry.shown_url)
        assert "\n" not in str(caught.value) and state_of(registry.shown_url) == before


def test_database_that_fails_halfway_keeps_the_old_state(full, exported, target, monkeypatch):
    """Catches: an import in several transactions."""
    copied, done = transfer._copy, []
    monkeypatch.setattr(engine, "CHUNK", 1)

    def failing(there, here):
        copied(there, here)
        # The first copy is that into the temporary folder.
        if done:
            raise RegistryError("the disk is full")
        done.append(True)

    monkeypatch.setattr(transfer, "_copy", failing)
    with pytest.raises(RegistryError, match="disk is full"):
        import_registry(exported, target)
    with pytest.raises(RegistryError, match="is empty; enroll someone first"):
        open_registry(target, create=False)
    monkeypatch.undo()
    assert import_registry(exported, target) == 3


# Import into a registry that holds something.


def test_another_authoritys_export_is_refused(full, exported, target):
    """Catches: records under a key that does not sign them; a registry replaced by another."""
    with open_registry(target, create=True) as other:
        other.enroll(badge_of("Di"))
        before = state_of(target)
        with pytest.raises(RegistryError, match=f"of {full.fingerprint}; import it into an empty registry"):
            import_registry(exported, target)
        assert state_of(target) == before


def test_copy_catches_up_without_the_private_key(url, full, exported, target, monkeypatch, tmp_path):
    """Catches: a copy that can never be brought up to date where the key is not; entries signed anew."""
    import_registry(exported, target)
    full.enroll(badge_of("Di"))
    full.revoke("Ada", "left")
    full.export(exported, overwrite=True)
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "elsewhere"))
    assert import_registry(exported, target) == 4
    assert state_of(target) == state_of(url)
    assert import_registry(exported, target) == 4


@pytest.mark.usefixtures("machines")
def test_copies_that_both_grew_are_forks(url, full, exported, target, tmp_path):
    """Catches: a log that takes in what another signed in the place of its own; half of an import."""
    import_registry(exported, target)
    full.revoke("Ada", "mislaid")
    with open_registry(target, create=False) as copy:
        copy.enroll(badge_of("Ed"))
        full.export(tmp_path / "a.sqlite3")
        copy.export(tmp_path / "b.sqlite3")
        for at, file in ((url, "b.sqlite3"), (target, "a.sqlite3")):
            before = state_of(at)
            with pytest.raises(RegistryError) as caught:
                import_registry(tmp_path / file, at)
            assert caught.value.details["code"] == "forked" and state_of(at) == before


def test_records_go_on_under_a_new_key(full, tmp_path, keys):
    """Catches: a registry whose key was lost that is lost with it; figures, revocations or erased ids left behind."""
    full.erase("Zo\u00eb")
    full.export(tmp_path / "all.sqlite3")
    for key in keys.iterdir():
        key.unlink()
    new = url_of(tmp_path / "new.sqlite3")
    assert import_registry(tmp_path / "all.sqlite3", new, new_key=True) == 2
    with open_registry(new, create=False) as registry:
        assert registry.audit().sound and registry.fingerprint != full.fingerprint and registry.key_here is not None
        same = list(registry.records())
        assert same == list(full.records()) and {one.name for one in same} == {"Ada", "Bo"}
        with pytest.raises(RegistryError, match="was erased"):
            registry.enroll(badge_of("Zo\u00eb"))
    with pytest.raises(RegistryError, match="is not empty"):
        import_registry(tmp_path / "all.sqlite3", new, new_key=True)
