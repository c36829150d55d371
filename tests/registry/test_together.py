"""Several processes at once.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from kit.enrolling import enroll_many, prepared, renamed
from kit.registries import badge_of, url_of
from moireid.registry import open_registry


@pytest.mark.slow
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


def _run_together(url: str, keys: Path, lists: list[list[str]]) -> list[list[str]]:
    context = prepared()
    ready, results = context.Barrier(len(lists)), context.Queue()
    processes = [context.Process(target=enroll_many, args=(url, str(keys), badges, ready, results)) for badges in lists]
    for process in processes:
        process.start()
    outcomes = [results.get(timeout=120) for _ in processes]
    for process in processes:
        process.join(timeout=30)
        assert process.exitcode == 0
    return outcomes


@pytest.mark.slow
def test_two_processes_lose_nothing(url, keys):
    """Catches: 'database is locked', tables made twice, a row or a log entry lost to a read-modify-write."""
    badge = badge_of("Ada")
    lists = [[renamed(badge, f"{who} {k:02}", 1000 * p + k) for k in range(50)] for p, who in enumerate(("Al", "Bo"))]
    outcomes = _run_together(url, keys, lists)
    expected = [f"{who} {k:02}" for who in ("Al", "Bo") for k in range(50)]
    assert sorted(name for outcome in outcomes for name in outcome) == expected
    with open_registry(url, create=False) as registry:
        assert [record.name for record in registry.records()] == expected
        seen = registry.audit()
    assert seen.sound and (seen.records, seen.entries) == (100, 101)
