"""The authority's key changed: who follows, and who must not.  Each test says what it catches."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from sqlalchemy import create_engine, select, text, update

from kit.registries import badge_of, code_of
from moireid.cli.main import moireid
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import import_registry, open_registry
from moireid.registry.bundle.held import Bundle
from moireid.registry.keys import ENTRY, Signer, key_of, new_key
from moireid.registry.log import Head, entry_hash, head_row, leaf_of, rotation_row
from moireid.registry.merkle import Tree
from moireid.registry.schema import authority, log
from moireid.registry.seen import forget


def filled(where: Path | str) -> str:
    url = where if isinstance(where, str) else f"sqlite:///{where}"
    with open_registry(url, create=True) as registry:
        registry.enroll_many([badge_of("Ada"), badge_of("Bo")])
        registry.revoke("Bo", "lost")
    return url


def codes(url: str, **more: object) -> set[str]:
    with open_registry(url, create=False) as registry:
        return {one.code for one in registry.audit(**more).findings}


def stored(url: str, statement: str, **values: object) -> None:
    with open_registry(url, create=False) as registry, registry._ledger.engine.begin() as connection:
        connection.execute(text(statement), values)


def test_the_chain_goes_on_through_two_changes(url: str, keys: Path) -> None:
    """Catches: records or entries that no key fits any more; an old key that still counts; a checkpoint of before that
    is called another authority's; a new key that is not kept.
    """
    filled(url)
    with open_registry(url, create=False) as registry:
        before, first = registry.checkpoint()[0], registry.fingerprint
        assert registry.rotate_key() == 2
        second = registry.fingerprint
        assert first != second
        middle = registry.checkpoint()[0]
        registry.enroll(badge_of("Cy"))
        # The old key is needed no more.
        (keys / f"{first}.pem").unlink()
        registry.rotate_key()
        last = registry.fingerprint
        registry.revoke("Cy", "lost too")
        found = registry.audit(since=[before, middle, registry.checkpoint([before, middle])[0]])
        assert found.sound and found.fingerprint == last and found.entries == 8
        assert [one.name for one in registry.records()] == ["Ada", "Bo", "Cy"]
        assert [one.old.fingerprint for one in registry._ledger.rotations()] == [first, second]
    assert {one.stem for one in keys.iterdir()} == {second, last}


def test_who_trusted_the_old_key_follows_and_notices_a_step_back(path: Path, tmp_path: Path) -> None:
    """Catches: a proven change taken for a replaced key; a pinned old fingerprint that lets an older file pass."""
    url = filled(path)
    with open_registry(url, create=False) as registry:
        old = registry.standing().fingerprint
    shutil.copy(path, tmp_path / "before.sqlite3")
    with open_registry(url, create=False) as registry:
        registry.rotate_key()
    for trust in (None, old, None, old):
        with open_registry(url, create=False) as registry:
            assert registry.standing(trust).fingerprint == registry.fingerprint != old
    shutil.copy(tmp_path / "before.sqlite3", path)
    for trust, code in ((None, "key_replaced"), (old, "rolled_back")):
        with open_registry(url, create=False) as registry, pytest.raises(RegistryError) as caught:
            registry.standing(trust)
        assert caught.value.details["code"] == code


def taken_over(path: Path, key: Signer, to: Signer | None = None) -> str:
    """The registry's file as a thief of its old key goes on with it: its one change of key is hidden."""
    with closing(sqlite3.connect(path)) as database, database:
        (size,) = database.execute("SELECT head_seq FROM authority").fetchone()
        database.execute("UPDATE log SET subject = 'gone' WHERE action = 'rotate'")
        if to is not None:
            row = rotation_row(key, to, size, "00" * 32)
            places = ", ".join("?" * len(row))
            database.execute(f"INSERT INTO log ({', '.join(row)}) VALUES ({places})", list(row.values()))
        database.execute("DELETE FROM badges")
    last, engine = to or key, create_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        tree = Tree(leaf_of(hash) for hash in connection.scalars(select(log.c.hash).order_by(log.c.seq)))
        values = {"public_key": last.authority.public_hex} | head_row(last, Head(tree.size, tree.root().hex()))
        connection.execute(update(authority).values(values))
    engine.dispose()
    with open_registry(f"sqlite:///{path}", create=False) as registry:
        registry.enroll(badge_of("Queen"))
    return f"sqlite:///{path}"


def refused(url: str, trust: str | None = None) -> str | None:
    with open_registry(url, create=False) as registry:
        return code_of(registry, trust)


