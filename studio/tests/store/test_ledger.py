"""Who may do a job, and whose result counts.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from moireid.errors import RegistryError, SpecError
from moireid_studio.store import ledger as module
from moireid_studio.store.database import Away, Database, database_of, is_away, jobs, patiently
from moireid_studio.store.job import Job
from moireid_studio.store.ledger import LEASE_S, Ledger
from moireid_studio.store.verdict_store import Verdicts

Process = Callable[[], Ledger]


def submitted(ledger: Ledger, owner: str = "one", kind: str = "verify") -> Job:
    """A job that waits."""
    job = ledger.admit(kind, owner, "verifier", lambda held: True)
    assert job is not None
    job.video, job.wish = "film.mp4", {"claim": "Ada"}
    assert ledger.submit(job)
    return job


def later(database: Database, seconds: float) -> None:
    """Let so much time pass for all jobs."""
    with database.writing() as connection:
        connection.execute(update(jobs).values(lease=jobs.c.lease - seconds))


def judged(job: Job) -> Job:
    job.result = {"verdict": "accept"}
    return job


def test_each_job_is_taken_once(process: Process) -> None:
    """Catches: two workers that read the same row before either has written; one that is left over."""
    ledgers = [process() for _ in range(4)]
    made = {submitted(ledgers[0], f"owner {k}").id for k in range(40)}
    taken: list[str] = []

    def work(ledger: Ledger) -> None:
        while (job := ledger.take(("judge",))) is not None:
            taken.append(job.id)

    threads = [threading.Thread(target=work, args=(one,)) for one in ledgers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert Counter(taken) == Counter(made)


def test_the_last_place_is_given_once(process: Process) -> None:
    """Catches: two studios that count at the same moment and both find a place."""
    ledgers, got = [process() for _ in range(4)], []

    def ask(ledger: Ledger) -> None:
        for _ in range(5):
            got.append(ledger.admit("verify", "one", "verifier", lambda held: sum(one.count for one in held) < 7))

    threads = [threading.Thread(target=ask, args=(one,)) for one in ledgers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(job is not None for job in got) == 7


def test_a_worker_that_comes_back_changes_nothing(process: Process, database: Database) -> None:
    """Catches: a result of a worker whose job was given to another; a job that goes on for ever."""
    first, second = process(), process()
    submitted(first)
    job = first.take(("judge",))
    assert job is not None and second.take(("judge",)) is None
    later(database, LEASE_S + 1)
    again = second.take(("judge",))
    assert again is not None and again.id == job.id and again.taken == 2
    assert not first.progress(job) and not first.settle(judged(job)) and not first.give_back(job, counts=False)
    # Not even one that says that it lives takes it back.
    first.beat(1000.0)
    assert second.settle(judged(again))
    second.close(again)
    found = first.find(job.id)
    assert found is not None and found.state == "done" and found.result == {"verdict": "accept"}
    assert not second.settle(judged(again))


def test_the_same_process_knows_its_second_beginning_from_its_first(process: Process, database: Database) -> None:
    """Catches: a holder's name alone, by which a thread that hung settles what another thread does."""
    ledger = process()
    submitted(ledger)
    hung = ledger.take(("judge",))
    later(database, LEASE_S + 1)
    again = ledger.take(("judge",))
    assert hung is not None and again is not None
    assert not ledger.settle(judged(hung)) and ledger.settle(judged(again))


def test_a_worker_that_lives_keeps_its_job(process: Process, database: Database) -> None:
    """Catches: a lease that is never renewed; one that a hung worker keeps for ever."""
    first, second = process(), process()
    submitted(first)
    assert first.take(("judge",)) is not None
    later(database, LEASE_S - 1)
    first.beat(1000.0)
    later(database, LEASE_S - 1)
    assert second.take(("judge",)) is None
    first.beat(0.0)
    later(database, 2.0)
    assert second.take(("judge",)) is not None


def test_a_job_that_dies_twice_is_done_no_more(process: Process, database: Database) -> None:
    """Catches: a film that ends one worker after another; an event that is issued a second time."""
    ledger = process()
    job, event = submitted(ledger), submitted(ledger, kind="event")
    for lanes in (("issue",), ("judge",), ("judge",)):
        assert ledger.take(lanes) is not None
        later(database, LEASE_S + 1)
    assert ledger.take(("judge", "issue")) is None
    lost = ledger.lost(1000.0)
    assert {one.id for one in lost} == {job.id, event.id}
    assert all(one.problem is not None and one.problem[0] == "crash" for one in lost)


