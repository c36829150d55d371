"""A registry, a bundle, a proof and an export that were written before the tree (tests/data/registry).

Their entries contain the hash of the entry before, and their heads are the hash of the last one.
Each test says what it catches.
"""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest
from sqlalchemy import event

from kit.registries import badge_of, code_of, rows_of, tamper, url_of
from kit.witnesses import root_of
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import claimed, import_registry, open_registry
from moireid.registry.bundle.held import Bundle
from moireid.registry.checkpoints.proof import check_proof
from moireid.registry.checkpoints.sources import checkpoints_from
from moireid.registry.log import leaf_of

DATA = Path(__file__).parents[1] / "data" / "registry"
#: Of the registry's present key, and of the one before it.
FINGERPRINT, FORMER = "195014f7a2f4e437f1e5d05359ca4f51", "cc8d34425fd30a7fb9dbe9879f626aea"
#: Its head, and an earlier one, as users may have noted them.
HEAD = "9:615eeb7118c9bad49890f5d7e4bb6545d72ac85d51da149e6379a8e8e32c2b46"
EARLY = "6:f5b6736eaf3c6e204fbf35ee7389f5e77f6b9a3911695b832030722fa22e425b"


@pytest.fixture
def old(path: Path, keys: Path) -> str:
    """The registry, with its key."""
    keys.mkdir(parents=True)
    shutil.copy(DATA / "version5.key.pem", keys / f"{FINGERPRINT}.pem")
    shutil.copy(DATA / "version5.sqlite3", path)
    return url_of(path)


def root_over(url: str, size: int) -> str:
    """The head over the first entries."""
    hashes = [row["hash"] for row in rows_of(url, f"SELECT hash FROM log WHERE seq <= {size} ORDER BY seq")]
    return f"{size}:{root_of([leaf_of(one) for one in hashes]).hex()}"


def test_it_is_read_as_it_is(old: str, path: Path) -> None:
    """Catches: a reader that writes: then neither a read-only file nor an older program could be used any more."""
    before = path.read_bytes()
    path.chmod(0o400)
    with open_registry(old, create=False) as registry:
        assert [one.name for one in registry.records()] == ["Ada", "Bo", "Zo\u00eb"]
        assert claimed(registry, "Bo").barred.reason == "lost on the train"
        assert claimed(registry, "Zo\u00eb").barred is None
        assert registry.head() == HEAD and registry.standing(FORMER).head == HEAD
        for head in (None, EARLY, HEAD, root_over(old, 6), root_over(old, 9)):
            assert registry.audit(head, since=checkpoints_from(str(DATA / "version5.checkpoint"))).sound
        assert [one.code for one in registry.audit(EARLY[:-1] + "0").findings] == ["head_expected"]
        older = checkpoints_from(str(DATA / "version5.checkpoint"))
        made, proofs = registry.checkpoint(older)
        assert f"{made.size}:{made.root.hex()}" == root_over(old, 9) and proofs[0][0] == 6
        assert check_proof(registry.prove(registry.find("Bo")), "it").entry == 8
    assert path.read_bytes() == before


def test_the_first_write_signs_the_root(old: str, tmp_path: Path) -> None:
    """Catches: old entries, hashes or signatures that change; nodes that are missing; a head or a checkpoint of before
    that counts no more; a second kind of head that goes on to be written.
    """
    before = rows_of(old, "SELECT * FROM log ORDER BY seq")
    with open_registry(old, create=False, actor="Carol") as registry:
        registry.enroll(badge_of("Di"))
        assert registry.head() == root_over(old, 10)
        assert rows_of(old, "SELECT version FROM schema_version") == [{"version": 6}]
        assert len(rows_of(old, "SELECT * FROM nodes")) == 5 + 2 + 1
        since = checkpoints_from(str(DATA / "version5.checkpoint"))
        for head in (EARLY, HEAD, root_over(old, 9), registry.head()):
            assert registry.audit(head, since=since).sound
        assert registry.checkpoint(since)[1][0][0] == 6
        assert check_proof(registry.prove(registry.find("Bo")), "old entry").entry == 8
        assert check_proof(registry.prove(registry.find("Di")), "new entry").entry == 10
        new = registry.rotate_key().new
        registry.revoke("Zo\u00eb", "stolen")
        assert registry.audit(HEAD, since=since).actors == {"Alice": 7, "Bob": 2, "Carol": 3}
        registry.export_json(tmp_path / "out.json")
        registry.publish(tmp_path / "bundle", specimen_of, days=1)
    assert rows_of(old, "SELECT * FROM log ORDER BY seq")[:9] == before
    with Bundle(tmp_path / "bundle", FORMER) as bundle:
        assert bundle.standing.fingerprint == new and bundle.claimed("Zo\u00eb").barred is not None
    copy = url_of(tmp_path / "copy.sqlite3")
    assert import_registry(tmp_path / "out.json", copy).added == 4
    with open_registry(copy, create=False) as registry:
        assert registry.audit(HEAD).sound and registry.head() == root_over(old, 12)


def test_a_first_write_that_fails_leaves_all_as_it_was(old: str, path: Path) -> None:
    """Catches: a table of nodes, or a version, that an older program does not know, without the write."""
    before = path.read_bytes()
    with open_registry(old, create=False) as registry:

        def broken(connection: object, cursor: object, statement: str, *_: object) -> None:
            if statement.startswith("UPDATE authority"):
                raise KeyboardInterrupt

        event.listen(registry._ledger.engine, "before_cursor_execute", broken)
        with pytest.raises(KeyboardInterrupt):
            registry.enroll(badge_of("Di"))
    assert path.read_bytes() == before


