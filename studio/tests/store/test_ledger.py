"""The steps of a job.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from moireid.errors import RegistryError
from moireid_studio.store.database import Away, database_of, is_away, patiently
from moireid_studio.store.job import Job
from moireid_studio.store.ledger import TRIES, Ledger


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    database = database_of(tmp_path, "jobs.sqlite3", None, log=True)
    yield Ledger(database, tmp_path / "films")
    database.close()


def submitted(ledger: Ledger, owner: str = "one", kind: str = "verify") -> Job:
    """A job that waits."""
    job = ledger.admit(kind, owner, "verifier", lambda held: True)
    assert job is not None
    job.video, job.wish = "film.mp4", {"claim": "Ada"}
    assert ledger.submit(job)
    return job


def in_threads(work: object) -> None:
    threads = [threading.Thread(target=work) for _ in range(4)]  # type: ignore[arg-type]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def test_each_job_is_taken_once(ledger: Ledger) -> None:
    """Catches: two threads that read the same row before either has written; one that is left over."""
    made = {submitted(ledger, f"owner {k}").id for k in range(40)}
    taken: list[str] = []

    def work() -> None:
        while (job := ledger.take(("judge",))) is not None:
            taken.append(job.id)

    in_threads(work)
    assert Counter(taken) == Counter(made)


def test_the_last_place_is_given_once(ledger: Ledger) -> None:
    """Catches: two requests that count at the same moment and both find a place."""
    got: list[Job | None] = []

    def ask() -> None:
        for _ in range(5):
            got.append(ledger.admit("verify", "one", "verifier", lambda held: sum(one.count for one in held) < 7))

    in_threads(ask)
    assert sum(job is not None for job in got) == 7


def test_a_studio_that_was_killed_goes_on(ledger: Ledger) -> None:
    """Catches: a film that is lost with its studio, or half of one that stays; an event that is issued a second time; a
    film that ends its studio at every start.
    """
    film, event = submitted(ledger), submitted(ledger, kind="event")
    half = ledger.admit("verify", "one", "verifier", lambda held: True)
    assert half is not None and [ledger.take(("judge", "issue")) is not None for _ in range(3)] == [True, True, False]
    for left in range(TRIES - 1, -1, -1):
        ledger.recover()
        again = ledger.take(("judge",))
        assert (again is not None and again.id == film.id) is (left > 0)
    ended = [ledger.find(one.id) for one in (film, event)]
    assert [one and one.problem and one.problem[0] for one in ended] == ["stopped", "stopped"]
    assert ledger.find(half.id) is None


def test_one_with_many_films_does_not_keep_others_waiting(ledger: Ledger) -> None:
    """Catches: a queue in which the first comer's hundredth film comes before another's first, and an issuer's."""
    for _ in range(5):
        submitted(ledger, "many")
    submitted(ledger, "few")
    submitted(ledger, "issuer", "capture")
    order = [job.owner for job in iter(lambda: ledger.take(("judge", "issue")), None)]
    assert order[0] == "issuer" and "few" in order[1:3] and order[3:] == ["many"] * 4


def test_a_job_that_was_removed_stays_removed(ledger: Ledger) -> None:
    """Catches: a result that makes a removed job anew; a submission of one that is gone."""
    job = submitted(ledger)
    taken = ledger.take(("judge",))
    assert taken is not None
    ledger.remove(job.id)
    assert not ledger.progress(taken) and not ledger.settle(taken) and ledger.find(job.id) is None
    coming = ledger.admit("verify", "one", "verifier", lambda held: True)
    assert coming is not None
    ledger.remove(coming.id)
    assert not ledger.submit(coming)


def test_a_job_waits_for_a_database_that_is_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a result that is lost with a connection; one that waits for what will never come."""
    monkeypatch.setattr("moireid_studio.store.database.PAUSE_S", 0.0)
    tries: list[int] = []

    def away_twice() -> str:
        tries.append(1)
        if len(tries) < 3:
            raise Away("gone")
        return "back"

    assert patiently(away_twice) == "back" and len(tries) == 3

    def broken() -> None:
        tries.append(1)
        raise RegistryError("no such table")

    with pytest.raises(RegistryError):
        patiently(broken)
    assert len(tries) == 4 and not is_away(RegistryError("x"))
