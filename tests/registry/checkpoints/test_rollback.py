"""A registry that is put back to an earlier state is noticed by every reader.  Each test says what it catches."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from kit.registries import badge_of, code_of, run, url_of
from moireid.errors import RegistryError
from moireid.registry import Registry, claimed, holder_of, open_registry

#: A program that revokes, says so, and is killed before it closes anything.
KILLED = """
import os, shutil, signal, sys
from moireid.registry import open_registry
path, url = sys.argv[1:]
with open_registry(url, create=False) as registry:
    shutil.copy(path, path + ".old")
    print(registry.revoke("Ada", "lost").revoked_at, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""

READERS: dict[str, Callable[[Registry], object]] = {
    "find": lambda registry: registry.find("Ada"),
    "named": lambda registry: registry.named("Ada"),
    "by_id": lambda registry: registry.by_id(str(badge_of("Ada").id)),
    "records": lambda registry: list(registry.records()),
    "search": lambda registry: registry.search("", 5),
    "layouts": lambda registry: registry.layouts(),
    "count": lambda registry: registry.count(),
    "entries": lambda registry: registry.entries(),
    "look_alikes": lambda registry: registry.look_alikes(["Ada"]),
    "erased_at": lambda registry: registry.erased_at("00" * 8),
    "head": lambda registry: registry.head(),
    "claimed": lambda registry: claimed(registry, "Ada"),
    "holder_of": lambda registry: holder_of(registry, badge_of("Ada").id),
    "holds": lambda registry: holder_of(registry, str(badge_of("Ada").id)),
    "standing": lambda registry: registry.standing(),
    "checkpoint": lambda registry: registry.checkpoint(),
    "enroll": lambda registry: registry.enroll(badge_of("Bo")),
    "enroll_many": lambda registry: registry.enroll_many([badge_of("Bo")]),
}


@pytest.fixture
def put_back(path: Path) -> Path:
    """A registry whose program was killed after it had revoked Ada's badge, and its file of before in its place."""
    with open_registry(url_of(path), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(path), url_of(path)], stdout=subprocess.PIPE, text=True, check=False
    )
    assert done.returncode == -signal.SIGKILL and done.stdout.startswith("20")
    shutil.copy(path, f"{path}.new")
    shutil.copy(f"{path}.old", path)
    return path


@pytest.mark.claim("A registry that was put back is refused by who saw the later state")
@pytest.mark.parametrize("reader", READERS)
def test_a_state_of_before_a_kill_is_refused_by_every_reader(put_back: Path, reader: str) -> None:
    """Catches: a head that is remembered at a clean close only; a method that shows the state of before."""
    with open_registry(url_of(put_back), create=False) as registry:
        with pytest.raises(RegistryError, match="rolled back") as caught:
            READERS[reader](registry)
        assert caught.value.details["code"] == "rolled_back"
    shutil.copy(f"{put_back}.new", put_back)
    with open_registry(url_of(put_back), create=False) as registry:
        READERS[reader](registry)


def test_the_audit_names_a_rollback(put_back: Path) -> None:
    """Catches: an audit that calls it sound without a checkpoint at hand; one that refuses to look at it at all."""
    done = run("registry", "audit", "--json", "--registry", url_of(put_back), code=1)
    found = json.loads(done.stdout)
    assert found["sound"] is False and [one["code"] for one in found["findings"]] == ["rolled_back"]
    assert found["entries"] == 2 and found["found"] == 1
    assert "entry 3" in found["findings"][0]["text"]


def test_an_older_state_is_accepted_in_one_way_that_says_what_is_lost(put_back: Path) -> None:
    """Catches: a backup that was restored on purpose and can never be used; a way that hides what it costs."""
    with open_registry(url_of(put_back), create=False) as registry:
        fingerprint = registry.fingerprint
        with pytest.raises(RegistryError, match=f"entry 3 .*forget {fingerprint}"):
            registry.count()
    done = run("registry", "forget", fingerprint)
    assert "3 entries" in done.stdout and "revocation" in done.stdout
    assert "Ada" in run("registry", "list", "--registry", url_of(put_back)).stdout
    # From now on the true state is another one.
    run("registry", "revoke", "Ada", "--reason", "found", "--registry", url_of(put_back))
    shutil.copy(f"{put_back}.new", put_back)
    assert "forked" in run("registry", "list", "--registry", url_of(put_back), code=2).stderr


def test_a_log_that_keeps_only_the_seen_entry_is_refused(path: Path) -> None:
    """Catches: a comparison of the one entry that was seen, after which anything may follow: the log has a gap."""
    import sqlite3

    with open_registry(url_of(path), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    with open_registry(url_of(path), create=False) as registry:
        assert code_of(registry) is None
        seen = Path(f"{path}.seen")
    shutil.copy(path.parent.parent / "seen.sqlite3", seen)
    with open_registry(url_of(path), create=False) as registry:
        registry.revoke("Ada", "lost")
        registry.enroll(badge_of("Bo"))
    shutil.copy(seen, path.parent.parent / "seen.sqlite3")
    with sqlite3.connect(path) as tampered:
        tampered.execute("DELETE FROM log WHERE seq = 3")
    with (
        open_registry(url_of(path), create=False) as registry,
        pytest.raises(RegistryError, match="not those of its signed head"),
    ):
        registry.count()


def test_an_import_of_an_older_state_says_so(put_back: Path, tmp_path: Path) -> None:
    """Catches: a backup read in without a word, of which every reader then says that it was rolled back."""
    run("registry", "forget", open_registry(url_of(put_back), create=False).fingerprint)
    run("registry", "export", tmp_path / "old.sqlite3", "--registry", url_of(put_back))
    shutil.copy(f"{put_back}.new", put_back)
    run("registry", "list", "--registry", url_of(put_back))
    other = url_of(tmp_path / "other.sqlite3")
    done = run("registry", "import", tmp_path / "old.sqlite3", "--registry", other)
    assert "ends at log entry 2" in done.stderr and "forget" in done.stderr
    assert "rolled back" in run("registry", "list", "--registry", other, code=2).stderr
