"""Several processes at once.  Beside each test stands the wrong implementation it would catch."""

from __future__ import annotations

import multiprocessing
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from kit.registries import badge_of, url_of
from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError
from moireid.registry import batch, open_registry


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_registries_made_at_once(kind, tmp_path, keys, request):
    """Catches: a transaction that looks first and takes the write lock later, which SQLite refuses without any wait;
    two authorities; a key left over from the maker that came second."""
    for attempt in range(6):
        sqlite = kind == "sqlite"
        url = url_of(tmp_path / f"{attempt}.sqlite3") if sqlite else request.getfixturevalue("postgres").fresh()
        with ThreadPoolExecutor(8) as pool:
            for registry in pool.map(lambda _, url=url: open_registry(url, create=True), range(8)):
                registry.close()
        with open_registry(url, create=False) as registry:
            assert registry.count() == 0 and registry.audit().sound
            assert registry.key_path.exists()
        assert len(list(keys.iterdir())) == attempt + 1


def _enroll_many(url: str, badges: list[str], ready, results) -> None:
    """What each of the processes does: open, and enroll all, telling how each went."""
    ready.wait()
    outcomes = []
    with open_registry(url, create=True) as registry:
        for text in badges:
            try:
                outcomes.append(registry.enroll(badge_from_json(text)).name)
            except RegistryError as error:
                outcomes.append(f"RegistryError: {error}")
    results.put(outcomes)


def _run_together(url: str, lists: list[list[str]]) -> list[list[str]]:
    context = multiprocessing.get_context("spawn")
    ready, results = context.Barrier(len(lists)), context.Queue()
    processes = [context.Process(target=_enroll_many, args=(url, badges, ready, results)) for badges in lists]
    for process in processes:
        process.start()
    outcomes = [results.get(timeout=120) for _ in processes]
    for process in processes:
        process.join(timeout=30)
        assert process.exitcode == 0
    return outcomes


def _renamed(badge: Badge, name: str, number: int) -> str:
    """The JSON of `badge` with another name and id: the registry reads no code, and designing takes longer."""
    return replace(badge, name=name, id=number.to_bytes(3, "big").hex()).to_json()


def test_two_processes_lose_nothing(url):
    """Catches: 'database is locked', tables made twice, a row or a log entry lost to a read-modify-write."""
    badge = badge_of("Ada")
    lists = [[_renamed(badge, f"{who} {k:02}", 1000 * p + k) for k in range(50)] for p, who in enumerate(("Al", "Bo"))]
    outcomes = _run_together(url, lists)
    expected = [f"{who} {k:02}" for who in ("Al", "Bo") for k in range(50)]
    assert sorted(name for outcome in outcomes for name in outcome) == expected
    with open_registry(url, create=False) as registry:
        assert [record.name for record in registry.records()] == expected
        seen = registry.audit()
    assert seen.sound and (seen.records, seen.entries) == (100, 101)


def test_two_processes_that_want_the_same_ids(url):
    """Catches: looking before writing, by which both would be told that the id is theirs."""
    badge = badge_of("Ada")
    lists = [[_renamed(badge, who, k) for k in range(30)] for who in ("Al", "Bo")]
    outcomes = _run_together(url, lists)
    with open_registry(url, create=False) as registry:
        assert registry.audit().sound
        holders = {int(record.id, 16): record.name for record in registry.records()}
    assert sorted(holders) == list(range(30))
    for outcome in outcomes:
        (who,) = {told for told in outcome if told in ("Al", "Bo")} or {""}
        for k, told in enumerate(outcome):
            assert (told == who) == (holders[k] == who)
            assert told == who or f"already to {holders[k]!r}" in told


def _enroll_batch(url: str, badges: list[str], enrolled) -> None:
    """What the process that is killed does: a batch in small transactions, telling after each how far it is."""
    batch.CHUNK = 5
    with open_registry(url, create=True) as registry:
        registry.enroll_many(map(badge_from_json, badges), lambda done, total: enrolled.put(done))


def test_kill_leaves_old_or_new_state(url, rng):
    """Catches: a record without its entry, a chain cut short, a lock that outlives its process, a batch that cannot be
    run again."""
    badge = badge_of("Ada")
    badges = [_renamed(badge, f"Al {k:03}", k) for k in range(150)]
    context = multiprocessing.get_context("spawn")
    for _ in range(4):
        told = context.Queue()
        process = context.Process(target=_enroll_batch, args=(url, badges, told))
        process.start()
        for _ in range(int(rng.integers(1, 8))):
            told.get(timeout=120)
        time.sleep(rng.uniform(0, 0.03))
        process.kill()
        process.join(timeout=30)
        with open_registry(url, create=False) as registry:
            seen = registry.audit()
            assert seen.sound and seen.entries == seen.records + 1
            assert seen.records % 5 == 0
            assert [record.name for record in registry.records()] == [f"Al {k:03}" for k in range(seen.records)]
    with open_registry(url, create=False) as registry:
        done = registry.enroll_many(map(badge_from_json, badges))
        assert (done.enrolled, done.unchanged) == (150 - seen.records, seen.records)
        assert registry.audit().sound


def test_batch_and_single_enrolments_at_once(url):
    """Catches: a batch that holds the registry for itself until its end."""
    badge = badge_of("Ada")
    with open_registry(url, create=True) as first, open_registry(url, create=False) as second:

        def issue():
            for k in range(4):
                yield badge_from_json(_renamed(badge, f"Al {k}", k))
                second.enroll(badge_from_json(_renamed(badge, f"Bo {k}", 100 + k)))

        first.enroll_many(issue())
        seen = first.audit()
    assert seen.sound and seen.records == 8
