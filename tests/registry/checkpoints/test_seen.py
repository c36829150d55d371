"""What was seen of a registry before, and what is refused for it.  Each test says what it catches."""

from __future__ import annotations

import os
import shutil
import sqlite3
import stat
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import pytest

from kit.registries import badge_of, code_of, url_of
from moireid.errors import RegistryError, SpecError
from moireid.registry import open_registry
from moireid.registry.log import Head
from moireid.registry.seen import forget, recall, remember


def test_a_fork_is_refused(path, tmp_path, monkeypatch):
    """Catches: a log that is longer than before, and another one."""
    with open_registry(url_of(path), create=True) as registry:
        shutil.copy(path, path.with_suffix(".old"))
        registry.enroll(badge_of("Ada"))
        registry.standing()
    shutil.copy(path.with_suffix(".old"), path)
    with monkeypatch.context() as elsewhere, open_registry(url_of(path), create=False) as registry:
        elsewhere.setenv("MOIREID_SEEN", str(tmp_path / "of one who saw nothing"))
        registry.enroll(badge_of("Bo"))
        registry.enroll(badge_of("Cy"))
    with open_registry(url_of(path), create=False) as registry:
        assert code_of(registry) == "forked"
        assert [one.code for one in registry.audit().findings] == ["forked"]


@pytest.mark.claim("A registry under another key is refused until it is trusted")
def test_another_key_in_the_same_place_is_refused_until_it_is_trusted(path, tmp_path, monkeypatch):
    """Catches: a registry that was made anew by somebody else; a pin that pins nothing; a trust that lasts one call."""
    with open_registry(url_of(path), create=True) as registry:
        first = registry.standing().fingerprint
    path.rename(path.with_suffix(".own"))
    # Somebody else makes theirs, with a home of their own.
    with monkeypatch.context() as elsewhere:
        elsewhere.setenv("MOIREID_SEEN", str(tmp_path / "theirs"))
        with open_registry(url_of(path), create=True) as registry:
            registry.enroll(badge_of("Ada"))
            other = registry.fingerprint
    with open_registry(url_of(path), create=False) as registry:
        assert code_of(registry) == code_of(registry, first) == "key_replaced"
        assert code_of(registry, ":".join(other.upper()[k : k + 2] for k in range(0, 32, 2))) is None
        assert code_of(registry) is None and code_of(registry, first) == "key_replaced"
        with pytest.raises(SpecError, match="is none"):
            registry.standing("abc")


def test_only_a_later_head_replaces_one(seen):
    """Catches: a read, then a write, between which another program remembers a later one."""
    heads = [Head(number, f"{number:064x}") for number in range(1, 60)]
    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(lambda head: remember("place", "f" * 32, head), reversed(heads)))
    assert recall("place")[1].get("f" * 32) == heads[-1] and recall("place")[0] == "f" * 32
    assert b"place" not in seen.read_bytes().replace(b"places", b"").replace(b"place TEXT", b"").replace(b"place_", b"")
    assert stat.S_IMODE(os.stat(seen).st_mode) == 0o600
    assert forget("f" * 32) and not forget("f" * 32)
    assert recall("place") == (None, {})


def test_where_nothing_can_be_kept_it_is_said(path, tmp_path, monkeypatch):
    """Catches: a read-only home in which nothing can be verified; one that is passed over in silence."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "file" / "seen.sqlite3"))
    with open_registry(url_of(path), create=True) as registry:
        registry.enroll(badge_of("Ada"))
        assert registry.standing().remembered is False
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "other"))
    with open_registry(url_of(path), create=False) as registry:
        assert registry.standing().remembered is True


def test_a_damaged_memory_is_no_way_round(path, seen):
    """Catches: damage that forgets all, in silence."""
    with open_registry(url_of(path), create=True) as registry:
        registry.standing()
        seen.write_bytes(b"not a database, and longer than the header of one would be" * 20)
        with pytest.raises(RegistryError, match="cannot be read"):
            registry.standing()
        seen.write_bytes(b"")
        assert registry.standing().remembered


@pytest.mark.parametrize("number", ["NULL", "9e999", "1.5", "0", "-1", "'1 '"])
def test_a_damaged_number_of_entries_is_named(path, seen, number):
    """Catches: a TypeError; a registry that is called forked, or rolled back, where the memory alone is damaged."""
    with open_registry(url_of(path), create=True) as registry:
        registry.standing()
        with closing(sqlite3.connect(seen)) as database:
            database.executescript(
                "ALTER TABLE heads RENAME TO was; CREATE TABLE heads (fingerprint PRIMARY KEY, seq, hash); "
                f"INSERT INTO heads SELECT fingerprint, {number}, hash FROM was"
            )
        with pytest.raises(RegistryError, match=r"seen of registries before.*is no head of a log.*put that file right"):
            registry.standing()
