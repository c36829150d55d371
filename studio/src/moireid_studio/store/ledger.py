"""The jobs of one studio as its table has them, in short transactions.

One studio at a time has the table (`studio.hold_folder`), so no job is ever at work twice.  What a studio that was
killed had at work is done again by the next one that starts (`recover`), which is no fault of the film; a film that was
at work each time that a studio was killed is given up after `TRIES`, so that none can keep a studio from starting.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, case, delete, func, insert, select, update

from moireid_studio.store.database import Database, jobs, metadata
from moireid_studio.store.job import STATES, Job, JobCounts, Lane, job_of

OPEN = ("receiving", "waiting", "working")
#: How often a job is begun at most, if its studio is killed each time.  An event's identities are drawn as it is made:
#: begun again, it would issue all of them anew.
TRIES, TRIES_OF_EVENT = 3, 1
LOST = (
    "stopped",
    "The studio ended while it did this. Of badges, the registry shows which ones were issued; order the others again. "
    "A film may be sent again.",
)
OLD = ("stopped", "This film has waited for too long, and was removed; send it again.")


class Ledger:
    """The table of jobs; safe to use from any thread."""

    def __init__(self, database: Database, folder: Path) -> None:
        """Make the table where it is absent; folder: that of all jobs.  Raises: RegistryError."""
        self.database, self.folder = database, folder
        database.make(metadata)

    def recover(self) -> None:
        """Take up what a studio left that was killed; called before any job is begun."""
        self.database.change(delete(jobs).where(jobs.c.state == "receiving"))
        most = case((jobs.c.kind == "event", TRIES_OF_EVENT), else_=TRIES)
        self._change(and_(jobs.c.state == "working", jobs.c.taken >= most), _failed(LOST))
        self._change(jobs.c.state == "working", {"state": "waiting"})

    def admit(self, kind: str, owner: str, role: str, fits: Callable[[list[JobCounts]], bool]) -> Job | None:
        """A new job that receives its film, where its places allow for it; None where they do not."""
        job_id = secrets.token_hex(16)
        job = Job(job_id, kind, owner, self.folder / job_id, role)
        with self.database.writing() as connection:
            if not fits(_held(connection)):
                return None
            new: dict[str, Any] = {"id": job_id, "kind": kind, "lane": job.lane, "owner": owner, "role": role}
            new |= {"state": "receiving", "turn": 0, "made": time.time(), "taken": 0, "bytes": 0, "read": 0}
            connection.execute(insert(jobs).values(new | {"wish": {}, "about": job.about()}))
        return job

    def submit(self, job: Job) -> bool:
        """Let a job wait, with its wish and its film's name; False where it was removed meanwhile."""
        before = select(func.count()).where(jobs.c.owner == job.owner, jobs.c.state.in_(("waiting", "working")))
        values: dict[str, Any] = {"state": "waiting", "turn": before.scalar_subquery(), "lane": job.lane}
        values |= {"kind": job.kind, "video": job.video, "bytes": job.bytes}
        values |= {"wish": job.wish, "about": job.about()}
        return self._change(and_(jobs.c.id == job.id, jobs.c.state == "receiving"), values)

    def keep(self, job: Job) -> bool:
        """End a job that no thread does, with its file or its result; False where it was removed meanwhile."""
        values: dict[str, Any] = {"state": "done", "ended": time.time(), "result": job.result}
        values |= {"about": job.about(), "bytes": job.bytes}
        return self._change(and_(jobs.c.id == job.id, jobs.c.state == "receiving"), values)

    def take(self, lanes: Sequence[Lane]) -> Job | None:
        """The next job of these lanes, now at work; None where there is none.

        Issuing comes first.  Then each owner's first job comes before any owner's second, so that one with many films
        does not keep the others waiting.
        """
        order = (case((jobs.c.lane == "issue", 0), else_=1), jobs.c.turn, jobs.c.made, jobs.c.id)
        next_one = select(jobs).where(jobs.c.state == "waiting", jobs.c.lane.in_(lanes)).order_by(*order).limit(1)
        with self.database.writing() as connection:
            row = connection.execute(next_one).mappings().first()
            if row is None:
                return None
            mine: dict[str, Any] = {"state": "working", "taken": row["taken"] + 1, "read": 0, "expected": None}
            connection.execute(update(jobs).where(jobs.c.id == row["id"]).values(mine))
        return job_of({**row, **mine}, self.folder)

    def progress(self, job: Job) -> bool:
        """Write down how far a job has come; False where it was removed meanwhile."""
        return self._change(_at_work(job), {"read": job.frames[0], "expected": job.frames[1]})

    def settle(self, job: Job) -> bool:
        """End a job with what came out; False where it was removed meanwhile."""
        values: dict[str, Any] = {"state": "done" if job.problem is None else "failed", "ended": time.time()}
        values |= {"result": job.result, "kept": job.kept, "problem": job.problem}
        values |= {"read": job.frames[0], "expected": job.frames[1], "bytes": job.bytes, "about": job.about()}
        return self._change(_at_work(job), values)

    def give_back(self, job: Job) -> bool:
        """Let a job wait again that was stopped and is to be done later."""
        return self._change(_at_work(job), {"state": "waiting", "taken": job.taken - 1})

    def end_old(self, keep_s: float) -> None:
        """End jobs that have waited for longer than `keep_s`."""
        late = and_(jobs.c.state == "waiting", jobs.c.made < time.time() - keep_s)
        self._change(late, _failed(OLD))

    def find(self, job_id: str) -> Job | None:
        """A job by its id."""
        rows = self.database.rows(select(jobs).where(jobs.c.id == job_id))
        return job_of(rows[0], self.folder) if rows else None

    def old_films(self) -> dict[str, str | None]:
        """All jobs by their ids, with the name of the film of each that is over."""
        film = case((jobs.c.state.in_(OPEN), None), else_=jobs.c.video).label("film")
        return {row["id"]: row["film"] for row in self.database.rows(select(jobs.c.id, film))}

    def remove(self, job_id: str) -> None:
        """Forget a job; a thread that works on it finds out."""
        self.database.change(delete(jobs).where(jobs.c.id == job_id))

    def over(self) -> list[tuple[str, str, float]]:
        """Jobs that have ended, the newest first: id, owner, and s since then."""
        query = select(jobs.c.id, jobs.c.owner, jobs.c.ended).where(jobs.c.state.in_(("done", "failed")))
        now, rows = time.time(), self.database.rows(query.order_by(jobs.c.ended.desc()))
        return [(row["id"], row["owner"], now - row["ended"]) for row in rows]

    def counts(self) -> dict[str, float]:
        """How many jobs there are in each state."""
        query = select(jobs.c.state, func.count().label("many")).group_by(jobs.c.state)
        found = {row["state"]: int(row["many"]) for row in self.database.rows(query)}
        return {state: found.get(state, 0) for state in STATES}

    def stored(self) -> dict[str, int]:
        """Bytes of films and of what is kept, by owner."""
        size = func.sum(jobs.c.bytes).label("size")
        query = select(jobs.c.owner, size).where(jobs.c.bytes > 0).group_by(jobs.c.owner)
        return {row["owner"]: int(row["size"]) for row in self.database.rows(query)}

    def _change(self, where: ColumnElement[bool], values: Mapping[str, Any]) -> bool:
        return self.database.change(update(jobs).where(where).values(dict(values))) > 0


def _at_work(job: Job) -> ColumnElement[bool]:
    return and_(jobs.c.id == job.id, jobs.c.state == "working")


def _failed(why: tuple[str, str]) -> dict[str, Any]:
    return {"state": "failed", "problem": why, "ended": time.time(), "bytes": 0}


def _held(connection: Connection) -> list[JobCounts]:
    receiving = (jobs.c.state == "receiving").label("receiving")
    query = select(jobs.c.owner, jobs.c.role, receiving, func.count()).where(jobs.c.state.in_(OPEN))
    rows = connection.execute(query.group_by(jobs.c.owner, jobs.c.role, receiving))
    return [JobCounts(owner, role, bool(coming), count) for owner, role, coming, count in rows]