@pytest.mark.claim("A key that was given up counts no more for who saw the change")
def test_a_key_that_was_given_up_counts_no_more(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a stolen old key by which the log goes on, or goes to the thief, for those who saw the true change; a
    true registry that is refused once the thief was here; a thief that came first and stays for ever.
    """
    url = filled(path)
    with open_registry(url, create=False) as registry:
        old, key = registry.fingerprint, key_of(registry._ledger.authority)
        registry.rotate_key()
        new = registry.fingerprint
    thief, _ = new_key()
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "thief"))
    goes_on = taken_over(Path(shutil.copy(path, tmp_path / "on.sqlite3")), key)
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "thief's second"))
    turned = taken_over(Path(shutil.copy(path, tmp_path / "turned.sqlite3")), key, thief)
    # Who saw the change, by whichever way, refuses both at a place that is new to them.
    for number, first in enumerate((None, old, new)):
        monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / f"seen{number}"))
        assert refused(url, first) is None
        for trust in (None, old):
            assert refused(goes_on, trust) == "key_given_up" and refused(turned, trust) == "two_successors"
            assert refused(url, trust or new) is None
        assert refused(turned, new) == "key_replaced"
    # Who saw the thief's first cannot know, until the user names the fingerprint.
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "late"))
    assert refused(turned, old) is None and refused(url, old) == "two_successors"
    assert refused(url, new) is None and refused(url, old) is None and refused(turned, old) == "two_successors"
    assert forget(old) and refused(goes_on, old) is None


def test_a_bundle_of_a_key_that_was_given_up_is_refused(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: what was seen of a registry that does not count for bundles, and the other way round."""
    url = filled(path)
    with open_registry(url, create=False) as registry:
        old, key = registry.fingerprint, key_of(registry._ledger.authority)
        registry.publish(tmp_path / "before", specimen_of, days=1)
        registry.rotate_key()
        registry.publish(tmp_path / "true", specimen_of, days=1)
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "verifier"))
    goes_on = taken_over(Path(shutil.copy(path, tmp_path / "on.sqlite3")), key)
    assert forget(old)
    with Bundle(tmp_path / "true"):
        pass
    assert refused(goes_on) == refused(goes_on, old) == "key_given_up"
    for trust in (None, old):
        with pytest.raises(RegistryError, match="was given up for") as caught:
            Bundle(tmp_path / "before", trust)
        assert caught.value.details["code"] == "key_given_up"


def test_a_change_that_both_keys_did_not_sign_is_none(path: Path, tmp_path: Path) -> None:
    """Catches: a new key that the old one never signed for; one that never signed itself; a chain with a gap."""
    url = filled(path)
    with open_registry(url, create=False) as registry:
        old = registry.standing().fingerprint
        registry.rotate_key()
        row = dict(registry._ledger.rows(text("SELECT * FROM log WHERE action = 'rotate'"))[0]._mapping)
    thief, other = Signer(Ed25519PrivateKey.generate()), Signer(Ed25519PrivateKey.generate())
    half = row["signature"][:128], row["signature"][128:]
    content = entry_hash(row).encode()
    shutil.copy(path, tmp_path / "right.sqlite3")
    for signature in (
        thief.sign(ENTRY, content) + half[1],
        half[0] + thief.sign(ENTRY, content),
        half[0] + half[0],
        half[0],
        "",
    ):
        shutil.copy(tmp_path / "right.sqlite3", path)
        stored(url, "UPDATE log SET signature = :new WHERE action = 'rotate'", new=signature)
        assert "rotation" in codes(url)
        with (
            open_registry(url, create=False) as registry,
            pytest.raises(RegistryError, match=r"tampered with|replaced"),
        ):
            registry.standing(old)
    shutil.copy(tmp_path / "right.sqlite3", path)
    subject = f"key:{thief.authority.public_hex}:{other.authority.public_hex}"
    stored(url, "UPDATE log SET subject = :new WHERE action = 'rotate'", new=subject)
    assert codes(url)
    with open_registry(url, create=False) as registry, pytest.raises(RegistryError, match="tampered with"):
        registry.standing(old)
    shutil.copy(tmp_path / "right.sqlite3", path)
    stored(url, "UPDATE log SET action = 'revoke' WHERE action = 'rotate'")
    assert codes(url)


