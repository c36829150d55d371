"""The steps of a job, as the database has them: short transactions, in which a process that lost a job changes nothing.

A worker takes a job for a while and reports again and again that it is alive.  Where it falls silent, another takes
the job; the first one's result then counts no more, as holder and number of the beginning must still be its own.
PostgreSQL: FOR UPDATE SKIP LOCKED.  SQLite: one writer at a time.

A worker that was lost is counted (`kills`) and is no fault of the film: only a worker that survived can report that the
film's own process failed.  So the job is taken again, however often, each time after a longer pause.  From `SUSPECT`
lost workers on all other jobs come first, and one such job is at work at a time: a film that does kill workers then
ends one after the other, alone, and none that merely shared a worker with it stays suspect.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, case, delete, func, insert, inspect, or_, select, text, update
from sqlalchemy import literal as number

from moireid_studio.store.database import PLACES_LOCK, Database, jobs, metadata
from moireid_studio.store.job import STATES, Job, JobCounts, Lane, State, job_of

#: A holder that was silent for so long has lost its jobs; it reports that it is alive each `BEAT_S`, s.
LEASE_S, BEAT_S = 30.0, 5.0
#: A job whose film could not be fetched is tried again after this.
AGAIN_S = 10.0
#: A job whose worker was lost is taken again after this, doubled with each further loss up to `PAUSES` times, s.
PAUSE_S, PAUSES = 1.0, 8
#: A job that lost so many workers may be the cause.
SUSPECT = 2
OPEN = ("receiving", "waiting", "working")
LOST = (
    "stopped",
    "The process that made these badges was lost; the registry shows which ones it issued, so order the others again.",
)
OLD = ("stopped", "This film has waited for too long, and was removed; send it again.")


class Ledger:
    """The jobs of a database, for one process; safe to use from any thread."""

    def __init__(self, database: Database, folder: Path) -> None:
        """Make the table of jobs where it is absent.

        Parameters
        ----------
        folder
            For films as they come.

        Raises
        ------
        RegistryError
            Where the table cannot be made.
        """
        self.database, self._folder = database, folder
        #: Who this process is to the others.
        self.holder = secrets.token_hex(8)
        database.make(metadata, _bring_up)

    def admit(self, kind: str, owner: str, role: str, fits: Callable[[list[JobCounts]], bool]) -> Job | None:
        """A new job that receives its film, where its places allow for it; None where they do not."""
        job_id = secrets.token_hex(16)
        job = Job(job_id, kind, owner, self._folder / job_id, role, holder=self.holder)
        with self.database.writing() as connection:
            # Two studios that count at the same moment would both find the last place.
            self.database.alone(connection, PLACES_LOCK)
            if not fits(_held(connection)):
                return None
            new: dict[str, Any] = {"id": job_id, "kind": kind, "lane": job.lane, "owner": owner, "role": role}
            new |= {"state": "receiving"}
            new |= {"turn": 0, "made": self.database.now, "tries": job.tries, "taken": 0, "holder": self.holder}
            new |= {"lease": self._until(LEASE_S), "bytes": 0, "read": 0, "wish": "{}", "about": job.about()}
            connection.execute(insert(jobs).values(new))
        return job

    def submit(self, job: Job) -> bool:
        """Let a job wait for a worker, with its wish and its film's name; False where it was removed meanwhile."""
        before = select(func.count()).where(jobs.c.owner == job.owner, jobs.c.state.in_(("waiting", "working")))
        values: dict[str, Any] = {"state": "waiting", "holder": None, "lease": 0.0}
        values |= {"turn": before.scalar_subquery(), "lane": job.lane}
        values |= {"kind": job.kind, "video": job.video, "bytes": job.bytes, "tries": job.tries}
        values |= {"wish": json.dumps(job.wish), "about": job.about()}
        return self._change(and_(jobs.c.id == job.id, jobs.c.state == "receiving"), values)

    def keep(self, job: Job) -> bool:
        """End a job that no worker does, with its file or its result; False where it was removed meanwhile."""
        values: dict[str, Any] = {"state": "done", "holder": None, "lease": 0.0, "ended": self.database.now}
        values |= {"result": _json(job.result), "about": job.about()}
        return self._change(and_(jobs.c.id == job.id, jobs.c.state == "receiving"), values | {"bytes": job.bytes})

    def take(self, lanes: Sequence[Lane]) -> Job | None:
        """The next job for a worker of these lanes, now this process's own; None where there is none.

        Suspects come last.  Issuing comes first.  Then each owner's first job comes before any owner's second, so that
        one with many films does not keep the others waiting.
        """
        free = and_(self._free(), jobs.c.lane.in_(lanes))
        # Most looks find nothing, and need no lock.
        if not self.database.rows(select(jobs.c.id).where(free).limit(1)):
            return None
        suspect = case((self._lost() >= SUSPECT, 1), else_=0)
        order = (suspect, case((jobs.c.lane == "issue", 0), else_=1), jobs.c.turn, jobs.c.made, jobs.c.id)
        next_one = select(jobs).where(free).order_by(*order).limit(1).with_for_update(skip_locked=True)
        with self.database.writing() as connection:
            row = connection.execute(next_one).mappings().first()
            if row is None:
                return None
            mine: dict[str, Any] = {"state": "working", "holder": self.holder, "taken": row["taken"] + 1}
            mine["kills"] = row["kills"] + (row["state"] == "working")
            own = {**row, **mine}
            mine |= {"taken_at": self.database.now, "lease": self._until(LEASE_S), "read": 0, "expected": None}
            connection.execute(update(jobs).where(jobs.c.id == row["id"]).values(mine))
        return job_of(own, self._folder)

    def beat(self, most_s: float) -> None:
        """Report that this process is alive, for all jobs that it receives or does but those begun longer ago."""
        young = or_(jobs.c.taken_at.is_(None), jobs.c.taken_at > self.database.now - most_s)
        self._change(
            and_(jobs.c.holder == self.holder, jobs.c.state.in_(("receiving", "working")), young),
            {"lease": self._until(LEASE_S)},
        )

    def progress(self, job: Job) -> bool:
        """Write down how far a job has come; False where it is this process's no more."""
        return self._change(self._mine(job), {"read": job.frames[0], "expected": job.frames[1]})

    def settle(self, job: Job) -> bool:
        """Write down what came out; False, and nothing is written, where the job is this process's no more."""
        values: dict[str, Any] = {"settled": "done" if job.problem is None else "failed", "about": job.about()}
        values |= {"result": _json(job.result), "kept": _json(job.kept), "problem": _json(job.problem)}
        values |= {"lease": self._until(LEASE_S), "read": job.frames[0], "expected": job.frames[1]}
        return self._change(self._mine(job), values)

    def close(self, job: Job) -> None:
        """End a settled job, once what was left of it is tidied up."""
        values = {"state": jobs.c.settled, "ended": self.database.now, "holder": None}
        self._change(and_(jobs.c.id == job.id, jobs.c.state == "working", jobs.c.settled.is_not(None)), values)

    def give_back(self, job: Job, *, counts: bool) -> bool:
        """Let others do a job; counts: whether this was one of the times that it may be begun."""
        taken, wait_s = (job.taken, AGAIN_S) if counts else (job.taken - 1, 0.0)
        return self._change(
            self._mine(job),
            {"state": "waiting", "holder": None, "taken": taken, "lease": self._until(wait_s)},
        )

    def lost(self, keep_s: float) -> list[Job]:
        """Jobs that are to be tidied up and closed: lost and never begun again, or settled by a process that was lost
        then, or waiting, also for a worker after one that was lost, for longer than `keep_s`.
        """
        late = and_(jobs.c.state == "working", jobs.c.lease < self.database.now, jobs.c.settled.is_(None))
        self._change(and_(late, jobs.c.tries == 1), {"settled": "failed", "problem": _json(LOST)})
        forgotten = and_(or_(jobs.c.state == "waiting", late), jobs.c.made < self.database.now - keep_s)
        self._change(forgotten, {"state": "working", "settled": "failed", "problem": _json(OLD)})
        done = and_(jobs.c.state == "working", jobs.c.settled.is_not(None), jobs.c.lease < self.database.now)
        return self._find(done)

    def abandoned(self) -> list[Job]:
        """Jobs whose film was coming to a process that was lost."""
        return self._find(and_(jobs.c.state == "receiving", jobs.c.lease < self.database.now))

    def disown(self) -> None:
        """Take from every other process what it holds; for a database that has one process alone.

        The pause after a lost worker begins now: a film that ends this process would end it again at each start.
        """
        others = and_(jobs.c.state.in_(("receiving", "working")), jobs.c.holder != self.holder)
        self._change(others, {"lease": case((jobs.c.state == "working", self.database.now), else_=0.0)})

    def find(self, job_id: str) -> Job | None:
        """A job by its id."""
        found = self._find(jobs.c.id == job_id)
        return found[0] if found else None

    def states(self, ids: Iterable[str]) -> dict[str, State]:
        """The states of those among these jobs that are there."""
        query = select(jobs.c.id, jobs.c.state).where(jobs.c.id.in_(list(ids)))
        return {row["id"]: row["state"] for row in self.database.rows(query)}

    def remove(self, job_id: str) -> None:
        """Forget a job; a process that works on it finds out."""
        self.database.change(delete(jobs).where(jobs.c.id == job_id))

    def over(self) -> list[tuple[str, str, float]]:
        """Jobs that have ended, the newest first: id, owner, and s since then."""
        age = (self.database.now - jobs.c.ended).label("age")
        query = select(jobs.c.id, jobs.c.owner, age).where(jobs.c.state.in_(("done", "failed"))).order_by(age)
        return [(row["id"], row["owner"], float(row["age"] or 0.0)) for row in self.database.rows(query)]

    def counts(self) -> dict[str, float]:
        """How many jobs there are in each state."""
        query = select(jobs.c.state, func.count().label("many")).group_by(jobs.c.state)
        found = {row["state"]: int(row["many"]) for row in self.database.rows(query)}
        return {state: found.get(state, 0) for state in STATES}

    def lost_workers(self) -> float:
        """How many workers were lost while they had one of these jobs."""
        query = select(func.sum(self._lost()).label("many"))
        return float(self.database.rows(query)[0]["many"] or 0)

    def stored(self) -> dict[str, int]:
        """Bytes of films that are stored, by owner."""
        size = func.sum(jobs.c.bytes).label("size")
        query = select(jobs.c.owner, size).where(jobs.c.bytes > 0).group_by(jobs.c.owner)
        return {row["owner"]: int(row["size"]) for row in self.database.rows(query)}

    def drop_film(self, job: Job) -> None:
        """A job's film is stored no more, but only so many bytes."""
        self._change(jobs.c.id == job.id, {"bytes": job.bytes})

    def _free(self) -> ColumnElement[bool]:
        """Of a job: it may be taken now."""
        doubled = case((jobs.c.kills < PAUSES, number(1).bitwise_lshift(jobs.c.kills)), else_=1 << PAUSES)
        at_work = jobs.alias()
        another = select(at_work.c.id).where(
            at_work.c.state == "working",
            at_work.c.settled.is_(None),
            at_work.c.kills >= SUSPECT,
            at_work.c.lease > self.database.now,
        )
        return and_(
            jobs.c.state.in_(("waiting", "working")),
            jobs.c.settled.is_(None),
            or_(jobs.c.state == "waiting", jobs.c.tries > 1),
            jobs.c.lease + case((jobs.c.state == "working", PAUSE_S * doubled), else_=0.0) <= self.database.now,
            or_(self._lost() < SUSPECT, ~another.exists()),
        )

    def _lost(self) -> ColumnElement[int]:
        """How many workers were lost with a job, the present one too where it was silent for too long."""
        silent = and_(jobs.c.state == "working", jobs.c.settled.is_(None), jobs.c.lease <= self.database.now)
        return jobs.c.kills + case((silent, 1), else_=0)

    def _mine(self, job: Job) -> ColumnElement[bool]:
        """Of a job: this process has it, by that very beginning, and has not settled it."""
        return and_(
            jobs.c.id == job.id,
            jobs.c.state == "working",
            jobs.c.holder == job.holder,
            jobs.c.taken == job.taken,
            jobs.c.settled.is_(None),
        )

    def _until(self, seconds: float) -> ColumnElement[float]:
        return self.database.now + seconds

    def _change(self, where: ColumnElement[bool], values: Mapping[str, Any]) -> bool:
        return self.database.change(update(jobs).where(where).values(dict(values))) > 0

    def _find(self, where: ColumnElement[bool]) -> list[Job]:
        return [job_of(row, self._folder) for row in self.database.rows(select(jobs).where(where))]


def _bring_up(connection: Connection) -> None:
    """Add what older versions of the table lack."""
    if "kills" not in {column["name"] for column in inspect(connection).get_columns(jobs.name)}:
        connection.execute(text("ALTER TABLE jobs ADD COLUMN kills INTEGER NOT NULL DEFAULT 0"))


def _held(connection: Connection) -> list[JobCounts]:
    receiving = (jobs.c.state == "receiving").label("receiving")
    query = select(jobs.c.owner, jobs.c.role, receiving, func.count()).where(jobs.c.state.in_(OPEN))
    rows = connection.execute(query.group_by(jobs.c.owner, jobs.c.role, receiving))
    return [JobCounts(owner, role, bool(coming), count) for owner, role, coming, count in rows]


def _json(value: Any) -> str | None:
    return None if value is None else json.dumps(value)