def test_what_was_settled_by_a_lost_process_is_closed_and_not_done_again(process: Process, database: Database) -> None:
    """Catches: a verdict that is given, and its film judged again."""
    first, second = process(), process()
    submitted(first)
    job = first.take(("judge",))
    assert job is not None and first.settle(judged(job))
    later(database, LEASE_S + 1)
    assert second.take(("judge",)) is None
    (found,) = second.lost(1000.0)
    assert found.id == job.id and found.result == {"verdict": "accept"}
    second.close(found)
    assert second.states([job.id]) == {job.id: "done"}


def test_one_with_many_films_does_not_keep_others_waiting(process: Process) -> None:
    """Catches: a queue in which the first comer's hundredth film comes before another's first, and an issuer's."""
    ledger = process()
    for _ in range(5):
        submitted(ledger, "many")
    submitted(ledger, "few")
    submitted(ledger, "issuer", "capture")
    order = [job.owner for job in iter(lambda: ledger.take(("judge", "issue")), None)]
    assert order[0] == "issuer" and "few" in order[1:3] and order[3:] == ["many"] * 4


def test_times_are_the_database_s_own(process: Process, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a machine whose clock is an hour ahead, which takes every job from those that work on them."""
    first, ahead = process(), process()
    submitted(first)
    assert first.take(("judge",)) is not None
    import time

    real = time.time
    monkeypatch.setattr(time, "time", lambda: real() + 3600)
    monkeypatch.setattr(time, "monotonic", lambda: real() + 3600)
    assert ahead.take(("judge",)) is None and ahead.lost(1000.0) == []


def test_a_job_that_was_removed_stays_removed(process: Process) -> None:
    """Catches: a result that makes a removed job anew; a submission of one that is gone."""
    ledger = process()
    job = submitted(ledger)
    taken = ledger.take(("judge",))
    assert taken is not None
    ledger.remove(job.id)
    assert not ledger.progress(taken) and not ledger.settle(judged(taken)) and ledger.find(job.id) is None
    coming = ledger.admit("verify", "one", "verifier", lambda held: True)
    assert coming is not None
    ledger.remove(coming.id)
    assert not ledger.submit(coming)


def test_words_that_no_database_takes_come_back_as_they_went(process: Process) -> None:
    """Catches: a process of a film whose NUL or half letter ends the thread that writes its result."""
    ledger = process()
    submitted(ledger)
    job = ledger.take(("judge",))
    assert job is not None
    job.result = {"verdict": "accept", "text": "\x00\ud800 é"}
    assert ledger.settle(job)
    ledger.close(job)
    found = ledger.find(job.id)
    assert found is not None and found.result == job.result


def test_a_verdict_is_written_down_once(tmp_path: Path, database: Database, postgres: Any) -> None:
    """Catches: a record with two lines for a film that was judged again after its worker was lost."""
    state = postgres.fresh() if database.shared else None
    both = [Verdicts(tmp_path / "a", 365.0, state), Verdicts(tmp_path / "a", 365.0, state)]
    job = Job("0" * 32, "verify", "token", tmp_path, result={"verdict": "accept"})
    for store in (*both, *both):
        store.note_job(job)
    assert [one.verdict for one in both[0].given(9)] == ["accept"]
    for _ in range(2):
        # Live checks have no job, and each counts.
        both[0].note_result("token", "live", {"verdict": "reject"}, film_sha256=None, standing=None)
    assert len(both[1].given(9)) == 3


def test_a_worker_waits_for_a_database_that_is_away(monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_an_old_file_of_verdicts_gains_what_it_lacks(tmp_path: Path) -> None:
    """Catches: a studio that was brought up to date and can write no verdict down any more."""
    import sqlite3

    with sqlite3.connect(tmp_path / "verdicts.sqlite3") as raw:
        raw.execute(
            "CREATE TABLE verdicts (number INTEGER PRIMARY KEY, at TEXT NOT NULL, token TEXT NOT NULL,"
            " kind TEXT NOT NULL, film_sha256 TEXT, claim TEXT, claim_source TEXT, verdict TEXT NOT NULL,"
            " read TEXT, registry TEXT,"
            " moireid TEXT NOT NULL)"
        )
    store = Verdicts(tmp_path, 365.0)
    job = Job("0" * 32, "verify", "token", tmp_path, result={"verdict": "accept"})
    store.note_job(job)
    store.note_job(job)
    assert len(store.given(9)) == 1


def test_a_file_is_not_shared(tmp_path: Path) -> None:
    """Catches: two studios on one file, each of which takes the other's jobs for left over."""
    with pytest.raises(SpecError, match="one studio"):
        database_of(tmp_path, "jobs.sqlite3", f"sqlite:///{tmp_path}/shared.sqlite3")


def test_leases_and_beats_fit() -> None:
    """Catches: a worker that is taken for lost because one word of it was late."""
    assert module.BEAT_S * 3 < module.LEASE_S
