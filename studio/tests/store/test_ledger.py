"""Who may do a job, and whose result counts.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text, update

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


def test_a_film_outlives_any_number_of_workers(process: Process, database: Database) -> None:
    """Catches: a film that is given up after some lost workers, for which it need not be to blame; kills that are not
    counted, or count as faults of the storage; a pause that does not grow, so that a film that kills keeps all busy.
    """
    ledger = process()
    submitted(ledger)
    for kills in range(12):
        job = process().take(("judge",))
        assert job is not None and (job.kills, job.taken) == (kills, kills + 1)
        pause_s = module.PAUSE_S * 2 ** min(kills, module.PAUSES)
        later(database, LEASE_S + 0.3 * pause_s)
        assert ledger.take(("judge",)) is None and not ledger.lost(3600.0)
        later(database, pause_s)
    assert ledger.lost_workers() == 12
    job = ledger.take(("judge",))
    assert job is not None and job.taken - job.kills == 1 < job.tries
    assert ledger.settle(judged(job))


def test_films_that_lose_workers_come_last_and_one_at_a_time(process: Process, database: Database) -> None:
    """Catches: a film that kills workers and comes before others for ever; several such films that take every worker;
    an honest film that shares a worker with such a film each time, so that it dies with it.
    """
    ledger = process()
    first, second = submitted(ledger, "one"), submitted(ledger, "two")
    for _ in range(module.SUSPECT):
        assert {job.id for job in iter(lambda: process().take(("judge",)), None)} == {first.id, second.id}
        later(database, LEASE_S + 10.0)
    third = submitted(ledger, "three")
    newest = ledger.take(("judge",))
    assert newest is not None and newest.id == third.id and ledger.settle(judged(newest))
    suspect = process().take(("judge",))
    assert suspect is not None and suspect.id == first.id and process().take(("judge",)) is None
    later(database, LEASE_S + 1)
    other = process().take(("judge",))
    assert other is not None and other.id == second.id and other.kills == module.SUSPECT


def test_a_studio_that_is_started_again_waits_before_it_reads_what_ended_it(
    process: Process, database: Database
) -> None:
    """Catches: a film that ends its studio, which reads it at once at each start and is never reached again."""
    submitted(process())
    assert process().take(("judge",)) is not None
    again = process()
    again.disown()
    assert again.take(("judge",)) is None
    later(database, module.PAUSE_S)
    assert again.take(("judge",)) is not None


def test_badges_of_a_list_are_made_once_and_old_films_are_ended(process: Process, database: Database) -> None:
    """Catches: an event that is issued a second time; a film that no worker survives and that stays for ever."""
    ledger = process()
    job, event = submitted(ledger), submitted(ledger, kind="event")
    assert [one.kind for one in iter(lambda: ledger.take(("judge", "issue")), None)] == ["event", "verify"]
    later(database, LEASE_S + 100)
    assert [one.id for one in ledger.lost(1000.0)] == [event.id]
    with database.writing() as connection:
        connection.execute(update(jobs).where(jobs.c.id == job.id).values(made=jobs.c.made - 1001))
    ended = {one.id: one.problem for one in ledger.lost(1000.0)}
    assert ended.keys() == {job.id, event.id} and all(why is not None and why[0] == "stopped" for why in ended.values())


def test_jobs_of_an_older_studio_are_taken_over(tmp_path: Path) -> None:
    """Catches: a table without the count of lost workers, which ends every studio after an update."""
    database = database_of(tmp_path, "jobs.sqlite3", None)
    Ledger(database, tmp_path)
    with database.writing() as connection:
        connection.execute(text("ALTER TABLE jobs DROP COLUMN kills"))
    job = submitted(Ledger(database, tmp_path))
    assert Ledger(database, tmp_path).find(job.id) is not None
    database.close()


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