def test_a_registry_made_anew_under_another_key_is_no_change_of_it(path: Path, tmp_path: Path) -> None:
    """Catches: any key that names another as its forerunner."""
    url, anew = filled(path), filled(tmp_path / "anew.sqlite3")
    with open_registry(url, create=False) as registry:
        old = registry.standing().fingerprint
    with open_registry(anew, create=False) as registry:
        registry.rotate_key()
    shutil.copy(tmp_path / "anew.sqlite3", path)
    for trust in (None, old):
        with open_registry(url, create=False) as registry, pytest.raises(RegistryError, match="its key was replaced"):
            registry.standing(trust)


def test_a_bundle_proves_the_change_offline(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: verifiers who trust the printed fingerprint and are shut out; a proof that is not looked at."""
    url = filled(path)
    with open_registry(url, create=False) as registry:
        old = registry.fingerprint
        registry.publish(tmp_path / "bundle", specimen_of, days=1)
    with Bundle(tmp_path / "bundle") as bundle:
        assert bundle.standing.fingerprint == old
    with open_registry(url, create=False) as registry:
        registry.rotate_key()
        registry.publish(tmp_path / "bundle", specimen_of, days=1, overwrite=True)
        new = registry.fingerprint
    for trust in (None, old, new):
        with Bundle(tmp_path / "bundle", trust) as bundle:
            assert bundle.standing.fingerprint == new and bundle.claimed("Ada").badge.name == "Ada"
    with pytest.raises(RegistryError, match="its key was replaced"):
        Bundle(tmp_path / "bundle", "00" * 16)
    monkeypatch.setattr("moireid.registry.bundle.bundle_file.BundleContent.hash_at", lambda self, seq: bytes(32))
    with pytest.raises(RegistryError):
        Bundle(tmp_path / "bundle", old)


@pytest.mark.usefixtures("machines")
def test_a_copy_follows_by_import_and_a_copy_that_went_its_own_way_does_not(path: Path, tmp_path: Path) -> None:
    """Catches: an export of a changed key that no one can read in; entries of a copy that are lost without a word."""
    url, copy = filled(path), f"sqlite:///{tmp_path}/copy.sqlite3"
    astray = f"sqlite:///{tmp_path}/astray.sqlite3"
    with open_registry(url, create=False) as registry:
        registry.export_json(tmp_path / "before.json")
    for other in (copy, astray):
        import_registry(tmp_path / "before.json", other)
    with open_registry(astray, create=False) as registry:
        registry.revoke("Ada", "here alone")
    with open_registry(url, create=False) as registry:
        registry.rotate_key()
        registry.revoke("Ada", "stolen")
        registry.enroll(badge_of("Cy"))
        registry.export_json(tmp_path / "after.json")
    done = import_registry(tmp_path / "after.json", copy)
    assert (done.added, done.changed, done.unchanged) == (1, 1, 1)
    with open_registry(copy, create=False) as registry:
        assert registry.audit().sound and registry.find("Ada").revoked_reason == "stolen"
    with pytest.raises(RegistryError, match="holds log entries that this export lacks"):
        import_registry(tmp_path / "after.json", astray)
    assert codes(astray) == set()


def test_the_command_says_what_to_do_next(path: Path, keys: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a command that says nothing of what to do next, or that works without the old key."""
    url = filled(path)
    done = CliRunner().invoke(moireid, ["registry", "rotate-key", "--registry", url, "--json"])
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert document["records"] == 2 and Path(document["key"]).parent == keys and document["head"].startswith("5:")
    said = CliRunner().invoke(moireid, ["registry", "rotate-key", "--registry", url])
    assert f"no longer by {document['fingerprint']}" in said.stdout and "make a checkpoint" in said.stdout
    monkeypatch.setenv("MOIREID_KEYS", str(keys / "none"))
    failed = CliRunner().invoke(moireid, ["registry", "rotate-key", "--registry", url])
    assert failed.exit_code == 2 and "can only be read here" in failed.stderr and codes(url) == set()


def test_a_change_that_fails_changes_nothing(path: Path, keys: Path) -> None:
    """Catches: half of the records under the new key; a key left over; a damaged record that is made good."""
    url = filled(path)
    stored(url, "UPDATE badges SET revoked_at = NULL, revoked_reason = NULL WHERE name_nfc = 'Bo'")
    before, held = codes(url), sorted(keys.iterdir())
    with open_registry(url, create=False) as registry, pytest.raises(RegistryError, match="tampered with"):
        registry.rotate_key()
    assert codes(url) == before == {"record_signature"} and sorted(keys.iterdir()) == held