def test_a_write_that_changes_nothing_signs_nothing(old: str) -> None:
    """Catches: a registry that an older program cannot open any more after nothing was written."""
    with open_registry(old, create=False) as registry:
        assert registry.enroll(badge_of("Ada")).name == "Ada"
        assert registry.enroll_many([badge_of("Ada"), badge_of("Zo\u00eb")]).unchanged == 2
    assert rows_of(old, "SELECT version FROM schema_version") == [{"version": 5}]


def test_what_was_seen_of_it_counts_after_the_first_root(old: str, path: Path) -> None:
    """Catches: an update by which a rollback or a fork passes, as the head that was seen is of another kind."""
    with open_registry(old, create=False) as registry:
        assert code_of(registry) is None
    seen = path.parent.parent / "seen.sqlite3"
    memory = seen.read_bytes()
    with open_registry(old, create=False) as registry:
        registry.enroll(badge_of("Di"))
    written = path.read_bytes()
    shutil.copy(DATA / "version5.sqlite3", path)
    with open_registry(old, create=False) as registry:
        assert code_of(registry) == "rolled_back"
    # Another user saw the old head alone, and now the first root.
    path.write_bytes(written)
    seen.write_bytes(memory)
    with open_registry(old, create=False) as registry:
        assert code_of(registry) is None
    # The head that was remembered is another one at that size.
    path.write_bytes(written)
    seen.write_bytes(memory)
    with sqlite3.connect(seen) as raw:
        raw.execute("UPDATE heads SET hash = ?", ("00" * 32,))
    with open_registry(old, create=False) as registry:
        assert code_of(registry) == "forked"


@pytest.mark.parametrize("change", ["subject = 'ff'", "previous = :zeros", "time = '2001-01-01T00:00:00Z'"])
def test_nothing_is_signed_over_old_entries_that_do_not_chain(old: str, change: str) -> None:
    """Catches: a first root that makes good what was changed before it."""
    assert tamper(old, f"UPDATE log SET {change} WHERE seq = 5", zeros="00" * 32) == 1
    before = rows_of(old, "SELECT * FROM log") + rows_of(old, "SELECT * FROM authority")
    with open_registry(old, create=False) as registry:
        assert registry.audit().findings[0].subject == "5"
        for write in (lambda: registry.enroll(badge_of("Di")), registry.checkpoint, registry.rotate_key):
            with pytest.raises(RegistryError, match="log entry 5"):
                write()
    assert rows_of(old, "SELECT * FROM log") + rows_of(old, "SELECT * FROM authority") == before


def test_an_entry_is_no_head_because_its_hash_was_one_before(old: str) -> None:
    """Catches: the hash of a new entry, which contains no other, taken for a head."""
    with open_registry(old, create=False) as registry:
        registry.enroll(badge_of("Di"))
        last = rows_of(old, "SELECT hash FROM log WHERE seq = 10")[0]["hash"]
        assert [one.code for one in registry.audit(f"10:{last}").findings] == ["head_expected"]


def test_files_of_before_are_read(old: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a bundle, a proof, a checkpoint or an export of before that counts no more; a newer bundle that is
    called a fork of an older one, or an older one of a newer one, as their heads are of different kinds.
    """
    proof = check_proof((DATA / "version5.proof").read_text(encoding="utf-8"), "it")
    assert (proof.entry, proof.record.revoked_reason) == (8, "lost on the train")
    with Bundle(DATA / "version5.bundle", FORMER) as bundle:
        assert bundle.standing.head == HEAD and bundle.claimed("Bo").barred is not None
    with open_registry(old, create=False) as registry:
        registry.publish(tmp_path / "same", specimen_of, days=1)
        registry.enroll(badge_of("Di"))
        registry.publish(tmp_path / "newer", specimen_of, days=1)
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "another person's"))
    for name in (DATA / "version5.bundle", tmp_path / "same", DATA / "version5.bundle", tmp_path / "newer"):
        with Bundle(name, FINGERPRINT):
            pass
    with pytest.raises(RegistryError, match="rolled back"):
        Bundle(DATA / "version5.bundle", FINGERPRINT)
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "a mirror's reader"))
    for name in (tmp_path / "same", DATA / "version5.bundle"):
        with Bundle(name, FINGERPRINT):
            pass
    copy = url_of(tmp_path / "copy.sqlite3")
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "third"))
    assert import_registry(DATA / "export4.json", copy).added == 3
    with open_registry(copy, create=False) as registry:
        assert registry.head() == HEAD and registry.audit(EARLY).sound
        registry.enroll(badge_of("Flo"))
        assert registry.audit(HEAD).sound and registry.head() == root_over(copy, 10)


def test_a_copy_of_before_takes_in_what_was_written_since(old: str, tmp_path: Path) -> None:
    """Catches: a log that is a part of the other one, and is called another one, as it has no nodes yet."""
    copy = tmp_path / "copy.sqlite3"
    shutil.copy(DATA / "version5.sqlite3", copy)
    with open_registry(old, create=False) as registry:
        registry.enroll(badge_of("Di"))
        registry.export_json(tmp_path / "newer.json")
    with open_registry(url_of(copy), create=False) as registry:
        assert registry.import_json(tmp_path / "newer.json").added == 1
        assert registry.audit(HEAD).sound and registry.head() == root_over(old, 10)
        assert registry.import_json(DATA / "export4.json").unchanged == 3
